#pragma once
// Surfaces as they come: with holes, noise, flipped and doubled faces, shells in shells, sheets, absurd scales. And a trial
// that loads one from a file, meshes it and moves it.
//
//     for (const UglyShape& s : ugly_shapes()) {
//         write_off(folder / (s.name + ".off"), s.surface);
//         ShapeTrial t = try_shape(folder / (s.name + ".off"), {.target_tets = 400, .levels = 1, .steps = 300}, s.volume);
//         t.refused                                             // empty: it loaded
//     }

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "engine/base/error.hpp"
#include "engine/mesh/mesh_io.hpp"
#include "engine/simulation/shape.hpp"
#include "engine/simulation/simulation.hpp"
#include "tests/engine/mesh/shapes.hpp"

namespace tetfront::testing {

struct UglyShape {
    std::string name, ugliness;
    SurfaceMesh surface;
    double volume = 0;      // [unit of the file, cubed] that a person sees; 0: not known, or none
    bool refusable = false;  // no surface: a refusal with a reason is right
};

inline SurfaceMesh noisy(SurfaceMesh mesh, double size) {
    std::mt19937 random(1);
    const auto uniform = [&] { return size * (2.0 * static_cast<double>(random()) / 4294967295.0 - 1); };
    for (Vec3& x : mesh.positions) x += Vec3(uniform(), uniform(), uniform());
    return mesh;
}

/// Every triangle with corners of its own, as STL files have them.
inline SurfaceMesh soup(const SurfaceMesh& mesh) {
    SurfaceMesh result;
    for (const auto& t : mesh.triangles) {
        const auto first = static_cast<std::int32_t>(result.positions.size());
        for (const std::int32_t v : t) result.positions.push_back(mesh.positions[static_cast<std::size_t>(v)]);
        result.triangles.push_back({first, first + 1, first + 2});
    }
    return result;
}

inline SurfaceMesh scaled(SurfaceMesh mesh, double factor, const Vec3& shift = Vec3::Zero()) {
    for (Vec3& x : mesh.positions) x = factor * x + shift;
    return mesh;
}

/// Keeps the triangles whose number satisfies keep.
template <class Keep>
SurfaceMesh numbered(SurfaceMesh mesh, const Keep& keep) {
    std::vector<std::array<std::int32_t, 3>> kept;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        if (keep(i)) kept.push_back(mesh.triangles[i]);
    mesh.triangles = std::move(kept);
    return mesh;
}

inline std::vector<UglyShape> ugly_shapes() {
    using namespace test_surfaces;
    constexpr double pi = std::numbers::pi, ball_volume = 4.0 / 3 * pi * 0.125;
    const SurfaceMesh ball = sphere({0, 0, 0}, 0.5, 4);
    const auto joined = [](SurfaceMesh a, const SurfaceMesh& b, bool flipped = false) {
        append(a, b, flipped);
        return a;
    };
    const auto turned = [](SurfaceMesh mesh, const auto& which) {
        for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
            if (which(i)) std::swap(mesh.triangles[i][1], mesh.triangles[i][2]);
        return mesh;
    };
    std::vector<UglyShape> all;
    const auto add = [&](const std::string& name, const std::string& ugliness, SurfaceMesh mesh, double volume = 0, bool refusable = false) {
        all.push_back({name, ugliness, std::move(mesh), volume, refusable});
    };
    add("ball", "nothing, for comparison", ball, ball_volume);
    add("hole", "a cap is missing", part(ball, [](const Vec3& p) { return p.z() < 0.4; }), ball_volume);
    add("half_scan", "only the upper half was scanned", part(ball, [](const Vec3& p) { return p.z() > 0; }));
    add("perforated", "every fourth face is missing", numbered(ball, [](std::size_t i) { return i % 4 != 0; }), ball_volume);
    add("noise", "vertices moved by up to 2 % of the diameter", noisy(ball, 0.02), ball_volume);
    add("heavy_noise", "by up to 10 %: it cuts itself everywhere", noisy(ball, 0.1));
    add("doubled", "every face twice", joined(ball, ball), ball_volume);
    add("flipped_faces", "every third face looks inwards", turned(ball, [](std::size_t i) { return i % 3 == 0; }), ball_volume);
    add("flipped_soup", "every third face looks inwards, none shares a vertex", turned(soup(ball), [](std::size_t i) { return i % 3 == 0; }), ball_volume);
    add("inside_out", "all faces look inwards", turned(ball, [](std::size_t) { return true; }), ball_volume);
    add("cracked", "faces are 0.2 % apart from each other", noisy(soup(ball), 0.002), ball_volume);
    add("overlapping", "two balls interpenetrate", joined(ball, sphere({0.4, 0, 0}, 0.4, 4)));
    {
        SurfaceMesh boxes;
        for (int i = 0; i < 6; ++i) append(boxes, cube(Vec3(0.15 * i, 0.1 * (i % 2), 0.1 * (i % 3)), Vec3(0.15 * i + 0.3, 0.1 * (i % 2) + 0.3, 0.1 * (i % 3) + 0.3)), i % 2 == 1);
        add("boxes", "six boxes interpenetrate, half of them inside out", boxes);
    }
    add("cavity", "an inner shell makes it hollow", joined(ball, sphere({0, 0, 0}, 0.3, 3), true), ball_volume * (1 - 0.216));
    add("inner_shell", "an inner shell looks outwards", joined(ball, sphere({0, 0, 0}, 0.3, 3)), ball_volume);
    add("shells", "three shells in each other", joined(joined(ball, sphere({0, 0, 0}, 0.35, 3), true), sphere({0, 0, 0}, 0.2, 3)), ball_volume * (1 - 0.343 + 0.064));
    add("thin_plate", "1 x 1 x 0.01", boundary_surface(box_mesh({0, 0, 0}, {1, 1, 0.01}, {20, 20, 1})));
    add("open_sheet", "one face thick, encloses nothing", part(boundary_surface(box_mesh({0, 0, 0}, {1, 1, 0.3}, {12, 12, 1})), [](const Vec3& p) { return p.z() > 0.29; }));
    add("ears", "a ball with two blades 0.02 thick", joined(joined(ball, cube({-0.25, -0.01, 0.3}, {-0.05, 0.01, 1})), cube({0.05, -0.01, 0.3}, {0.25, 0.01, 1})));
    add("needle", "1 long, 0.02 wide", boundary_surface(box_mesh({0, 0, 0}, {0.02, 0.02, 1}, {1, 1, 40})));
    add("thin_ring", "a torus 0.03 thick", torus(0.5, 0.015, 96, 8));
    add("micrometres", "a ball 1e-6 wide", scaled(ball, 1e-6), ball_volume * 1e-18);
    add("megametres", "a ball 1e6 wide", scaled(ball, 1e6), ball_volume * 1e18);
    add("far_away", "a ball 100 diameters from the origin", scaled(ball, 1, {100, 0, 0}), ball_volume);
    add("shared_edge", "two cubes share an edge", joined(cube({0, 0, 0}, {0.5, 0.5, 0.5}), cube({0.5, 0.5, 0}, {1, 1, 0.5})), 0.25);
    add("shared_corner", "two cubes share a corner", joined(cube({0, 0, 0}, {0.5, 0.5, 0.5}), cube({0.5, 0.5, 0.5}, {1, 1, 1})), 0.25);
    add("inner_walls", "walls run through the inside: edges of three and four faces",
        joined(joined(cube({0, 0, 0}, {1, 1, 1}), part(cube({0, 0, 0}, {0.5, 1, 1}), [](const Vec3& p) { return p.x() > 0.49; })),
               part(cube({0, 0, 0}, {1, 0.5, 1}), [](const Vec3& p) { return p.y() > 0.49; })), 1);
    add("fins", "a ball with loose faces that stand off", joined(ball, numbered(scaled(ball, 1.3), [](std::size_t i) { return i % 97 == 0; })));
    add("pieces", "five balls apart from each other", joined(joined(ball, sphere({1.2, 0, 0}, 0.3, 3)), joined(sphere({0, 1.2, 0}, 0.3, 3), joined(sphere({0, 0, 1.2}, 0.3, 3), sphere({-1, 0, 0}, 0.1, 2)))));
    {
        SurfaceMesh mesh = ball;
        for (std::size_t i = 0; i < ball.triangles.size(); i += 5) {
            const auto t = ball.triangles[i];
            mesh.triangles.push_back({t[0], t[0], t[1]});
            mesh.positions.push_back((ball.positions[static_cast<std::size_t>(t[0])] + ball.positions[static_cast<std::size_t>(t[1])]) / 2);
            mesh.triangles.push_back({t[0], t[1], static_cast<std::int32_t>(mesh.positions.size() - 1)});
        }
        add("degenerate", "faces that are edges, faces without area", mesh, ball_volume);
    }
    add("klein_bottle", "has no inside and no outside", wrapped_grid(64, 32, [](double s, double t) {
            const double u = 2 * std::numbers::pi * s, v = 2 * std::numbers::pi * t;
            const double r = 0.5 + 0.2 * (std::cos(u / 2) * std::sin(v) - std::sin(u / 2) * std::sin(2 * v));
            return Vec3(r * std::cos(u), r * std::sin(u), 0.2 * (std::sin(u / 2) * std::sin(v) + std::cos(u / 2) * std::sin(2 * v)));
        }));
    add("flat", "all of it lies in a plane", scaled(part(cube({0, 0, 0}, {1, 1, 1}), [](const Vec3& p) { return p.z() < 0.01; }), 1));
    {
        SurfaceMesh mesh = ball;
        mesh.positions[17].y() = std::numeric_limits<double>::quiet_NaN();
        add("not_a_number", "a coordinate is nan", mesh, 0, true);
    }
    add("points", "no faces at all", numbered(ball, [](std::size_t) { return false; }), 0, true);
    return all;
}

/// OFF, with all digits that readers keep.
inline void write_off(const std::filesystem::path& file, const SurfaceMesh& mesh) {
    std::ofstream out(file);
    out.precision(9);
    out << "OFF\n" << mesh.positions.size() << ' ' << mesh.triangles.size() << " 0\n";
    for (const Vec3& x : mesh.positions) out << x[0] << ' ' << x[1] << ' ' << x[2] << '\n';
    for (const auto& t : mesh.triangles) out << "3 " << t[0] << ' ' << t[1] << ' ' << t[2] << '\n';
    if (!out.flush()) throw std::runtime_error(file.string() + ": cannot be written");
}

struct TrialOptions {
    int target_tets = 400, levels = 1, steps = 300;
};

struct ShapeTrial {
    std::string refused;  // why; empty: it loaded
    std::string mended;   // what repair() did and found
    std::size_t triangles = 0, tets = 0;
    double volume_error = 0;          // of the tets against the volume that is known, else against what the surface encloses
    double outside = 0;               // largest distance of a surface vertex to the tets, over the extent
    double thickened = 0;             // share of the surface
    std::array<double, 2> angles{};   // [degrees] smallest and largest dihedral angle
    double load_seconds = 0, run_seconds = 0;
    double tets_mean = 0;             // of the front
    int troubled = 0, inverted = 0;   // steps that did not converge or were rejected; that left an inverted tet
    bool finite = true;               // every position, after every step
    double moved = 0;                 // farthest surface vertex from rest, of all steps, over the extent
};

inline bool is_finite(const Frame& frame) {
    return std::ranges::all_of(frame.surface, [](const auto& p) { return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]); });
}

