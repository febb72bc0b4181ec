#pragma once
// Triangle surfaces of known shape, for the tests of the mesh layer.

#include "engine/mesh/tet_mesh.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

namespace tetfront::test_surfaces {

inline double surface_volume(const SurfaceMesh& mesh) {
    double volume = 0;
    for (const auto& t : mesh.triangles) {
        const auto x = [&](std::size_t i) { return mesh.positions[static_cast<std::size_t>(t[i])]; };
        volume += x(0).cross(x(1)).dot(x(2)) / 6;
    }
    return volume;
}

/// A grid of u x v cells wrapped around both directions, `position(s, t)` with s, t in [0, 1).
template <class Position>
SurfaceMesh wrapped_grid(int u, int v, const Position& position) {
    SurfaceMesh mesh;
    for (int i = 0; i < u; ++i)
        for (int j = 0; j < v; ++j) mesh.positions.push_back(position(double(i) / u, double(j) / v));
    const auto id = [&](int i, int j) { return (i % u) * v + j % v; };
    for (int i = 0; i < u; ++i)
        for (int j = 0; j < v; ++j) {
            mesh.triangles.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
            mesh.triangles.push_back({id(i, j), id(i + 1, j + 1), id(i, j + 1)});
        }
    return mesh;
}

/// Torus around z.
inline SurfaceMesh torus(double major, double minor, int u = 64, int v = 32) {
    return wrapped_grid(u, v, [=](double s, double t) {
        const double a = 2 * std::numbers::pi * s, b = 2 * std::numbers::pi * t;
        return Vec3((major + minor * std::cos(b)) * std::cos(a), (major + minor * std::cos(b)) * std::sin(a),
                    minor * std::sin(b));
    });
}

/// Octahedron refined `levels` times and projected to the sphere.
inline SurfaceMesh sphere(const Vec3& center, double radius, int levels = 4) {
    SurfaceMesh mesh;
    mesh.positions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    for (int level = 0; level < levels; ++level) {
        std::map<std::pair<int, int>, int> middle;
        const auto mid = [&](int a, int b) {
            const auto [entry, fresh] =
                middle.try_emplace({std::min(a, b), std::max(a, b)}, static_cast<int>(mesh.positions.size()));
            if (fresh)
                mesh.positions.push_back(
                    (mesh.positions[static_cast<std::size_t>(a)] + mesh.positions[static_cast<std::size_t>(b)])
                        .normalized());
            return entry->second;
        };
        std::vector<std::array<std::int32_t, 3>> finer;
        for (const auto& t : mesh.triangles) {
            const int a = mid(t[0], t[1]), b = mid(t[1], t[2]), c = mid(t[2], t[0]);
            finer.insert(finer.end(), {{t[0], a, c}, {a, t[1], b}, {c, b, t[2]}, {a, b, c}});
        }
        mesh.triangles = std::move(finer);
    }
    for (Vec3& x : mesh.positions) x = center + radius * x;
    return mesh;
}

inline SurfaceMesh cube(const Vec3& low, const Vec3& high) { return boundary_surface(box_mesh(low, high, {1, 1, 1})); }

/// The triangles whose centroid satisfies `keep`; all vertices stay.
template <class Keep>
SurfaceMesh part(SurfaceMesh mesh, const Keep& keep) {
    std::erase_if(mesh.triangles, [&](const auto& t) {
        Vec3 centroid = Vec3::Zero();
        for (int v : t) centroid += mesh.positions[static_cast<std::size_t>(v)] / 3;
        return !keep(centroid);
    });
    return mesh;
}

inline void append(SurfaceMesh& mesh, const SurfaceMesh& other, bool flipped = false) {
    const auto offset = static_cast<std::int32_t>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
    for (const auto& t : other.triangles) {
        mesh.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
        if (flipped) std::swap(mesh.triangles.back()[1], mesh.triangles.back()[2]);
    }
}

}  // namespace tetfront::test_surfaces
