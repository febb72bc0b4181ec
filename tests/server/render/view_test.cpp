#include "server/render/view.hpp"

#include "engine/base/error.hpp"

#include <Eigen/Geometry>
#include <random>

#include <gtest/gtest.h>

namespace tetfront {
namespace {

/// Normalised device coordinates, x right, y up, both -1..1 inside of the picture; z -1 near, 1 far.
Eigen::Vector3d project(const View& view, const Vec3& p) {
    const Eigen::Vector4f clip = clip_from_eye(view, 0.01, 1e4) * eye_from_world(view) * p.cast<float>().homogeneous();
    return clip.head<3>().cast<double>() / static_cast<double>(clip[3]);
}

TEST(View, CameraLooksWhereItShould) {
    View view;
    view.eye = {0, -5, 0}, view.target = {0, 0, 0}, view.up = 2;
    EXPECT_NEAR(project(view, {0, 0, 0}).head<2>().norm(), 0, 1e-6);
    EXPECT_GT(project(view, {1, 0, 0}).x(), 0.1) << "x is to the right";
    EXPECT_GT(project(view, {0, 0, 1}).y(), 0.1) << "z is up";
    EXPECT_GT(project(view, {0, 1, 0}).z(), project(view, {0, 0, 0}).z()) << "y is away";
    const double half = std::tan(view.field_of_view / 2 * 3.14159265358979 / 180) * 5;
    EXPECT_NEAR(project(view, {0, 0, half}).y(), 1, 1e-5) << "the field of view is vertical";
    EXPECT_NEAR(project(view, {half * view.width / view.height, 0, 0}).x(), 1, 1e-5);
}

TEST(View, FittedCameraSeesAllOfTheBoxAndNotMuchElse) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> somewhere(-20, 20), extent(-3, 3);
    for (int trial = 0; trial < 300; ++trial) {
        View view;
        view.up = trial % 3;
        view.width = trial % 2 ? 1280 : 300, view.height = trial % 5 ? 720 : 400;
        view.field_of_view = 15 + trial % 7 * 15;
        std::array<float, 6> box{};
        for (std::size_t i = 0; i < 3; ++i) {
            box[i] = somewhere(random);
            box[i + 3] = box[i] + std::pow(10.0F, extent(random) / 2);
        }
        fit_camera(view, box, 0.1);
        double widest = 0;
        for (std::size_t corner = 0; corner < 8; ++corner) {
            const Vec3 p(box[corner & 1 ? 3 : 0], box[corner & 2 ? 4 : 1], box[corner & 4 ? 5 : 2]);
            const auto at = project(view, p);
            EXPECT_LE(std::abs(at.x()), 0.902) << trial;
            EXPECT_LE(std::abs(at.y()), 0.902) << trial;
            EXPECT_LT(at.z(), 1) << trial;
            widest = std::max({widest, std::abs(at.x()), std::abs(at.y())});
        }
        // Close up, with a wide angle, the camera keeps out of the box rather than filling the picture.
        if (view.field_of_view < 40) EXPECT_GT(widest, 0.85) << trial;
        EXPECT_GT((view.eye - view.target)[view.up], 0) << "from above";
    }
}

TEST(View, TurntableKeepsHeightAndDistance) {
    View view;
    view.eye = {3, -4, 2}, view.target = {1, 0, 0.5}, view.up = 2;
    for (const double turns : {0.1, 0.25, 0.9}) {
        const View turned = turntable(view, turns);
        EXPECT_NEAR((turned.eye - turned.target).norm(), (view.eye - view.target).norm(), 1e-12);
        EXPECT_NEAR(turned.eye.z(), view.eye.z(), 1e-12);
    }
    EXPECT_NEAR((turntable(view, 1).eye - view.eye).norm(), 0, 1e-12);
    // Counter-clockwise from above: from -y a quarter turn leads to +x.
    view.eye = {0, -4, 2}, view.target = {0, 0, 0};
    EXPECT_NEAR((turntable(view, 0.25).eye - Vec3(4, 0, 2)).norm(), 0, 1e-12);
}

TEST(View, KeyframesAreMetAndPassedSmoothly) {
    View view;
    view.keyframes = {{0, {0, -4, 1}, {0, 0, 0}}, {1, {4, -4, 1}, {1, 0, 0}}, {3, {4, 4, 2}, {1, 0, 1}}, {4, {0, 4, 1}, {0, 0, 0}}};
    for (const CameraKey& key : view.keyframes) {
        EXPECT_NEAR((at_time(view, key.time).eye - key.eye).norm(), 0, 1e-12);
        EXPECT_NEAR((at_time(view, key.time).target - key.target).norm(), 0, 1e-12);
    }
    EXPECT_EQ(at_time(view, -5).eye, view.keyframes.front().eye);
    EXPECT_EQ(at_time(view, 99).eye, view.keyframes.back().eye);
    constexpr double h = 1e-4;
    for (const double t : {1.0, 3.0}) {  // the velocity does not jump at a key
        const Vec3 before = (at_time(view, t).eye - at_time(view, t - h).eye) / h;
        const Vec3 after = (at_time(view, t + h).eye - at_time(view, t).eye) / h;
        EXPECT_NEAR((before - after).norm(), 0, 0.01) << t;
        EXPECT_GT(before.norm(), 0.5);
    }
    for (double t = 0; t <= 4; t += 0.01) EXPECT_NO_THROW(validate(at_time(view, t)));
    view.keyframes.clear();
    EXPECT_EQ(at_time(view, 2).eye, view.eye);
}

TEST(View, JsonGivesTheSameViewAgain) {
    ViewSpec view;
    EXPECT_EQ(parse_view(view_json(view), "x"), view);
    view.fitted = false, view.eye = {1.5, -2, 3}, view.target = {0.1, 0, 0}, view.field_of_view = 50;
    view.colouring = Colouring::error, view.range = {1, 2.5}, view.surface = false, view.wireframe = true;
    view.arrows = false, view.legend = false, view.cut = CutPlane{{1, 2, 3}, {0, 0, -1}};
    view.background = Background::transparent;
    view.keyframes = {{0, {1, 2, 3}, {0, 0, 0}}, {0.5, {3, 2, 1}, {0, 0, 0}}};
    EXPECT_EQ(parse_view(view_json(view), "x"), view);
    EXPECT_EQ(parse_view(R"({"wireframe": false})", "x", view).colouring, Colouring::error) << "what is absent stays";
    for (const char* text : {R"({"colouring": "rainbow"})", R"({"eye": [1, 2, 3]})", R"({"range": [2, 1]})", R"({"zoom": 2})",
                             R"({"cut": {"point": [0, 0, 0], "normal": [0, 0, 0]}})", "[]", "{",
                             R"({"keyframes": [{"time": 1, "eye": [1, 1, 1], "target": [0, 0, 0]},
                                               {"time": 1, "eye": [1, 1, 1], "target": [0, 0, 0]}]})"})
        EXPECT_THROW(parse_view(text, "x"), InputError) << text;
}