/// Loads the file as `tetfront import` would, holds the lowest twentieth, lets it sag for half of the steps and then pulls
/// its highest point up and aside. volume: see UglyShape.
inline ShapeTrial try_shape(const std::filesystem::path& file, const TrialOptions& options, double volume = 0) {
    using Clock = std::chrono::steady_clock;
    const auto seconds = [](Clock::time_point since) { return std::chrono::duration<double>(Clock::now() - since).count(); };
    ShapeTrial trial;
    const auto start = Clock::now();
    try {
        Eigen::AlignedBox3d box;
        for (const Vec3& x : read_surface(file).mesh.positions) box.extend(x);
        const double in_file = box.sizes().maxCoeff(), scale = in_file >= 0.01 && in_file <= 10 ? 1 : 0.5 / in_file;
        const double extent = scale * in_file, low = scale * box.min().z();
        Scene scene;
        scene.name = file.stem().string();
        scene.file = file;
        scene.mesh = SurfaceMeshSpec{.files = {file}, .scale = scale, .target_tets = options.target_tets};
        scene.levels = options.levels;
        scene.material.materials[0].young = 25 * 1000 * 9.81 * extent;
        scene.material.materials[0].poisson = 0.35;
        scene.material.materials[0].mass_damping = 0.3;
        scene.pins = {HalfSpace{scale * box.center() + Vec3(0, 0, low + 0.05 * scale * box.sizes().z() - scale * box.center().z()), Vec3::UnitZ()}};
        scene.front.budget_tets = 3000;
        Shape shape = make_shape(scene);
        if (shape.surface_repairs) trial.mended = describe(*shape.surface_repairs);
        const VolumeMeshReport& mesh = *shape.meshing;
        trial.triangles = shape.surface.triangles.size();
        trial.tets = mesh.tets;
        const double wanted = volume > 0 ? volume * scale * scale * scale : std::abs(mesh.surface_volume);
        trial.volume_error = wanted > 0 ? mesh.mesh_volume / wanted - 1 : std::numeric_limits<double>::infinity();
        trial.outside = mesh.outside_distance / extent;
        trial.thickened = mesh.samples > 0 ? static_cast<double>(mesh.thickened) / static_cast<double>(mesh.samples) : 0;
        trial.angles = mesh.dihedral;
        const auto model = build_model(scene, std::move(shape));
        trial.load_seconds = seconds(start);

        Simulation simulation(model);
        const auto& rest = model->surface.mesh.positions;
        const auto& triangles = model->frame_model->triangles;
        const auto height = [&](const auto& t) { return rest[t[0]].z() + rest[t[1]].z() + rest[t[2]].z(); };
        const auto top = std::ranges::max_element(triangles, {}, height);
        const auto run = Clock::now();
        for (int i = 0; i < options.steps; ++i) {
            if (i == options.steps / 2) {
                const SurfacePoint point{static_cast<std::uint32_t>(top - triangles.begin()), Vec3::Constant(1.0 / 3)};
                simulation.begin_pull(1, point, rest[(*top)[0]] + extent * Vec3(0.3, 0.1, 0.4));
            }
            const StepReport report = simulation.step();
            trial.troubled += !report.converged || report.rejected;
            trial.inverted += report.inverted_tets > 0;
            for (const std::uint32_t n : report.tets_by_level) trial.tets_mean += static_cast<double>(n) / options.steps;
            const auto frame = simulation.frame();
            trial.finite = trial.finite && is_finite(*frame);
            for (std::size_t v = 0; v < rest.size(); ++v)
                trial.moved = std::max(trial.moved, (Vec3(frame->surface[v][0], frame->surface[v][1], frame->surface[v][2]) - rest[v]).norm() / extent);
        }
        trial.run_seconds = seconds(run);
    } catch (const InputError& error) {
        trial.refused = error.what();
    }
    return trial;
}

}  // namespace tetfront::testing
