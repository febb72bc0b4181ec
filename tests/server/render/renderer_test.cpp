// Pictures of a frame made by hand. The golden files are in tests/golden/render_*.png; TETFRONT_UPDATE_GOLDEN=1 writes
// them anew.

#include "server/render/renderer.hpp"

#include "engine/base/error.hpp"
#include "server/render/colour_scale.hpp"
#include "tests/support/blob_frame.hpp"
#include "tests/support/pictures.hpp"

#include <algorithm>
#include <limits>
#include <set>
#include <thread>

#include <gtest/gtest.h>

namespace tetfront {
namespace {

Renderer& renderer() {  // one GL context for all tests of a process
    static Renderer shared;
    return shared;
}

View small_view(const Frame& frame, int width = 480, int height = 270) {
    return make_view(ViewSpec{}, *frame.model, width, height);
}

Image picture(const Frame& frame, const View& view) { return renderer().render(frame, view, "Blob"); }

/// Where pixels are close to the colour of pulls, also in shadow: [pixels] centre, and how many.
struct Spot {
    double x = 0, y = 0;
    int count = 0;
};
Spot find_pull(const Image& image) {
    Spot spot;
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            const std::uint8_t* p = image.pixel(x, y);
            if (p[0] < 70 || p[1] * 3 > p[0] || p[2] > p[0] || 4 * p[2] < p[0]) continue;
            spot.x += x + 0.5, spot.y += y + 0.5;
            ++spot.count;
        }
    }
    if (spot.count) spot.x /= spot.count, spot.y /= spot.count;
    return spot;
}

TEST(Renderer, MatchesGoldenPictures) {
    auto frame = blob_frame(24);
    View view = small_view(*frame);
    expect_golden_picture("render_level.png", picture(*frame, view));
    view.wireframe = true;
    expect_golden_picture("render_wireframe.png", picture(*frame, view));
    view.colouring = Colouring::stiffness;
    view.wireframe = false;
    frame->pulls = {{{0.3F, -0.2F, 0.7F}, {0.6F, -0.3F, 1.0F}, 2.5F}};
    expect_golden_picture("render_stiffness_pull.png", picture(*frame, view));
    frame->pulls.clear();
    view.surface = false;
    view.background = Background::dark;
    expect_golden_picture("render_edges_dark.png", picture(*frame, view));
}

/// The lump with a field that grows from its foot to its top.
std::shared_ptr<Frame> frame_with(Field field, float most) {
    auto frame = blob_frame(24);
    frame->field = field;
    for (const auto& p : frame->surface) frame->field_values.push_back(most * std::clamp(p[2] / 0.8F, 0.0F, 1.0F));
    return frame;
}

TEST(Renderer, MatchesGoldenPicturesOfEveryColouringAndOverlay) {
    View view = small_view(*blob_frame(24));
    for (const auto& [colouring, most] : {std::pair{Colouring::displacement, 0.12F},
                                          {Colouring::strain, 0.034F},
                                          {Colouring::stress, 1.7e5F},
                                          {Colouring::error, 4e-5F}}) {
        view.colouring = colouring;
        const auto frame = frame_with(field_of(colouring), most);
        expect_golden_picture("render_" + name(colouring) + ".png", picture(*frame, view));
    }
    view.colouring = Colouring::level;
    view.cut = CutPlane{{0.1, 0, 0.4}, {1, -0.35, 0.3}};
    auto without_tets = blob_frame(24);  // of which only the edges are known: the cut is plain
    auto plain = std::make_shared<FrameTopology>(*without_tets->topology);
    plain->pieces.clear(), plain->piece_level.clear(), plain->piece_young.clear();
    without_tets->topology = plain;
    expect_golden_picture("render_cut.png", picture(*without_tets, view));
    view.surface = false;
    expect_golden_picture("render_cut_edges.png", picture(*blob_frame(24), view));
    view.cut.reset(), view.surface = true, view.background = Background::transparent;
    expect_golden_picture("render_transparent.png", picture(*blob_frame(24), view));
}

