// Iterations of the solver for each preconditioner: uniform fronts of every level, and fronts with hanging vertices.
#include "engine/mechanics/block_matrix.hpp"
#include "engine/mechanics/multilevel.hpp"
#include "engine/mechanics/pcg.hpp"
#include "engine/mesh/tet_mesh.hpp"
#include "server/cli/bench.hpp"

namespace tetfront {

namespace {

constexpr double time_step = 1.0 / 60, tolerance = 1e-6;

IterationRow count(const TetTree& tree, int order, int level, bool hanging) {
    Front front(tree, order, level, 99);
    if (hanging) {
        const std::vector<TetId> active = front.active();
        for (TetId t : active)
            if (tree.rest(tree.corners(t)[0])[0] < 1) front.split(t);
        front.commit();
    }
    const PooledPerTet<Sym6> elasticity(tree.tet_count(), Sym6::from(isotropic_elasticity(5e6, 0.3)));
    const PerTet<double> density(tree.tet_count(), 1000.0);
    const TetMaterials materials{elasticity, density};
    PerVertex<std::uint8_t> pinned(tree.vertex_count(), 0);
    for (VertexId v : ids<VertexId>(tree.vertex_count())) pinned[v] = tree.rest(v)[0] < 1e-9;
    ElementSet elements;
    elements.build(front, materials);
    BlockMatrix matrix;
    matrix.build(front, elements, pinned);
    const PerVertex<Vec3> fall(tree.vertex_count(), Vec3(0, 0, 9.81 * time_step));
    elements.evaluate({.x = tree.rest(), .inertia = &fall, .tangent = true, .stiffness_scale = time_step * time_step, .mass_scale = 1});
    matrix.fill(elements);
    PerVertex<Vec3> nodal(tree.vertex_count(), Vec3::Zero());
    elements.accumulate(nodal);
    front.restrict_to_free(nodal);
    DofVector right(matrix.size()), x(matrix.size(), Vec3::Zero());
    for (std::size_t i = 0; i < right.size(); ++i) right[i] = nodal[matrix.vertices()[i]];

    IterationRow row{order, level, hanging, elements.size(), 3 * matrix.size(), 0, 0};
    Pcg pcg;
    BlockJacobi jacobi;
    jacobi.build(matrix);
    row.jacobi = pcg.solve(matrix, jacobi, right, x, {tolerance, 5000}).iterations;
    Multilevel multilevel;
    multilevel.build(front, materials, pinned, matrix);
    multilevel.update(matrix, {.stiffness_scale = time_step * time_step, .mass_scale = 1, .damping_scale = time_step, .x = tree.rest()});
    x.assign(x.size(), Vec3::Zero());
    row.multilevel = pcg.solve(matrix, multilevel, right, x, {tolerance, 5000}).iterations;
    return row;
}

}  // namespace

std::vector<IterationRow> count_iterations(bool quick) {
    const int depth = quick ? 2 : 4;
    const TetTree tree(box_mesh({0, 0, 0}, {4, 1, 1}, {4, 1, 1}), depth);
    std::vector<IterationRow> rows;
    for (int order : {1, 2}) {
        const int finest = order == 1 ? depth : depth - 1;
        for (int level = 0; level <= finest; ++level) {
            rows.push_back(count(tree, order, level, false));
            if (level < finest) rows.push_back(count(tree, order, level, true));
        }
    }
    return rows;
}

}  // namespace tetfront
