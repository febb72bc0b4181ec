#pragma once
// What a scene's object is before it has a material: the coarsest tets and the surface that they carry, with all that was
// mended, lost or thickened on the way.
//
//     Shape shape = make_shape(scene);
//     std::cout << describe(shape);
//     auto model = build_model(scene, std::move(shape));      // build_model(scene) does both

#include <memory>
#include <optional>
#include <string>

#include "engine/mesh/imported_tets.hpp"
#include "engine/mesh/surface_repair.hpp"
#include "engine/mesh/volume_mesh.hpp"
#include "engine/simulation/simulation.hpp"

namespace tetfront {

struct Shape {
    TetMesh roots;
    SurfaceMesh surface;                            // empty: the boundary of the tree's leaves
    std::optional<SurfaceRepairs> surface_repairs;  // of a surface file
    std::optional<TetRepairs> tet_repairs;          // of a file of tets
    std::optional<VolumeMeshReport> meshing;        // when the tets were made for a surface
};

/// Throws InputError when a file cannot be read, nothing can be meshed, or the object would be too large for the scene's
/// levels or too far away.
Shape make_shape(const Scene& scene);
/// For people, a line for each thing; empty for a box.
std::string describe(const Shape& shape);

/// shape: make_shape(scene)'s. Otherwise as build_model(scene).
std::shared_ptr<const Model> build_model(Scene scene, Shape shape, const Progress& progress = {}, const CacheSettings& cache = {});

}  // namespace tetfront
