#pragma once
// What all fuzzers of mesh readers do: read the bytes, finish the mesh, and accept only InputError as a refusal.

#include "engine/base/error.hpp"
#include "engine/mesh/tet_readers.hpp"

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace tetfront {

template <class Read>
int fuzz_reader(const std::uint8_t* data, std::size_t size, const Read& read) {
    try {
        finish(read(std::string_view(reinterpret_cast<const char*>(data), size)), "fuzz", 1);
    } catch (const InputError&) {
        return 0;
    }
    return 0;
}

}  // namespace tetfront
