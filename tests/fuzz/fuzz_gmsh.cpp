#include "tests/fuzz/harness.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    return tetfront::fuzz_reader(data, size, [](std::string_view bytes) { return tetfront::read_gmsh(bytes, "fuzz"); });
}