TEST(Renderer, FieldColoursFollowTheirRange) {
    const auto frame = frame_with(Field::stress, 1.7e5F);
    View view = small_view(*frame);
    view.colouring = Colouring::stress, view.legend = false;
    const Image fitted = picture(*frame, view);
    view.range = {0, readable_ceiling(static_cast<double>(field_high(frame->field_values)))};
    EXPECT_EQ(picture(*frame, view).pixels, fitted.pixels);
    view.range = {0, 4e5};
    EXPECT_GT(share_different(picture(*frame, view), fitted, 20), 0.05);
    view.colouring = Colouring::strain;
    EXPECT_THROW(picture(*frame, view), InputError) << "the frame holds stress only";
    view.colouring = Colouring::stress;
    EXPECT_THROW(picture(*blob_frame(24), view), InputError);
    auto still = frame_with(Field::stress, 0);  // at rest
    view.range.reset(), view.legend = true;
    EXPECT_NO_THROW(picture(*still, view));
    still->field_values[5] = std::numeric_limits<float>::quiet_NaN();
    EXPECT_NO_THROW(picture(*still, view));
}

TEST(Renderer, CutHidesOneSideAndClosesTheOther) {
    const auto frame = blob_frame(24);
    View view = small_view(*frame);
    view.legend = false, view.floor.reset(), view.background = Background::transparent;
    const auto covered = [&](const View& v) {
        const Image image = picture(*frame, v);
        int count = 0;
        for (int i = 0; i < image.width * image.height; ++i) count += image.pixel(i % image.width, i / image.width)[3] > 128;
        return count;
    };
    const int whole = covered(view);
    ASSERT_GT(whole, 5000);
    const Vec3 towards = (view.eye - view.target).normalized();
    view.cut = CutPlane{view.target, towards};  // the near half is gone: the far one has the same outline
    EXPECT_NEAR(covered(view), whole, 0.25 * whole);
    view.cut = CutPlane{view.target + 10 * towards, towards};
    EXPECT_EQ(covered(view), whole);
    view.cut = CutPlane{view.target - 10 * towards, towards};
    EXPECT_EQ(covered(view), 0);
    view.cut = CutPlane{{0, 0, 0.4}, {0, 0, 2}};  // normals need no unit length
    EXPECT_LT(covered(view), 0.8 * whole);
    EXPECT_GT(covered(view), 0.3 * whole);
}

TEST(Renderer, CutShowsTheTetsInside) {
    const auto frame = blob_frame(24);
    View view = small_view(*frame);
    view.legend = false, view.floor.reset();
    const Vec3 towards = (view.eye - view.target).normalized();
    view.cut = CutPlane{{0, 0, 0.4}, towards};
    const auto hue = [&](const std::uint8_t* p) {  // of the three levels' colours the nearest in direction
        int best = -1;
        double most = 0;
        for (int level = 0; level < 3; ++level) {
            const Rgb c = level_colour(level);
            const Vec3 a(p[0], p[1], p[2]), b(c.r, c.g, c.b);
            const double likeness = a.normalized().dot(b.normalized());
            if (likeness > most) most = likeness, best = level;
        }
        return best;
    };
    const Image image = picture(*frame, view);
    const auto seen_at = [&](const Vec3& p) {
        const Eigen::Vector4f clip = clip_from_eye(view, 0.1, 10) * eye_from_world(view) * p.cast<float>().homogeneous();
        return hue(image.pixel(static_cast<int>((clip[0] / clip[3] + 1) / 2 * static_cast<float>(view.width)),
                               static_cast<int>((1 - clip[1] / clip[3]) / 2 * static_cast<float>(view.height))));
    };
    const Vec3 upwards = (Vec3::UnitZ() - towards[2] * towards).normalized();
    EXPECT_EQ(seen_at({0, 0, 0.4}), 0) << "the middle";
    EXPECT_EQ(seen_at(Vec3(0, 0, 0.4) + 0.33 * upwards), 2);
    EXPECT_EQ(seen_at(Vec3(0, 0, 0.4) - 0.33 * upwards), 1);
    view.wireframe = true;
    EXPECT_GT(share_different(image, picture(*frame, view), 10), 0.02) << "their edges";
}

