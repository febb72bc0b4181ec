// What ffmpeg is asked for.

#include "server/cli/video.hpp"

#include <gtest/gtest.h>

namespace tetfront {
namespace {

std::string line(const std::string& file, bool even = true) {
    return command_line({.directory = "out/", .first = 0, .count = 9, .fps = 30, .even = even, .file = file});
}

TEST(Video, EndingSaysHowItIsEncoded) {
    EXPECT_EQ(line(""), "ffmpeg -framerate 30 -i out/%06d.png -frames:v 9 -c:v libx264 -crf 18 -pix_fmt yuv420p out.mp4");
    EXPECT_NE(line("a.MKV", false).find("-vf 'pad=ceil(iw/2)*2:ceil(ih/2)*2' -c:v libx264"), std::string::npos);
    EXPECT_EQ(line("a.webp", false), "ffmpeg -framerate 30 -i out/%06d.png -frames:v 9 -c:v libwebp -quality 85 -loop 0 a.webp");
    EXPECT_EQ(line("a.apng"), "ffmpeg -framerate 30 -i out/%06d.png -frames:v 9 -c:v apng -plays 0 a.apng");
    EXPECT_EQ(line("a.GIF"),
              "ffmpeg -framerate 30 -i out/%06d.png -frames:v 9 -filter_complex '[0:v]split[a][b];[a]palettegen[p];[b][p]paletteuse' "
              "-loop 0 a.GIF");
}

}  // namespace
}  // namespace tetfront
