#include "engine/base/error.hpp"
#include "server/cli/commands.hpp"

#include <gtest/gtest.h>

namespace tetfront {
namespace {

TEST(SceneArguments, SettingsBecomePointersAndJson) {
    EXPECT_EQ(parse_setting("front.tolerance=0.01"), (Override{"/front/tolerance", "0.01"}));
    EXPECT_EQ(parse_setting("/front/tolerance=0.01"), (Override{"/front/tolerance", "0.01"}));
    EXPECT_EQ(parse_setting("gravity=[0,0,-1.62]"), (Override{"/gravity", "[0,0,-1.62]"}));
    EXPECT_EQ(parse_setting("view.colouring=stiffness"), (Override{"/view/colouring", "\"stiffness\""}));
    EXPECT_EQ(parse_setting("title=a=b"), (Override{"/title", "\"a=b\""}));
    EXPECT_EQ(parse_setting("title="), (Override{"/title", "\"\""}));
    EXPECT_THROW(parse_setting("title"), InputError);
    EXPECT_THROW(parse_setting("=1"), InputError);
}

}  // namespace
}  // namespace tetfront