TEST(Renderer, ComparisonSeesPlantedFaults) {
    if (std::getenv("TETFRONT_UPDATE_GOLDEN")) GTEST_SKIP();
    const Image golden = read_png(golden_picture("render_level.png"));
    ASSERT_TRUE(same_picture(golden, golden));
    Image mirrored = golden, upside_down = golden, recoloured = golden, shifted = golden;
    for (int y = 0; y < golden.height; ++y) {
        for (int x = 0; x < golden.width; ++x) {
            const std::uint8_t* p = golden.pixel(x, y);
            std::copy(p, p + 3, mirrored.pixel(golden.width - 1 - x, y));
            std::copy(p, p + 3, upside_down.pixel(x, golden.height - 1 - y));
            std::copy(p, p + 3, shifted.pixel(std::min(x + 1, golden.width - 1), y));
            std::swap(recoloured.pixel(x, y)[0], recoloured.pixel(x, y)[2]);
        }
    }
    EXPECT_FALSE(same_picture(golden, mirrored));
    EXPECT_FALSE(same_picture(golden, upside_down));
    EXPECT_FALSE(same_picture(golden, recoloured));
    EXPECT_FALSE(same_picture(golden, shifted));

    // One level's colour, the legend and the shadow are details that must not slip through either.
    auto frame = blob_frame(24);
    const View view = small_view(*frame);
    View changed = view;
    changed.legend = false;
    EXPECT_FALSE(same_picture(golden, picture(*frame, changed)));
    changed = view, changed.floor.reset();
    EXPECT_FALSE(same_picture(golden, picture(*frame, changed)));
    auto topology = std::make_shared<FrameTopology>(*frame->topology);
    for (std::uint8_t& level : topology->surface_level) level = level == 2 ? 1 : level;
    frame->topology = topology;
    EXPECT_FALSE(same_picture(golden, picture(*frame, view)));
}

TEST(Renderer, DrawsPointsWhereTheCameraSeesThem) {
    for (int up = 0; up < 3; ++up) {
        auto frame = blob_frame(12, up);
        View view = small_view(*frame);
        view.legend = false;
        ASSERT_EQ(find_pull(picture(*frame, view)).count, 0);
        // Balls that hover around the object, one at a time.
        for (const Vec3& offset : {Vec3(0.1, 0.2, 0.75), Vec3(-0.62, 0.1, 0.1), Vec3(0.5, -0.6, -0.1)}) {
            const Eigen::Vector3f p = (view.target + offset).cast<float>();
            frame->pulls = {{{p[0], p[1], p[2]}, {p[0], p[1], p[2]}, 0}};
            const Eigen::Vector4f clip = clip_from_eye(view, 0.1, 10) * eye_from_world(view) * p.homogeneous();
            const double x = (clip[0] / clip[3] + 1) / 2 * view.width;
            const double y = (1 - clip[1] / clip[3]) / 2 * view.height;  // row 0 is at the top
            if (x < 5 || y < 5 || x > view.width - 5 || y > view.height - 5) continue;
            const Spot spot = find_pull(picture(*frame, view));
            if (spot.count == 0) continue;  // behind the object
            EXPECT_NEAR(spot.x, x, 1.5) << up << ", " << offset.transpose();
            EXPECT_NEAR(spot.y, y, 1.5) << up << ", " << offset.transpose();
        }
        const Eigen::Vector3f p = (view.target + 0.7 * Vec3::Unit(up)).cast<float>();
        frame->pulls = {{{p[0], p[1], p[2]}, {p[0], p[1], p[2]}, 0}};
        const Spot above = find_pull(picture(*frame, view));
        EXPECT_GT(above.count, 5) << "a mark above the object is seen";
        EXPECT_LT(above.y, view.height / 3.0) << "and is in the upper part";
    }
}

TEST(Renderer, SameInputSameBytes) {
    const auto frame = blob_frame(16);
    View view = small_view(*frame, 320, 180);
    view.wireframe = true;
    const Image first = picture(*frame, view);
    // Something else in between must leave no trace.
    View other = small_view(*frame, 200, 300);
    other.background = Background::transparent, other.colouring = Colouring::stiffness, other.supersampling = 3;
    picture(*blob_frame(9, 1), other);
    EXPECT_EQ(first.pixels, picture(*frame, view).pixels);
    std::vector<std::uint8_t> elsewhere;
    std::thread([&] { elsewhere = Renderer().render(*frame, view, "Blob").pixels; }).join();
    EXPECT_EQ(first.pixels, elsewhere) << "another context, another thread";
}

