#include "tests/fuzz/harness.hpp"

#include <algorithm>

/// The two files of TetGen come as one, the second after a line "====".
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    return tetfront::fuzz_reader(data, size, [](std::string_view bytes) {
        constexpr std::string_view border = "\n====\n";
        const std::size_t at = std::min(bytes.find(border), bytes.size());
        const std::string_view second = bytes.substr(std::min(at + border.size(), bytes.size()));
        return tetfront::read_tetgen(bytes.substr(0, at), "fuzz.node", second, "fuzz.ele");
    });
}
