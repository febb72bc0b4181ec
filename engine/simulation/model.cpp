// From a scene to everything that stays constant while it is simulated.
#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "engine/base/error.hpp"
#include "engine/simulation/pins.hpp"
#include "engine/simulation/scene_material.hpp"
#include "engine/simulation/shape.hpp"
#include "engine/simulation/simulation.hpp"
#include "engine/tree/creases.hpp"

namespace tetfront {

namespace {

/// The leaves' outer faces: as smooth as the simulation can be.
SurfaceMesh leaf_boundary(const TetTree& tree) {
    TetMesh leaves;
    leaves.positions = tree.rest();
    for (TetId t : tree.level(tree.depth())) leaves.corners.push_back(tree.corners(t));
    return boundary_surface(leaves);
}

Eigen::AlignedBox3d bounds(const TetTree& tree) {
    Eigen::AlignedBox3d box;
    for (VertexId v : ids<VertexId>(tree.vertex_count(0))) box.extend(tree.rest(v));
    return box;
}

/// Spreads each force evenly over the surface vertices in its region.
std::vector<AttachedForce> attach_forces(const Scene& scene, const Surface& surface) {
    std::vector<AttachedForce> forces;
    for (std::size_t i = 0; i < scene.forces.size(); ++i) {
        const ForceSpec& spec = scene.forces[i];
        std::vector<std::size_t> vertices;
        for (std::size_t s = 0; s < surface.mesh.positions.size(); ++s)
            if (contains(spec.region, surface.mesh.positions[s])) vertices.push_back(s);
        if (vertices.empty()) {
            throw InputError(scene.file.string(), "/forces/" + std::to_string(i), "has no surface vertex in its region",
                             "move or enlarge the region");
        }
        for (std::size_t s : vertices)
            forces.push_back({surface.attachment[s], spec.force / static_cast<double>(vertices.size()), spec.start, spec.end, i});
    }
    return forces;
}

std::shared_ptr<const FrameModel> make_frame_model(const Scene& scene, const TetTree& tree, const Surface& surface,
                                                   const StiffnessFunction& stiffness,
                                                   const ElasticityMatrices& matrices) {
    auto model = std::make_shared<FrameModel>();
    for (const auto& t : surface.mesh.triangles)
        model->triangles.push_back({static_cast<std::uint32_t>(t[0]), static_cast<std::uint32_t>(t[1]), static_cast<std::uint32_t>(t[2])});
    Eigen::AlignedBox3d box;
    for (std::size_t i = 0; i < surface.mesh.positions.size(); ++i) {
        const Vec3& p = surface.mesh.positions[i];
        box.extend(p);
        TetId root = surface.attachment[i].leaf;
        while (!tree.is_root(root)) root = tree.parent(root);
        // Where the material is not defined, which is nothing to complain of beside the tets, the nearest leaf's colour.
        double young = 0;
        try {
            young = representative_young(stiffness.at(p, root).elasticity);
        } catch (const InputError&) {
            young = representative_young(matrices.elasticity[surface.attachment[i].leaf]);
        }
        model->young.push_back(static_cast<float>(young));
    }
    const auto [low, high] = std::ranges::minmax_element(model->young);
    model->young_range = {*low, *high};
    model->depth = tree.depth();
    model->up = scene.up;
    for (int c = 0; c < 3; ++c) {
        model->rest_box[static_cast<std::size_t>(c)] = static_cast<float>(box.min()[c]);
        model->rest_box[static_cast<std::size_t>(c + 3)] = static_cast<float>(box.max()[c]);
    }
    return model;
}

}  // namespace

std::shared_ptr<const Model> build_model(Scene scene, const Progress& progress, const CacheSettings& cache) {
    if (progress) progress("meshing", 0);
    Shape shape = make_shape(scene);
    return build_model(std::move(scene), std::move(shape), progress, cache);
}

std::shared_ptr<const Model> build_model(Scene scene, Shape shape, const Progress& progress, const CacheSettings& cache) {
    const auto report = [&](const std::string& what, double fraction) {
        if (progress) progress(what, fraction);
    };
    report("subdividing", 0);
    const StiffnessFunction stiffness = make_stiffness(scene, shape.roots);
    TetTree tree(std::move(shape.roots), scene.levels);
    if (shape.surface.positions.empty()) shape.surface = leaf_boundary(tree);
    report("attaching the surface", 0);
    Surface surface = embed(std::move(shape.surface), tree);

    const Eigen::AlignedBox3d box = bounds(tree);
    CoarseMaterials materials;
    try {
        materials = coarse_materials(tree, stiffness, estimation_settings(scene.estimation), cache, report);
    } catch (const InputError& error) {
        if (!error.file.empty()) throw;
        throw InputError(scene.file.string(), "/material: " + error.where, error.problem, error.remedy);
    }
    PerTet<double>& density = materials.density;

    PerVertex<std::uint8_t> pinned(tree.vertex_count(), 0);
    bool has_pins = false;
    for (VertexId v : ids<VertexId>(tree.vertex_count())) {
        pinned[v] = std::ranges::any_of(scene.pins, [&](const Region& r) { return contains(r, tree.rest(v)); });
        has_pins = has_pins || pinned[v];
    }
    if (!scene.pins.empty() && !has_pins)
        throw InputError(scene.file.string(), "/pins", "hold no vertex of the mesh", "move or enlarge the regions");
    double mass = 0;
    for (TetId t : tree.level(0)) mass += density[t] * tree.volume(t);

    auto forces = attach_forces(scene, surface);  // before vertices are doubled
    surface = split_creases(std::move(surface), crease_angle);
    auto frame_model = make_frame_model(scene, tree, surface, stiffness, materials.matrices);
    auto unresolved = find_unresolved(tree, pinned);
    const double size = box.sizes().maxCoeff();
    std::optional<Ground> ground;
    if (scene.ground) ground.emplace(*scene.ground, scene.up, size, tree, surface);
    const bool held = pins_hold(tree, pinned, size);
    report("ready", 1);
    return std::make_shared<const Model>(Model{std::move(scene), std::move(tree), std::move(materials.matrices), std::move(density),
                                               std::move(surface), std::move(pinned), std::move(unresolved),
                                               std::move(forces), std::move(ground), std::move(frame_model), mass, size, has_pins, held});
}

}  // namespace tetfront
