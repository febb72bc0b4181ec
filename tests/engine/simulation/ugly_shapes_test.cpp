// A dozen surfaces as ugly as files get: each loads and moves without NaN, or is refused with a reason. `shapes_report`
// takes all of them for 300 steps each.
#include "tests/support/temporary_folder.hpp"
#include "tests/support/ugly_shapes.hpp"

#include <gtest/gtest.h>

namespace tetfront::testing {
namespace {

class UglyShapes : public ::testing::TestWithParam<const char*> {};

TEST_P(UglyShapes, LoadsAndMovesOrIsRefusedWithAReason) {
    const auto all = ugly_shapes();
    const auto shape = std::ranges::find(all, GetParam(), &UglyShape::name);
    ASSERT_NE(shape, all.end());
    const TemporaryFolder directory;
    const auto file = directory.path() / (shape->name + ".off");
    write_off(file, shape->surface);
    const ShapeTrial trial = try_shape(file, {.target_tets = 400, .levels = 1, .steps = 12}, shape->volume);
    if (!trial.refused.empty()) {
        EXPECT_TRUE(shape->refusable) << trial.refused;
        EXPECT_NE(trial.refused.find(file.filename().string()), std::string::npos) << "names the file: " << trial.refused;
        EXPECT_NE(trial.refused.find("; "), std::string::npos) << "says what to do: " << trial.refused;
        return;
    }
    EXPECT_TRUE(trial.finite);
    EXPECT_GT(trial.moved, 0);
    EXPECT_GT(trial.angles[0], 5) << "degrees; isosurface stuffing's bound is about 9";
    EXPECT_LT(trial.angles[1], 165);
    EXPECT_LT(trial.outside, 0.1) << "of the extent";
    // The margin adds a few percent, more where corners are thickened.
    if (shape->volume > 0) EXPECT_LT(std::abs(trial.volume_error), 0.3);
}

INSTANTIATE_TEST_SUITE_P(All, UglyShapes,
                         ::testing::Values("ball", "hole", "perforated", "heavy_noise", "doubled", "flipped_soup", "boxes", "inner_shell", "thin_plate", "open_sheet", "shared_edge",
                                           "ears", "micrometres", "megametres", "klein_bottle", "flat", "not_a_number", "points"),
                         [](const auto& name) { return std::string(name.param); });

}  // namespace
}  // namespace tetfront::testing
