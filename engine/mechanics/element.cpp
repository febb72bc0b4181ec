#include "engine/mechanics/element.hpp"

#include <Eigen/LU>

namespace tetfront {

Gradients<double> barycentric_gradients(const std::array<Vec3, 4>& rest) {
    Mat3 edges;
    for (int k = 0; k < 3; ++k) edges.col(k) = rest[static_cast<std::size_t>(k + 1)] - rest[0];
    const Mat3 inverse = edges.inverse();  // rows are the gradients
    Gradients<double> g;
    for (int k = 0; k < 3; ++k)
        for (int c = 0; c < 3; ++c) g(k, c) = inverse(k, c);
    return g;
}

}  // namespace tetfront
