#pragma once
// A frame for a slow line: its arrays packed with meshoptimizer's vertex codec, which needs about 60 % of the bytes.
// PROTOCOL.md has the layout; the client gets the plain message back byte for byte.
//
//     std::string bytes = compress_frame(encode_frame(*frame, generation, sequence));

#include <string>
#include <string_view>

namespace tetfront {

/// plain: as encode_frame() makes it, with or without values.
std::string compress_frame(std::string_view plain);

}  // namespace tetfront