TEST(View, WorksFromStraightAbove) {
    View view;
    view.eye = {0, 0, 5}, view.target = {0, 0, 0}, view.up = 2;
    EXPECT_TRUE(eye_from_world(view).allFinite());
    EXPECT_NEAR(project(view, {0, 0, 0}).head<2>().norm(), 0, 1e-6);
}

TEST(View, SceneDecides) {
    FrameModel model;
    model.rest_box = {0, 0, 0.5F, 4, 1, 1.5F};
    ViewSpec spec;
    spec.fitted = false, spec.eye = {1, 2, 3}, spec.target = {0, 0, 1}, spec.field_of_view = 50;
    spec.colouring = Colouring::stiffness, spec.wireframe = true;
    const View view = make_view(spec, model, 640, 480);
    EXPECT_EQ(view.eye, Vec3(1, 2, 3));
    EXPECT_EQ(view.target, Vec3(0, 0, 1));
    EXPECT_EQ(view.field_of_view, 50);
    EXPECT_EQ(view.colouring, Colouring::stiffness);
    EXPECT_TRUE(view.wireframe);
    EXPECT_EQ(view.floor, 0.5);
}

TEST(View, RefusesWhatCannotBeDrawn) {
    const auto refused = [](const char* what, auto change) {
        View view;
        change(view);
        try {
            validate(view);
            ADD_FAILURE() << what << " was accepted";
        } catch (const InputError& error) {
            EXPECT_EQ(error.where, what);
        }
    };
    refused("width", [](View& v) { v.width = 0; });
    refused("width", [](View& v) { v.width = 100'000; });
    refused("height", [](View& v) { v.height = -5; });
    refused("supersampling", [](View& v) { v.supersampling = 5; });
    refused("field_of_view", [](View& v) { v.field_of_view = std::numeric_limits<double>::quiet_NaN(); });
    refused("eye", [](View& v) { v.eye = v.target; });
    EXPECT_NO_THROW(validate(View{}));
}

}  // namespace
}  // namespace tetfront