TEST(Renderer, HidesEdgesInsideOfTheBody) {
    auto frame = blob_frame(16);
    View view = small_view(*frame, 320, 180);
    view.legend = false;
    const Image plain = picture(*frame, view);
    view.wireframe = true;
    EXPECT_GT(share_different(plain, picture(*frame, view), 10), 0.02) << "the cage around it is seen";
    for (auto& p : frame->front_positions) {
        for (std::size_t i = 0; i < 3; ++i) p[i] = i == 2 ? 0.4F + (p[i] - 0.4F) / 2 : p[i] / 2;
    }
    EXPECT_EQ(share_different(plain, picture(*frame, view), 1), 0) << "the same cage inside is not";
    view.surface = false;
    EXPECT_GT(share_different(plain, picture(*frame, view), 10), 0.02) << "unless there is no surface";
}

TEST(Renderer, TransparentBackgroundHasStraightAlpha) {
    const auto frame = blob_frame(16);
    View view = small_view(*frame, 320, 180);
    view.legend = false, view.background = Background::transparent;
    const Image clear = picture(*frame, view);
    ASSERT_EQ(clear.channels, 4);
    EXPECT_EQ(clear.pixel(2, 2)[3], 0);
    EXPECT_EQ(clear.pixel(160, 90)[3], 255) << "the object is opaque";
    int shadow = 0;
    for (int i = 0; i < 320 * 180; ++i) {
        const std::uint8_t alpha = clear.pixel(i % 320, i / 320)[3];
        shadow += alpha > 5 && alpha < 160;
    }
    EXPECT_GT(shadow, 500) << "the floor's shadow is not";
    view.background = Background::light;
    const Image light = picture(*frame, view);
    ASSERT_EQ(light.channels, 3);
    for (int c = 0; c < 3; ++c) EXPECT_EQ(light.pixel(160, 90)[c], clear.pixel(160, 90)[c]);
}

TEST(Renderer, TilesMeetWithoutASeam) {
    const auto frame = blob_frame(16);
    View view = small_view(*frame, 1500, 200);
    view.legend = false, view.wireframe = true;
    view.target[0] -= 0.12, view.eye[0] -= 0.12;  // the object lies across the border of the tiles
    view.supersampling = 1;
    const Image one = picture(*frame, view);  // a single tile
    view.supersampling = 4;                   // several, both ways
    const Image many = picture(*frame, view);
    view.supersampling = 3;
    const Image other = picture(*frame, view);
    EXPECT_LT(share_different(many, other, 12), 0.01);
    EXPECT_LT(share_different(many, one, 60), 0.01);
    EXPECT_GT(share_different(many, Image(1500, 200, 3), 60), 0.9);
}

TEST(Renderer, AnySupersamplingShowsTheSame) {
    const auto frame = blob_frame(16);
    View view = small_view(*frame, 160, 90);
    view.legend = false, view.supersampling = 4;
    const Image reference = picture(*frame, view);
    std::set<std::vector<std::uint8_t>> different;
    for (int n = 1; n <= 4; ++n) {
        view.supersampling = n;
        const Image image = picture(*frame, view);
        EXPECT_LT(share_different(image, reference, 16), n == 1 ? 0.08 : 0.02) << n;
        different.insert(image.pixels);
    }
    EXPECT_EQ(different.size(), 4U) << "and each smooths in its own way";
}

TEST(Renderer, BadNumbersInAFrameDoNoHarm) {
    auto frame = blob_frame(16);
    View view = small_view(*frame, 160, 90);
    view.wireframe = true;
    const Image intact = picture(*frame, view);
    frame->surface[3] = {std::numeric_limits<float>::quiet_NaN(), 0, 0};
    frame->front_positions[2][1] = std::numeric_limits<float>::infinity();
    frame->pulls = {{{0, 0, std::numeric_limits<float>::quiet_NaN()}, {1, 1, 1}, 1}};
    view.legend = false;
    EXPECT_LT(share_different(intact, picture(*frame, view), 40), 0.15) << "the rest is drawn as ever";
    frame->surface.clear();
    EXPECT_THROW(picture(*frame, view), LogicError) << "arrays that do not fit each other are a bug";
    EXPECT_NO_THROW(picture(*blob_frame(16), view)) << "and the renderer still works";
}

TEST(Renderer, BelongsToItsThread) {
    const auto frame = blob_frame(4);
    const View view = small_view(*frame, 64, 64);
    picture(*frame, view);
    std::thread([&] { EXPECT_THROW(picture(*frame, view), LogicError); }).join();
}

}  // namespace
}  // namespace tetfront
