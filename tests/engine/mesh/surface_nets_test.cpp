#include "engine/mesh/surface_nets.hpp"

#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include "engine/base/error.hpp"
#include "engine/mesh/winding_number.hpp"

namespace tetfront {
namespace {

double volume(const SurfaceMesh& s) {
    double sum = 0;
    for (const auto& t : s.triangles)
        sum += signed_volume(Vec3::Zero(), s.positions[static_cast<std::size_t>(t[0])],
                             s.positions[static_cast<std::size_t>(t[1])], s.positions[static_cast<std::size_t>(t[2])]);
    return sum;
}

/// Directed edges and how often they occur: in a closed oriented surface as often as their reverse.
bool closed(const SurfaceMesh& s) {
    std::map<std::pair<std::int32_t, std::int32_t>, int> edges;
    for (const auto& t : s.triangles)
        for (std::size_t i = 0; i < 3; ++i) {
            ++edges[{t[i], t[(i + 1) % 3]}];
            --edges[{t[(i + 1) % 3], t[i]}];
        }
    return std::ranges::all_of(edges, [](const auto& e) { return e.second == 0; });
}

TEST(SurfaceNets, BallIsClosedFacesOutwardsAndConverges) {
    // Linear across the surface, so that crossings are exact.
    const auto ball = [](const Vec3& p) { return 0.5 + (0.8 - p.norm()); };
    double before = 0;
    for (const double cell : {0.2, 0.1, 0.05}) {
        const SurfaceMesh s = surface_nets({-1, -1, -1}, {1, 1, 1}, cell, ball);
        EXPECT_TRUE(closed(s));
        double worst = 0;
        for (const Vec3& p : s.positions) worst = std::max(worst, std::abs(p.norm() - 0.8));
        EXPECT_LT(worst, cell * cell) << "second order";
        const double error = std::abs(volume(s) - 4.0 / 3 * M_PI * 0.512);
        EXPECT_GT(volume(s), 0);
        EXPECT_TRUE(before == 0 || error < before / 3) << error;
        before = error;
    }
}

TEST(SurfaceNets, ShapesThatReachTheBoxAreClosed) {
    const SurfaceMesh s = surface_nets({0, 0, 0}, {1, 2, 3}, 0.25, [](const Vec3&) { return 1.0; });
    EXPECT_TRUE(closed(s));
    EXPECT_GT(volume(s), 1 * 2 * 3.0);
    EXPECT_LT(volume(s), 1.25 * 2.25 * 3.25) << "half a cell more on each side, edges rounded";
    EXPECT_GT(SurfaceBvh(s).winding_number({0.5, 1, 1.5}), 0.99);
}

TEST(SurfaceNets, NothingInsideIsEmptyAndNotANumberIsOutside) {
    EXPECT_TRUE(surface_nets({0, 0, 0}, {1, 1, 1}, 0.25, [](const Vec3&) { return 0.5; }).triangles.empty());
    const SurfaceMesh s = surface_nets({0, 0, 0}, {1, 1, 1}, 0.25,
                                       [](const Vec3& p) { return p.x() > 0.6 ? std::nan("") : 1.0; });
    EXPECT_TRUE(closed(s));
    for (const Vec3& p : s.positions) EXPECT_TRUE(p.allFinite());
}

TEST(SurfaceNets, RefusesWhatIsTooLargeOrNoBox) {
    const auto field = [](const Vec3&) { return 1.0; };
    EXPECT_THROW(surface_nets({0, 0, 0}, {1, 1, 1}, 1e-3, field), InputError);
    EXPECT_THROW(surface_nets({0, 0, 0}, {1, 1, 1}, 0, field), InputError);
    EXPECT_THROW(surface_nets({0, 0, 0}, {-1, 1, 1}, 0.1, field), InputError);
    EXPECT_THROW(surface_nets({0, 0, 0}, {1, 1, INFINITY}, 0.1, field), InputError);
}

}  // namespace
}  // namespace tetfront
