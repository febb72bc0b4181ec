#include "server/session/remaining_time.hpp"

#include <gtest/gtest.h>

namespace tetfront {
namespace {

using namespace std::chrono_literals;

TEST(RemainingTime, FollowsTheMeanRateOfAStageAndStartsAnewWithTheNext) {
    RemainingTime remaining;
    const RemainingTime::Clock::time_point start{};
    EXPECT_FALSE(remaining.of("a", 0, start));
    EXPECT_FALSE(remaining.of("a", 0.3, start + 100ms)) << "too early to say";
    EXPECT_FALSE(remaining.of("a", 0.005, start + 10s)) << "too little done to say";
    ASSERT_TRUE(remaining.of("a", 0.25, start + 10s));
    EXPECT_NEAR(*remaining.of("a", 0.25, start + 10s), 30, 1e-9);
    EXPECT_NEAR(*remaining.of("a", 1, start + 20s), 0, 1e-9);
    EXPECT_FALSE(remaining.of("b", 0.5, start + 21s));
    EXPECT_NEAR(*remaining.of("b", 0.75, start + 23s), 2, 1e-9) << "from where it began to be watched";
}

}  // namespace
}  // namespace tetfront
