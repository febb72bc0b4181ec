#include "engine/tree/creases.hpp"

#include "engine/base/disjoint_sets.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

namespace tetfront {

namespace {

/// A triangle's side, from corner `corner` to the next one.
struct Side {
    std::int32_t low, high;  // its vertices
    std::uint32_t corner;
    friend auto operator<=>(const Side&, const Side&) = default;
};

std::uint32_t next_corner(std::uint32_t corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; }

std::vector<Side> sorted_sides(const SurfaceMesh& mesh) {
    std::vector<Side> sides;
    sides.reserve(3 * mesh.triangles.size());
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        for (std::uint32_t i = 0; i < 3; ++i) {
            const std::int32_t a = mesh.triangles[t][i], b = mesh.triangles[t][(i + 1) % 3];
            sides.push_back({std::min(a, b), std::max(a, b), 3 * t + i});
        }
    }
    std::ranges::sort(sides);
    return sides;
}

Vec3 normal(const SurfaceMesh& mesh, std::size_t triangle) {
    const auto& t = mesh.triangles[triangle];
    const auto at = [&](std::size_t i) -> const Vec3& { return mesh.positions[static_cast<std::size_t>(t[i])]; };
    return (at(1) - at(0)).cross(at(2) - at(0)).normalized();
}

}  // namespace

Surface split_creases(Surface surface, double angle) {
    SurfaceMesh& mesh = surface.mesh;
    const double smooth = std::cos(angle * std::numbers::pi / 180);
    DisjointSets corners(3 * mesh.triangles.size());  // that belong to one vertex copy: 3 t + i is corner i of triangle t
    const std::vector<Side> sides = sorted_sides(mesh);
    for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
        while (end < sides.size() && sides[end].low == sides[begin].low && sides[end].high == sides[begin].high) ++end;
        if (end - begin != 2) continue;
        const std::uint32_t a = sides[begin].corner, b = sides[begin + 1].corner;
        if (!(normal(mesh, a / 3).dot(normal(mesh, b / 3)) >= smooth)) continue;
        // Neighbours that agree on what is outside run along the side in opposite directions.
        const bool opposite = mesh.triangles[a / 3][a % 3] != mesh.triangles[b / 3][b % 3];
        corners.join(a, opposite ? next_corner(b) : b);
        corners.join(next_corner(a), opposite ? b : next_corner(b));
    }

    // The first group of a vertex keeps it, every other gets a copy.
    constexpr std::uint32_t nobody = ~0U;
    std::vector<std::uint32_t> owner(mesh.positions.size(), nobody);
    std::vector<std::int32_t> vertex_of(3 * mesh.triangles.size(), -1);  // by representative
    for (std::uint32_t corner = 0; corner < vertex_of.size(); ++corner) {
        std::int32_t& vertex = mesh.triangles[corner / 3][corner % 3];
        const auto group = static_cast<std::uint32_t>(corners.find(corner));
        if (vertex_of[group] < 0) {
            const auto v = static_cast<std::size_t>(vertex);
            if (owner[v] == nobody) {
                owner[v] = group;
                vertex_of[group] = vertex;
            } else {
                vertex_of[group] = static_cast<std::int32_t>(mesh.positions.size());
                mesh.positions.push_back(Vec3(mesh.positions[v]));
                surface.attachment.push_back(Attachment(surface.attachment[v]));
            }
        }
        vertex = vertex_of[group];
    }
    return surface;
}

}  // namespace tetfront
