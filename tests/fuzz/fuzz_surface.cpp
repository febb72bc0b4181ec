#include "engine/mesh/surface_repair.hpp"
#include "engine/mesh/volume_mesh.hpp"
#include "tests/fuzz/harness.hpp"

#include <cstring>
#include <vector>

/// Not a file but the triangles themselves: 16 vertices on a small grid, so that they coincide, cross and degenerate.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace tetfront;
    SurfaceMesh surface;
    for (std::size_t v = 0; v < 16; ++v) {
        const std::uint8_t byte = v < size ? data[v] : 0;
        surface.positions.emplace_back(byte & 7, byte >> 3 & 7, byte >> 6);
    }
    for (std::size_t i = 16; i + 1 < size && surface.triangles.size() < 64; i += 2)
        surface.triangles.push_back({data[i] & 15, data[i] >> 4, data[i + 1] & 15});
    repair(surface);
    try {
        validate(mesh_volume(surface, {.target_tets = 20}).mesh);
    } catch (const InputError& error) {
        // A mesh must pass validate(): only mesh_volume() itself may refuse.
        if (error.where != "volume mesh") throw;
    }
    return 0;
}
