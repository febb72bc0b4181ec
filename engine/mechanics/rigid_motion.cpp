#include "engine/mechanics/rigid_motion.hpp"

#include <Eigen/LU>

namespace tetfront {

void restore_momentum(const Momentum& before, const std::vector<VertexId>& vertices, const ElementSet& elements,
                      double size, const PerVertex<Vec3>& x, PerVertex<Vec3>& v, PerVertex<Vec3>& scratch) {
    const Momentum now = elements.momentum(x, v);
    scratch.resize(x.size());
    // Momenta of the six unit rigid motions; turns about the object's rough centre.
    const Vec3 centre = x[vertices.front()];
    const auto unit_motion = [&](int k, const Vec3& at) -> Vec3 {
        return k < 3 ? Vec3(Vec3::Unit(k)) : Vec3(Vec3::Unit(k - 3).cross(at - centre) / size);
    };
    Mat6 momenta;
    for (int k = 0; k < 6; ++k) {
        for (VertexId w : vertices) scratch[w] = unit_motion(k, x[w]);
        const Momentum p = elements.momentum(x, scratch);
        momenta.col(k).head<3>() = p.linear;
        momenta.col(k).tail<3>() = (p.angular - centre.cross(p.linear)) / size;
    }
    Vec6 missing;
    const Vec3 linear = before.linear - now.linear;
    missing.head<3>() = linear;
    missing.tail<3>() = (before.angular - now.angular - centre.cross(linear)) / size;
    const Vec6 amount = momenta.fullPivLu().solve(missing);
    if (!amount.allFinite()) return;
    for (VertexId w : vertices)
        for (int k = 0; k < 6; ++k) v[w] += amount[k] * unit_motion(k, x[w]);
}

}  // namespace tetfront
