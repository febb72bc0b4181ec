#include "engine/mesh/volume_report.hpp"

#include "engine/base/parallel.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdio>
#include <random>

namespace tetfront {

namespace {

constexpr int volume_samples = 20000;

Vec3 corner(const SurfaceMesh& surface, const std::array<std::int32_t, 3>& triangle, std::size_t i) {
    return surface.positions[static_cast<std::size_t>(triangle[i])];
}

double area(const Vec3& a, const Vec3& b, const Vec3& c) { return (b - a).cross(c - a).norm() / 2; }

}  // namespace

double tet_volume(const TetMesh& mesh, TetId t) {
    const auto& c = mesh.corners[t];
    const auto& x = mesh.positions;
    return signed_volume(x[c[0]], x[c[1]], x[c[2]], x[c[3]]);
}

double area(const SurfaceMesh& surface) {
    double sum = 0;
    for (const auto& t : surface.triangles) sum += area(corner(surface, t, 0), corner(surface, t, 1), corner(surface, t, 2));
    return sum;
}

double enclosed_volume(const SurfaceMesh& surface) {
    Vec3 middle = Vec3::Zero();
    double total = 0;
    for (const auto& t : surface.triangles) {
        const Vec3 a = corner(surface, t, 0), b = corner(surface, t, 1), c = corner(surface, t, 2);
        const double triangle = area(a, b, c);
        middle += triangle * (a + b + c) / 3;
        total += triangle;
    }
    if (total > 0) middle /= total;
    double volume = 0;
    for (const auto& t : surface.triangles)
        volume += signed_volume(middle, corner(surface, t, 0), corner(surface, t, 1), corner(surface, t, 2));
    return volume;
}

void measure(const SurfaceMesh& surface, const SurfaceBvh& bvh, const TetMesh& mesh, VolumeMeshReport& report) {
    report.tets = mesh.corners.size();
    report.vertices = mesh.positions.size();
    report.dihedral = {180, 0};
    for (TetId t : ids<TetId>(mesh.corners.size())) {
        const auto& c = mesh.corners[t];
        const auto& x = mesh.positions;
        const auto [low, high] = dihedral_range(x[c[0]], x[c[1]], x[c[2]], x[c[3]]);
        report.dihedral = {std::min(report.dihedral[0], low), std::max(report.dihedral[1], high)};
        report.mesh_volume += tet_volume(mesh, t);
    }
    report.surface_volume = enclosed_volume(surface);

    const SurfaceBvh skin(boundary_surface(mesh));
    const auto outside = [&](const Vec3& p) { return skin.winding_number(p) < 0.5; };
    std::vector<double> distance(surface.positions.size(), -1.0);
    parallel_for(distance.size(), 256, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v)
            if (outside(surface.positions[v])) distance[v] = skin.closest(surface.positions[v]).distance;
    });
    for (double d : distance) {
        if (d < 0) continue;
        ++report.outside_count;
        report.outside_distance = std::max(report.outside_distance, d);
    }

    std::mt19937 random(1);
    const auto coordinate = [&](double low, double high) {
        return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
    };
    std::vector<Vec3> samples;
    for (int i = 0; i < volume_samples; ++i) {
        const double x = coordinate(bvh.low()[0], bvh.high()[0]), y = coordinate(bvh.low()[1], bvh.high()[1]),
                     z = coordinate(bvh.low()[2], bvh.high()[2]);
        samples.emplace_back(x, y, z);
    }
    std::vector<signed char> hit(samples.size(), 0);  // 1: inside of the surface, 2: of the tets too
    parallel_for(samples.size(), 256, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            if (bvh.winding_number(samples[i]) > 0.5) hit[i] = outside(samples[i]) ? 1 : 2;
    });
    const auto inside = std::ranges::count_if(hit, [](signed char h) { return h > 0; });
    const auto covered = std::ranges::count(hit, 2);
    report.covered_volume = inside ? static_cast<double>(covered) / static_cast<double>(inside) : 1.0;
}

std::string describe(const VolumeMeshReport& r) {
    const auto line = [](const char* format, auto... values) {
        char text[256];
        std::snprintf(text, sizeof text, format, values...);
        return std::string(text);
    };
    std::string text =
        line("%zu tets, %zu vertices, cell %.3g m, margin %.3g m\n", r.tets, r.vertices, r.cell, r.margin) +
        line("dihedral angles %.1f to %.1f degrees\n", r.dihedral[0], r.dihedral[1]) +
        line("volume %.4g m^3 for the surface's %.4g m^3, %.1f %% of its inside is in tets\n", r.mesh_volume,
             r.surface_volume, 100 * r.covered_volume) +
        line("%zu surface vertices outside of the tets, at most %.3g m\n", r.outside_count, r.outside_distance);
    if (r.mesh_pieces != 1 || r.surface_pieces != 1)
        text += line("%zu parts of the surface, %zu of the mesh\n", r.surface_pieces, r.mesh_pieces);
    if (r.dropped_pieces)
        text +=
            line("%zu thin parts of %.3g m^3 were cut off by coarse cells and left out; use more tets to keep them\n",
                 r.dropped_pieces, r.dropped_volume);
    if (r.thickened)
        text += line("%.1f %% of the surface is thinner than the tets can be and was thickened to about a cell; use more tets to keep its shape\n",
                     100.0 * static_cast<double>(r.thickened) / static_cast<double>(std::max<std::size_t>(r.samples, 1)));
    if (r.pinched_edges) text += line("%zu edges where the mesh only touches itself\n", r.pinched_edges);
    return text;
}

}  // namespace tetfront
