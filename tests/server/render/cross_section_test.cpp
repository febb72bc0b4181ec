// The front where a plane cuts it.

#include "server/render/cross_section.hpp"

#include "engine/base/error.hpp"
#include "tests/support/blob_frame.hpp"

#include <limits>
#include <map>
#include <numbers>

#include <gtest/gtest.h>

namespace tetfront {
namespace {

/// Area of the triangles of each colour.
std::map<std::array<std::uint8_t, 4>, double> areas(const CrossSection& section) {
    std::map<std::array<std::uint8_t, 4>, double> sums;
    for (const auto& t : section.triangles) {
        const auto at = [&](std::uint32_t v) { return Eigen::Vector3f(section.positions[v].data()); };
        sums[section.colours[t[0]]] += 0.5 * static_cast<double>((at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0])).norm());
    }
    return sums;
}

/// The unit tet, and a second one mirrored at its face z = 0, of the next level.
std::shared_ptr<Frame> two_tets() {
    auto frame = std::make_shared<Frame>();
    auto model = std::make_shared<FrameModel>();
    auto topology = std::make_shared<FrameTopology>();
    model->young_range = {1e4F, 1e6F};
    topology->pieces = {{0, 1, 2, 3}, {2, 1, 0, 4}};
    topology->piece_level = {0, 1};
    topology->piece_young = {1e4F, 1e6F};
    frame->front_positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, -1}};
    frame->model = model, frame->topology = topology;
    return frame;
}

View cut_at(const Vec3& point, const Vec3& normal) {
    View view;
    view.cut = CutPlane{point, normal};
    return view;
}

std::array<std::uint8_t, 4> bytes(Rgb c) { return {c.r, c.g, c.b, 255}; }

TEST(CrossSection, HasTheAreaOfTheTetsThere) {
    const auto frame = two_tets();
    for (const double z : {0.25, 0.5, 0.9}) {
        const auto sums = areas(cross_section(*frame, cut_at({0, 0, z}, {0, 0, 3})));
        ASSERT_EQ(sums.size(), 1U);
        EXPECT_NEAR(sums.at(bytes(level_colour(0))), 0.5 * (1 - z) * (1 - z), 1e-6) << "a triangle";
    }
    const auto both = areas(cross_section(*frame, cut_at({0, 0.25, 0}, {0, 1, 0})));
    EXPECT_NEAR(both.at(bytes(level_colour(0))), 0.5 * 0.75 * 0.75, 1e-6);
    EXPECT_NEAR(both.at(bytes(level_colour(1))), 0.5 * 0.75 * 0.75, 1e-6);
    // x + y = 1/2 meets both tets in quadrilaterals: between z = 0 and 1/2 a rectangle sqrt(1/2) x 1/2.
    const auto quadrilaterals = areas(cross_section(*frame, cut_at({0.5, 0, 0}, {1, 1, 0})));
    EXPECT_NEAR(quadrilaterals.at(bytes(level_colour(0))), std::numbers::sqrt2 / 4, 1e-6);
    EXPECT_TRUE(cross_section(*frame, cut_at({0, 0, 2}, {0, 0, 1})).triangles.empty());
    EXPECT_TRUE(cross_section(*frame, View{}).triangles.empty()) << "no cut";
}

TEST(CrossSection, ColoursFollowTheView) {
    const auto frame = two_tets();
    View view = cut_at({0, 0.25, 0}, {0, 1, 0});
    view.colouring = Colouring::stiffness;
    const auto stiff = areas(cross_section(*frame, view));
    EXPECT_EQ(stiff.size(), 2U);
    EXPECT_TRUE(stiff.contains(bytes(stiffness_colours.back()))) << "the second tet is as stiff as anything";
    view.colouring = Colouring::displacement;
    EXPECT_THROW(cross_section(*frame, view), InputError);
    frame->field = Field::displacement;
    frame->front_values = {0, 0, 0, 1, 0}, frame->surface.resize(1), frame->field_values = {1};
    view.cut = CutPlane{{0, 0, 0.5}, {0, 0, 1}};
    view.range = {0, 1};
    const CrossSection half = cross_section(*frame, view);
    ASSERT_EQ(half.colours.size(), 3U);
    view.range = {0, 0.5};
    EXPECT_EQ(half.colours[0], half.colours[2]) << "the same value at the same height";
    EXPECT_NE(half.colours[0], cross_section(*frame, view).colours[0]);
}

TEST(CrossSection, SurvivesBadNumbersAndVerticesOnThePlane) {
    const auto frame = two_tets();
    EXPECT_NEAR(areas(cross_section(*frame, cut_at({0, 0, 0}, {0, 0, 1}))).begin()->second, 0.5, 1e-6) << "through the common face";
    frame->front_positions[4] = {0, std::numeric_limits<float>::quiet_NaN(), 0};
    EXPECT_EQ(areas(cross_section(*frame, cut_at({0, 0.25, 0}, {0, 1, 0}))).size(), 1U);
}

}  // namespace
}  // namespace tetfront
