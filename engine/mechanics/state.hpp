#pragma once
// What moves and what acts on it: the state of a front's vertices and the loads of a time step, shared by all integrators.
//
//     State state;
//     state.resize(tree.vertex_count());
//     Loads loads;
//     loads.gravity = {0, 0, -9.81};
//     loads.springs.push_back({front.locate(leaf, barycentric), target, stiffness, damping});

#include <vector>

#include "engine/base/types.hpp"
#include "engine/mechanics/contact.hpp"
#include "engine/tree/front.hpp"

namespace tetfront {

/// What moves: one entry per vertex of the tree; only those of the front are valid.
struct State {
    PerVertex<Vec3> x;  // [m]
    PerVertex<Vec3> v;  // [m/s]
    PerVertex<Vec3> a;  // [m/s^2] of the last step; the solver's first guess for the next one
    // Place and velocity one time step earlier, for BDF2. Moved through changes of the front like x and v.
    PerVertex<Vec3> earlier_x, earlier_v;
    bool has_earlier = false;  // false: no step with the present step size has been made from them

    void resize(std::size_t vertices) {
        for (PerVertex<Vec3>* field : {&x, &v, &a, &earlier_x, &earlier_v}) field->resize(vertices);
    }
    /// v stands still at `place`, and has done so.
    void rest_at(VertexId v_id, const Vec3& place) {
        x[v_id] = earlier_x[v_id] = place;
        for (PerVertex<Vec3>* field : {&v, &a, &earlier_v}) (*field)[v_id].setZero();
    }
};

/// A force at a point of the front.
struct PointForce {
    Front::Point at;
    Vec3 force;  // [N]
};
/// A spring and damper between a point of the front and a fixed target.
struct PointSpring {
    Front::Point at;
    Vec3 target;       // [m]
    double stiffness;  // [N/m]
    double damping;    // [N s/m]
};
struct Loads {
    Vec3 gravity = Vec3::Zero();  // [m/s^2]
    std::vector<PointForce> forces;
    std::vector<PointSpring> springs;
    std::vector<PointContact> contacts;  // points that are, or may soon be, at the ground
};

/// sum_i weights[i] field[nodes[i]]: a field at a point of the front. nodes: Front::nodes_per_tet().
inline Vec3 value_at(const Front::Point& p, int nodes, const PerVertex<Vec3>& field) {
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 0; i < static_cast<std::size_t>(nodes); ++i) sum += p.weights[i] * field[p.nodes[i]];
    return sum;
}
/// The transpose: spreads a force at a point over the nodes.
inline void add_at(const Front::Point& p, int nodes, const Vec3& force, PerVertex<Vec3>& field) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(nodes); ++i) field[p.nodes[i]] += p.weights[i] * force;
}

}  // namespace tetfront
