#include "engine/mesh/surface_nets.hpp"

#include "engine/base/error.hpp"
#include "engine/base/parallel.hpp"

#include <array>
#include <cmath>
#include <cstdint>

namespace tetfront {

namespace {

constexpr double most_samples = 1 << 27;

/// Samples of the field, with a border of zeros so that every surface is closed.
class Lattice {
 public:
    Lattice(const Vec3& low, const Vec3& high, double cell) : cell_(cell) {
        double samples = 1;
        for (int a = 0; a < 3; ++a) {
            const double n = std::ceil((high[a] - low[a]) / cell) + 1;
            samples *= n + 2;
            if (!(samples <= most_samples))
                throw InputError("", "surface", "needs more than 2^27 samples", "use a larger cell or a smaller box");
            size_[static_cast<std::size_t>(a)] = static_cast<std::size_t>(n) + 2;
        }
        origin_ = low.array() - cell;
        value_.assign(static_cast<std::size_t>(samples), 0.0F);
    }

    void sample(const std::function<double(const Vec3&)>& field) {
        parallel_for(size_[2] - 2, 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t k = begin + 1; k < end + 1; ++k)
                for (std::size_t j = 1; j + 1 < size_[1]; ++j)
                    for (std::size_t i = 1; i + 1 < size_[0]; ++i)
                        value_[index(i, j, k)] = static_cast<float>(field(position(i, j, k)));
        });
    }

    [[nodiscard]] std::size_t index(std::size_t i, std::size_t j, std::size_t k) const {
        return (k * size_[1] + j) * size_[0] + i;
    }
    [[nodiscard]] Vec3 position(std::size_t i, std::size_t j, std::size_t k) const {
        return origin_ + cell_ * Vec3(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
    }
    /// Above one half; a NaN is not.
    [[nodiscard]] bool inside(std::size_t at) const { return value_[at] > 0.5F; }
    [[nodiscard]] double value(std::size_t at) const { return static_cast<double>(value_[at]); }
    [[nodiscard]] const std::array<std::size_t, 3>& size() const { return size_; }
    [[nodiscard]] double cell() const { return cell_; }

 private:
    double cell_;
    Vec3 origin_;
    std::array<std::size_t, 3> size_{};
    std::vector<float> value_;
};

/// Mean of the crossings of the twelve edges of the cube at (i, j, k); false when it has none.
bool cube_vertex(const Lattice& lattice, std::size_t i, std::size_t j, std::size_t k, Vec3& vertex) {
    Vec3 sum = Vec3::Zero();
    int crossings = 0;
    for (std::size_t corner = 0; corner < 8; ++corner) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (corner >> axis & 1) continue;
            const auto at = [&](std::size_t c) { return lattice.index(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2)); };
            const std::size_t a = at(corner), b = at(corner | std::size_t{1} << axis);
            if (lattice.inside(a) == lattice.inside(b)) continue;
            const double t = (0.5 - lattice.value(a)) / (lattice.value(b) - lattice.value(a));
            Vec3 crossing = lattice.position(i + (corner & 1), j + (corner >> 1 & 1), k + (corner >> 2));
            crossing[static_cast<int>(axis)] += lattice.cell() * (std::isfinite(t) ? t : 0.5);
            sum += crossing;
            ++crossings;
        }
    }
    if (crossings == 0) return false;
    vertex = sum / crossings;
    return true;
}

}  // namespace

SurfaceMesh surface_nets(const Vec3& low, const Vec3& high, double cell, const std::function<double(const Vec3&)>& field) {
    if (!(cell > 0) || !((high - low).minCoeff() >= 0) || !low.allFinite() || !high.allFinite())
        throw InputError("", "surface", "has no box or no cell", "use finite numbers, high >= low and a cell above 0");
    Lattice lattice(low, high, cell);
    lattice.sample(field);

    const auto [nx, ny, nz] = lattice.size();
    SurfaceMesh surface;
    std::vector<std::int32_t> vertex_of(nx * ny * nz, -1);  // of the cube whose lowest corner this is
    for (std::size_t k = 0; k + 1 < nz; ++k)
        for (std::size_t j = 0; j + 1 < ny; ++j)
            for (std::size_t i = 0; i + 1 < nx; ++i) {
                Vec3 vertex;
                if (!cube_vertex(lattice, i, j, k, vertex)) continue;
                vertex_of[lattice.index(i, j, k)] = static_cast<std::int32_t>(surface.positions.size());
                surface.positions.push_back(vertex);
            }

    const std::array<std::size_t, 3> step = {1, nx, nx * ny};
    for (std::size_t k = 0; k + 1 < nz; ++k)
        for (std::size_t j = 0; j + 1 < ny; ++j)
            for (std::size_t i = 0; i + 1 < nx; ++i) {
                const std::size_t a = lattice.index(i, j, k);
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    const std::size_t b = a + step[axis], u = step[(axis + 1) % 3], v = step[(axis + 2) % 3];
                    if (lattice.inside(a) == lattice.inside(b)) continue;
                    // The four cubes around the edge, counter-clockwise seen from b. All exist: one end of the edge is
                    // not in the border of zeros.
                    std::array<std::int32_t, 4> q = {vertex_of[a - u - v], vertex_of[a - v], vertex_of[a],
                                                     vertex_of[a - u]};
                    if (lattice.inside(b)) std::swap(q[1], q[3]);
                    surface.triangles.push_back({q[0], q[1], q[2]});
                    surface.triangles.push_back({q[0], q[2], q[3]});
                }
            }
    return surface;
}

}  // namespace tetfront
