#include "engine/mesh/volume_mesh.hpp"

#include "engine/base/error.hpp"
#include "engine/base/parallel.hpp"
#include "engine/mesh/isosurface_stuffing.hpp"
#include "engine/mesh/surface_parts.hpp"
#include "engine/mesh/tet_repair.hpp"
#include "engine/mesh/volume_report.hpp"
#include "engine/mesh/winding_number.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

namespace tetfront {

namespace {

/// Attempts to hit the target; each multiplies the cell by the cube root of what is missing.
constexpr int max_attempts = 14;
constexpr double count_tolerance = 0.1;
/// A shape that fills less of its box than one tet in so many cubes of the lattice gets fewer tets than wanted.
constexpr double max_cells_per_tet = 100;

// In cells. Samples of the surface that tets miss are filled with balls, in rounds of growing radius; the last radius makes
// tets reach the middle of a ball wherever it lies in the lattice. A larger ball also makes the object fatter, so it is
// used only where what it covers is missed by more than `worth` of its radius: with a fixed 0.1 cells, 1,500 tets gave the
// armadillo 66 % too much volume, now 34 %, and a box of 60 tets three times its own.
constexpr double sample_spacing = 0.3, least_missed = 0.1, worth = 0.4;
constexpr std::array<double, 6> thickening = {0.15, 0.3, 0.45, 0.6, 0.75, 0.75};

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
        const SurfaceMesh missed = missed_points(samples, result.mesh, std::max(least_missed, worth * radius) * cell);
        if (missed.triangles.empty()) break;
        if (thick.empty()) thickened = missed.triangles.size();
        thick.emplace_back(SurfaceBvh(missed), radius * cell);
        result = stuff();
    }
    result.report.samples = samples.size();
    result.report.thickened = thickened;
    return result;
}

/// About 12 tets fill a cube of the lattice. A sheet is covered by one layer of cubes, however thin it is (both sides of it
/// count in the area), and a rod by one row of them.
double likely_cell(const SurfaceMesh& surface, double extent, double target) {
    const double cell = std::max({std::cbrt(12 * std::abs(enclosed_volume(surface)) / target), std::sqrt(6 * area(surface) / target), 12 * extent / target});
    return std::min(cell, extent);
}

/// The cell that cuts the box, one cell larger each way, into max_cells_per_tet cubes for each wanted tet: what a trial
/// costs has a bound, whatever the shape.
double smallest_cell(const Vec3& extent, double target) {
    double small = 0, large = extent.maxCoeff();
    for (int i = 0; i < 60; ++i) {
        const double cell = (small + large) / 2;
        ((extent.array() / cell + 1).prod() > max_cells_per_tet * target ? small : large) = cell;
    }
    return large;
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

    const double target = options.target_tets;
    double cell = likely_cell(surface, extent.maxCoeff(), target);
    const double smallest = smallest_cell(extent, target);
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

}  // namespace tetfront
