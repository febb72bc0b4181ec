#include "engine/mesh/volume_mesh.hpp"

#include "engine/base/error.hpp"
#include "engine/base/parallel.hpp"
#include "engine/mesh/isosurface_stuffing.hpp"
#include "engine/mesh/tet_repair.hpp"
#include "engine/mesh/winding_number.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numeric>
#include <optional>
#include <random>
#include <set>

namespace tetfront {

namespace {

/// Attempts to hit the target; each multiplies the cell by the cube root of what is missing.
constexpr int max_attempts = 14;
constexpr double count_tolerance = 0.1;
/// A shape that fills less of its box than one tet in so many cubes of the lattice gets fewer tets than wanted.
constexpr double max_cells_per_tet = 100;
constexpr int volume_samples = 20000;

// In cells. A sample of the surface that is farther than `missed_distance` from all tets is filled with a ball.
// From sqrt(5)/4 = 0.56 on, a ball holds a lattice point wherever it lies; the last radius makes its tets reach the
// middle: with 0.56 as the last one, the bunny's ears stayed 0.35 cells outside, now 0.15.
constexpr double sample_spacing = 0.3, missed_distance = 0.1;
constexpr std::array<double, 5> thickening = {0.15, 0.3, 0.45, 0.6, 0.75};

double tet_volume(const TetMesh& mesh, TetId t) {
    const auto& c = mesh.corners[t];
    const auto& x = mesh.positions;
    return signed_volume(x[c[0]], x[c[1]], x[c[2]], x[c[3]]);
}

/// Volume by the divergence theorem, seen from the area-weighted middle: exact for a closed surface, and for an open
/// one as if its rim were joined to the middle.
double enclosed_volume(const SurfaceMesh& surface) {
    const auto corner = [&](const auto& t, std::size_t i) { return surface.positions[static_cast<std::size_t>(t[i])]; };
    Vec3 middle = Vec3::Zero();
    double area = 0;
    for (const auto& t : surface.triangles) {
        const Vec3 a = corner(t, 0), b = corner(t, 1), c = corner(t, 2);
        const double triangle = (b - a).cross(c - a).norm() / 2;
        middle += triangle * (a + b + c) / 3;
        area += triangle;
    }
    if (area > 0) middle /= area;
    double volume = 0;
    for (const auto& t : surface.triangles) volume += signed_volume(middle, corner(t, 0), corner(t, 1), corner(t, 2));
    return volume;
}

/// Connected parts of the surface, by common vertices.
struct SurfaceParts {
    std::vector<std::int32_t> of_triangle;
    std::size_t count;
};
SurfaceParts surface_parts(const SurfaceMesh& surface) {
    std::vector<std::int32_t> parent(surface.positions.size());
    std::iota(parent.begin(), parent.end(), 0);
    const auto find = [&](std::int32_t v) {
        const auto up = [&](std::int32_t i) -> std::int32_t& { return parent[static_cast<std::size_t>(i)]; };
        while (up(v) != v) v = up(v) = up(up(v));
        return v;
    };
    for (const auto& t : surface.triangles)
        for (std::size_t i : {1, 2}) {
            const std::int32_t a = find(t[0]), b = find(t[i]);
            parent[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
        }
    std::map<std::int32_t, std::int32_t> number;
    std::vector<std::int32_t> part;
    for (const auto& t : surface.triangles)
        part.push_back(number.try_emplace(find(t[0]), static_cast<std::int32_t>(number.size())).first->second);
    return {std::move(part), number.size()};
}

/// Of all pieces of the mesh that belong to one part of the surface only the largest stays: the others are ends that
/// thin places cut off, and would fly away. A piece belongs to the part that most of its tets are nearest to.
TetMesh drop_debris(const TetMesh& mesh, const SurfaceBvh& bvh, const SurfaceParts& parts, VolumeMeshReport& report) {
    const PerTet<std::int32_t> piece = connected_pieces(mesh);
    const std::size_t count = static_cast<std::size_t>(*std::max_element(piece.begin(), piece.end())) + 1;
    report.mesh_pieces = count;
    if (count == 1) return mesh;
    std::vector<double> volume(count, 0.0);
    std::vector<std::map<std::int32_t, int>> votes(count);
    for (TetId t : ids<TetId>(mesh.corners.size())) {
        const auto p = static_cast<std::size_t>(piece[t]);
        volume[p] += tet_volume(mesh, t);
        Vec3 centroid = Vec3::Zero();
        for (VertexId v : mesh.corners[t]) centroid += mesh.positions[v] / 4;
        ++votes[p][parts.of_triangle[static_cast<std::size_t>(bvh.closest(centroid).triangle)]];
    }
    std::map<std::int32_t, std::size_t> largest;  // part of the surface -> piece of the mesh
    for (std::size_t p = 0; p < count; ++p) {
        const auto owner = std::max_element(votes[p].begin(), votes[p].end(), [](const auto& a, const auto& b) {
                               return a.second < b.second;
                           })->first;
        const auto [entry, fresh] = largest.try_emplace(owner, p);
        if (!fresh && volume[p] > volume[entry->second]) entry->second = p;
    }
    std::vector<char> keep(count, 0);
    for (const auto& [owner, p] : largest) keep[p] = 1;
    for (std::size_t p = 0; p < count; ++p)
        if (!keep[p]) report.dropped_volume += volume[p];
    report.dropped_pieces = count - largest.size();
    report.mesh_pieces = largest.size();
    return keep_tets(mesh, [&](TetId t) { return keep[static_cast<std::size_t>(piece[t])] != 0; });
}

/// Points of the surface, at least one in each cube of edge `spacing` that it passes through, at most one kept a cube.
std::vector<Vec3> sample_surface(const SurfaceMesh& surface, double spacing) {
    std::set<std::array<std::int64_t, 3>> taken;
    std::vector<Vec3> samples;
    const auto add = [&](const Vec3& x) {
        std::array<std::int64_t, 3> cube;
        for (int i = 0; i < 3; ++i)
            cube[static_cast<std::size_t>(i)] = static_cast<std::int64_t>(std::floor(x[i] / spacing));
        if (taken.insert(cube).second) samples.push_back(x);
    };
    for (const auto& t : surface.triangles)  // corners first: tips matter most
        for (std::int32_t v : t) add(surface.positions[static_cast<std::size_t>(v)]);
    for (const auto& t : surface.triangles) {
        const Vec3 a = surface.positions[static_cast<std::size_t>(t[0])];
        const Vec3 ab = surface.positions[static_cast<std::size_t>(t[1])] - a;
        const Vec3 ac = surface.positions[static_cast<std::size_t>(t[2])] - a;
        const double longest = std::max({ab.norm(), ac.norm(), (ac - ab).norm()});
        const auto n = static_cast<int>(std::ceil(longest / spacing));
        for (int i = 0; i <= n && n > 1; ++i)
            for (int j = 0; i + j <= n; ++j) add(a + ab * (double(i) / n) + ac * (double(j) / n));
    }
    return samples;
}

/// The samples farther than `distance` from all tets, as triangles that are points.
SurfaceMesh missed_points(const std::vector<Vec3>& samples, const TetMesh& mesh, double distance) {
    std::vector<char> missed(samples.size(), 1);
    if (!mesh.corners.empty()) {
        const SurfaceBvh skin(boundary_surface(mesh));
        parallel_for(samples.size(), 64, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                missed[i] = skin.winding_number(samples[i]) < 0.5 && skin.closest(samples[i], distance).triangle < 0;
        });
    }
    SurfaceMesh points;
    for (std::size_t i = 0; i < samples.size(); ++i) {
        if (!missed[i]) continue;
        const auto v = static_cast<std::int32_t>(points.positions.size());
        points.positions.push_back(samples[i]);
        points.triangles.push_back({v, v, v});
    }
    return points;
}

/// Tets of one lattice, moved by `shift`, for the inside of the surface and its margin, thin parts thickened. May be
/// empty.
VolumeMesh fill(const SurfaceMesh& surface, const SurfaceParts& parts, const SurfaceBvh& bvh, double cell,
                const Vec3& shift, const VolumeMeshOptions& options) {
    const double margin = options.margin * cell;
    const double reach = std::max(margin, options.thicken ? thickening.back() * cell : 0.0);
    std::vector<std::pair<SurfaceBvh, double>> thick;  // points, and the radius to fill around them
    const auto inside = [&](const Vec3& p) {
        if (margin > 0 && bvh.closest(p, margin).triangle >= 0) return true;
        for (const auto& [points, radius] : thick)
            if (points.closest(p, radius).triangle >= 0) return true;
        return bvh.winding_number(p) > 0.5;
    };
    const auto stuff = [&] {
        VolumeMesh result;
        result.report.cell = cell;
        result.report.margin = margin;
        result.report.surface_pieces = parts.count;
        TetMesh mesh =
            stuff_isosurface(bvh.low().array() - reach, bvh.high().array() + reach + 2 * shift.array(), cell, inside);
        if (mesh.corners.empty()) return result;
        result.report.separated_vertices = separate_pinches(mesh);
        result.mesh = drop_debris(mesh, bvh, parts, result.report);
        return result;
    };
    VolumeMesh result = stuff();
    if (!options.thicken) return result;

    const std::vector<Vec3> samples = sample_surface(surface, sample_spacing * cell);
    std::size_t thickened = 0;
    for (double radius : thickening) {
        const SurfaceMesh missed = missed_points(samples, result.mesh, missed_distance * cell);
        if (missed.triangles.empty()) break;
        if (thick.empty()) thickened = missed.triangles.size();
        thick.emplace_back(SurfaceBvh(missed), radius * cell);
        result = stuff();
    }
    result.report.samples = samples.size();
    result.report.thickened = thickened;
    return result;
}

/// Calls count(cell) for cells that approach the one with `target` tets, from `cell` on and never below `smallest`.
template <class Count>
void approach(double target, double smallest, double cell, const Count& count) {
    double fewer = 0, more = 0;  // cells known to give fewer, more tets than wanted
    for (int attempt = 0; attempt < max_attempts; ++attempt) {
        cell = std::max(cell, smallest);
        const double tets = count(cell);
        if (std::abs(tets - target) <= count_tolerance * target) return;
        (tets < target ? fewer : more) = cell;
        // No cell is better where the count jumps, and none may be smaller.
        if (fewer > 0 && more > 0 && std::abs(std::log(fewer / more)) < 0.01) return;
        if (tets < target && cell <= smallest) return;
        cell *= std::clamp(std::cbrt(tets / target), 0.5, 2.0);
        if (fewer > 0 && more > 0 && !(cell > std::min(fewer, more) && cell < std::max(fewer, more)))
            cell = std::sqrt(fewer * more);
    }
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

}  // namespace

VolumeMesh mesh_volume(const SurfaceMesh& surface, const VolumeMeshOptions& options) {
    const auto fail = [](const std::string& problem, const std::string& remedy) {
        throw InputError{"", "volume mesh", problem, remedy};
    };
    if (options.target_tets < 10 || options.target_tets > 1000000)
        fail("the target of " + std::to_string(options.target_tets) + " tets is out of range", "use 10 to 1000000");
    if (!(options.margin >= 0 && options.margin <= 0.5))
        fail("the margin of " + std::to_string(options.margin) + " cells is out of range", "use 0 to 0.5");
    if (surface.triangles.empty()) fail("the surface has no triangles", "use a triangulated surface");
    for (const Vec3& x : surface.positions)
        if (!x.allFinite()) fail("the surface has a vertex that is not finite", "repair the file");

    const SurfaceBvh bvh(surface);
    const Vec3 extent = bvh.high() - bvh.low();
    if (!(extent.maxCoeff() > 0) || !std::isfinite(extent.squaredNorm()))
        fail("the surface has no extent", "check the file and its scale");

    const SurfaceParts parts = surface_parts(surface);

    // About 12 tets fill a cube of the lattice; a surface that encloses next to nothing starts from its box.
    const double guess = std::max(std::abs(enclosed_volume(surface)), 0.01 * extent.prod());
    const double target = options.target_tets;
    double cell = guess > 0 ? std::cbrt(12 * guess / target) : extent.maxCoeff() / std::cbrt(target);
    cell = std::min(cell, extent.maxCoeff());
    const double smallest = std::cbrt((extent.array() + cell).prod() / (max_cells_per_tet * target));
    std::optional<VolumeMesh> best;
    // The count of a symmetric shape jumps as a symmetric lattice grows, so a crooked one gets a second chance.
    for (const Vec3& shift : {Vec3(0, 0, 0), Vec3(0.11, 0.23, 0.37)}) {
        approach(target, smallest, cell, [&](double trial_cell) {
            VolumeMesh trial = fill(surface, parts, bvh, trial_cell, shift * trial_cell, options);
            const double count = static_cast<double>(trial.mesh.corners.size());
            const auto miss = [&](double n) { return std::abs(std::log(n / target)); };
            if (count > 0 && (!best || miss(count) < miss(static_cast<double>(best->mesh.corners.size()))))
                best = std::move(trial);
            return count;
        });
        if (!best) break;
        if (std::abs(static_cast<double>(best->mesh.corners.size()) - target) <= count_tolerance * target) break;
        cell = best->report.cell;
    }
    if (!best)
        fail("nothing is inside of the surface at this resolution",
             "check that the surface encloses a volume and faces outwards, use more tets, or a margin");

    order_for_refinement(best->mesh);
    best->report.pinched_edges = count_pinched_edges(best->mesh);
    measure(surface, bvh, best->mesh, best->report);
    validate(best->mesh);
    return std::move(*best);
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
