#include "engine/simulation/shape.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include <Eigen/Geometry>

#include "engine/base/error.hpp"
#include "engine/material/voxel_surface.hpp"
#include "engine/mesh/mesh_io.hpp"
#include "engine/mesh/tet_file.hpp"
#include "engine/simulation/scene_material.hpp"

namespace tetfront {

namespace {

Shape read_shape(const Scene& scene) {
    Shape shape;
    if (const auto* box = std::get_if<BoxMeshSpec>(&scene.mesh)) {
        shape.roots = box_mesh(box->low, box->high, box->cells);
        return shape;
    }
    if (const auto* tets = std::get_if<TetMeshSpec>(&scene.mesh)) {
        ImportedTets imported = read_tet_mesh(tets->file, tets->scale);
        shape.roots = std::move(imported.mesh);
        shape.tet_repairs = imported.repairs;
        return shape;
    }
    int target_tets = 0;
    std::string file;
    if (const auto* spec = std::get_if<SurfaceMeshSpec>(&scene.mesh)) {
        ImportedSurface imported = read_surfaces(spec->files, spec->scale);
        shape.surface = std::move(imported.mesh);
        shape.surface_repairs = imported.repairs;
        target_tets = spec->target_tets;
        file = spec->files.size() == 1 ? spec->files[0].string() : scene.file.string();
    } else {
        const auto& voxels = std::get<VoxelMeshSpec>(scene.mesh);
        const VoxelImage image = scaled_image(voxels.file, voxels.scale);
        const double cell = voxels.surface_cell > 0 ? voxels.surface_cell : voxel_extent(image, voxels.labels) / 100;
        try {
            shape.surface = voxel_surface(image, voxels.labels, cell);
        } catch (const InputError& error) {
            if (!error.file.empty()) throw;
            throw InputError(scene.file.string(), "/mesh/voxels/surface_cell", error.problem, error.remedy);
        }
        target_tets = voxels.target_tets;
        file = voxels.file.string();
    }
    try {
        VolumeMesh volume = mesh_volume(shape.surface, {.target_tets = target_tets});
        shape.roots = std::move(volume.mesh);
        shape.meshing = volume.report;
    } catch (const InputError& error) {
        if (!error.file.empty()) throw;
        throw InputError(file, error.where, error.problem, error.remedy);
    }
    return shape;
}

/// Scenes are held against this where they say their size; only the mesh itself knows it for sure.
void check_size(const Scene& scene, const TetMesh& roots) {
    const double leaves = static_cast<double>(roots.corners.size()) * std::pow(8, scene.levels);
    if (leaves < max_leaves) return;
    throw InputError(scene.file.string(), "/levels",
                     "makes " + std::to_string(static_cast<long long>(leaves)) + " tets of the " +
                         std::to_string(roots.corners.size()) + " of the mesh",
                     "use fewer levels: the finest level must have less than 16777216 tets");
}

/// Scenes bound their numbers; files of meshes and images do not.
void check_place(const Scene& scene, const TetMesh& roots) {
    Eigen::AlignedBox3d box;
    for (const Vec3& p : roots.positions) box.extend(p);
    const double reach = std::max(box.min().cwiseAbs().maxCoeff(), box.max().cwiseAbs().maxCoeff());
    const double extent = box.sizes().maxCoeff();
    if (reach <= largest_coordinate && extent >= 1e-6 && reach <= 1e9 * extent) return;
    std::ostringstream text;
    text << "makes an object of " << extent << " m that reaches " << reach << " m from the origin";
    throw InputError(scene.file.string(), "/mesh", text.str(),
                     "scale and move it: use 1e-6 m to 1e6 m, and no farther away than 1e9 times its size");
}

}  // namespace

Shape make_shape(const Scene& scene) {
    if (scene.front.order == 2 && scene.levels == 0) {
        throw InputError(scene.file.string(), "/levels", "is 0 with quadratic tets (front/order 2)",
                         "use levels >= 1: their midpoints are the vertices of the next level");
    }
    Shape shape = read_shape(scene);
    check_size(scene, shape.roots);
    check_place(scene, shape.roots);
    return shape;
}

std::string describe(const Shape& shape) {
    std::string text;
    if (shape.surface_repairs) text += describe(*shape.surface_repairs);
    if (shape.tet_repairs) text += describe(*shape.tet_repairs);
    if (shape.meshing) text += describe(*shape.meshing);
    return text;
}

}  // namespace tetfront
