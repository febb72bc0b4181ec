#include "server/net/command_parser.hpp"
#include "server/net/compressed_frame.hpp"
#include "server/net/protocol.hpp"

#include "tests/support/golden.hpp"
#include "tests/support/project.hpp"
#include "tests/support/sample_frame.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>
#include <numbers>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include <gtest/gtest.h>
#include <meshoptimizer.h>
#include <nlohmann/json.hpp>

namespace tetfront {
namespace {

template <class T>
T at(const std::string& bytes, std::size_t offset) {
    T value;
    std::memcpy(&value, bytes.data() + offset, sizeof value);
    return value;
}

Scene sample_scene() {
    Scene scene;
    scene.name = "sample";
    scene.title = "A sample \"scene\"";
    scene.view.eye = {3, -6, 2};
    scene.view.target = {0.5, 1, 2};
    scene.view.fitted = false;
    scene.time_step = 1.0 / 64;
    scene.front.order = 2;
    scene.gravity = {0, 0, -9.75};
    scene.front.tolerance = 0.02;
    return scene;
}

SessionState sample_state() {
    return {.playing = true,
            .speed = 0.5,
            .steps_per_second = 59.5,
            .status = sample_frame()->status,
            .tets_by_level = sample_frame()->topology->tets_by_level,
            .scene_forces = {{{1, 0.5, 2}, {0, 0, -25}}},
            .gravity = {0, 0, -9.75},
            .order = 2,
            .levels = {0, 1},
            .edits = {.stiffness_scale = 2,
                      .stiffness = {{{0, {0.25, 0.25, 0.5}}, 0.5, 10}},
                      .mass_damping = 0.5,
                      .stiffness_damping = 0.25,
                      .pins = {{true, {1, {0.5, 0.25, 0.25}}, 0.125}, {false, {0, {1, 0, 0}}, 2}},
                      .forces = {{7, {{1, {0, 0.5, 0.5}}, {0, 0, -5}}}}},
            .budget = {.tets = 5000, .milliseconds = 0},
            .recording = {},
            .steps = 75};
}

std::shared_ptr<Frame> coloured_frame() {
    auto frame = sample_frame();
    frame->field = Field::stress;
    frame->field_values = {0, 1000, 2000, 4000, 3000};
    return frame;
}

std::string hello_of(const SessionModel& model, const SessionState& state) {
    return hello_event(model, state, 1, {.recording_bytes = 1 << 30}, {"acknowledge", "colouring", "edit"});
}

TEST(Protocol, ValuesOfAColouredFrameRoundTrip) {
    const auto frame = coloured_frame();
    const std::string plain = encode_frame(*sample_frame(), 1, 42), bytes = encode_frame(*frame, 1, 42);
    EXPECT_EQ(at<std::uint8_t>(bytes, 0), 4);
    EXPECT_EQ(bytes.substr(1, plain.size() - 1), plain.substr(1)) << "begins as the frame without values does";
    EXPECT_EQ(at<std::uint32_t>(bytes, plain.size()), 3U);
    EXPECT_EQ(at<float>(bytes, plain.size() + 4), 4000);
    EXPECT_EQ(at<float>(bytes, plain.size() + 8), field_high(frame->field_values));
    for (std::size_t i = 0; i < 5; ++i)
        EXPECT_NEAR(4000.0 * at<std::uint16_t>(bytes, plain.size() + 12 + 2 * i) / 65535, frame->field_values[i], 0.04);
    EXPECT_EQ(bytes.size(), plain.size() + 12 + 12);
    frame->field_values = {NAN, 0, -1, INFINITY, 0};
    EXPECT_EQ(at<float>(encode_frame(*frame, 1, 42), plain.size() + 4), 0);
}

TEST(Protocol, BytesAreGolden) {
    const auto frame = sample_frame();
    expect_golden("model_v1.bin", encode_model(*frame->model, 1));
    expect_golden("topology_v1.bin", encode_topology(*frame->topology, frame->front_positions.size(), 1));
    expect_golden("frame_v1.bin", encode_frame(*frame, 1, 42));
    auto hello = nlohmann::ordered_json::parse(hello_of({.scene = sample_scene(), .frame_model = frame->model, .floor = {}, .recorded = {}}, sample_state()));
    hello["version"] = "1.2.3";  // not a release's
    expect_golden("hello_v1.json", hello.dump());
    expect_golden("state_v1.json", state_event(sample_state(), 2));
    expect_golden("settings_v1.json", settings_event(sample_state()));
    expect_golden("coloured_frame_v1.bin", encode_frame(*coloured_frame(), 1, 42));
    expect_golden("compressed_frame_v1.bin", compress_frame(encode_frame(*frame, 1, 42)));
    expect_golden("compressed_coloured_frame_v1.bin", compress_frame(encode_frame(*coloured_frame(), 1, 42)));
}

/// The keys and types of a JSON value at all depths; of a list, of its first item.
std::string outline(const nlohmann::json& value) {
    if (value.is_number()) return "number";
    if (value.is_array()) return "[" + (value.empty() ? "" : outline(value[0])) + "]";
    if (!value.is_object()) return value.type_name();
    std::string text = "{";
    for (const auto& [key, member] : value.items()) text += key + ":" + outline(member) + " ";
    return text + "}";
}

TEST(Protocol, ExamplesAreTrue) {
    const auto frame = sample_frame();
    const Library::FileEntry file{"run.tfr", 1, {}};
    std::map<std::string, std::vector<std::string>> wanted;
    for (const std::string& message :
         {hello_of({.scene = sample_scene(), .frame_model = frame->model, .floor = {}, .recorded = {}}, sample_state()), state_event(sample_state(), 2),
          settings_event(sample_state()), recording_event({}), link_event({.sent = 1, .dropped = 1, .in_flight = 1, .round_trip = 0.1}), log_event("info", ""),
          progress_event("", 0.5, 1.0), ok_reply(7), scenes_reply(7, {{"a", "b"}}), recordings_reply(7, {file}, true),
          error_reply(7, CommandError{"a", "b", "c"})}) {
        const auto json = nlohmann::json::parse(message);
        wanted[json["type"]].push_back(outline(json));
    }
    std::ifstream in(source_folder() / "server/PROTOCOL.md");
    std::set<std::string> types, commands;
    for (std::string line; std::getline(in, line);) {
        if (!line.starts_with("{\"")) continue;
        const auto json = nlohmann::json::parse(line);
        if (json.contains("command")) {
            const ParsedCommand parsed = parse_command(line);
            EXPECT_TRUE(std::holds_alternative<Command>(parsed.result)) << line;
            commands.insert(json["command"]);
        } else if (!json.contains("states")) {  // that list is read from files
            EXPECT_TRUE(std::ranges::find(wanted[json["type"]], outline(json)) != wanted[json["type"]].end()) << line << '\n' << outline(json);
            types.insert(json["type"]);
        }
    }
    EXPECT_EQ(types.size(), wanted.size());
    EXPECT_EQ(commands.size(), std::variant_size_v<Command> + 1) << "pin and unpin are one for the parser";
}

TEST(Protocol, HeaderIsAsDocumented) {
    const auto frame = sample_frame();
    const std::string bytes = encode_frame(*frame, 0x1234, 0x89ABCDEF);
    EXPECT_EQ(bytes.size(), 32U + 24 + 32 + 20 + 28);
    EXPECT_EQ(at<std::uint8_t>(bytes, 0), 3);
    EXPECT_EQ(at<std::uint8_t>(bytes, 1), 1);
    EXPECT_EQ(at<std::uint16_t>(bytes, 2), 0x1234);
    EXPECT_EQ(at<std::uint32_t>(bytes, 4), 7U);
    EXPECT_EQ(at<std::uint32_t>(bytes, 8), 0x89ABCDEFU);
    EXPECT_EQ(at<std::uint32_t>(bytes, 12), 5U);
    EXPECT_EQ(at<double>(bytes, 16), 1.25);
    EXPECT_EQ(at<std::uint32_t>(bytes, 24), 3U);
    EXPECT_EQ(at<std::uint32_t>(bytes, 28), 1U);
    EXPECT_EQ(static_cast<unsigned char>(bytes[12]), 5) << "little-endian";

    EXPECT_EQ(encode_model(*frame->model, 1).size(), 32U + 24 + 20);
    EXPECT_EQ(encode_topology(*frame->topology, 3, 1).size(), 32U + 24 + 8 + 4 + 4 + 32 + 4);
}

TEST(Protocol, CompressedFramesUnpackToThePlainOnes) {
    auto frame = coloured_frame();
    for (const std::size_t count : {0U, 1U, 5U, 257U, 5000U}) {
        frame->surface.clear(), frame->field_values.clear();
        for (std::size_t i = 0; i < count; ++i) {
            const auto x = 0.01F * static_cast<float>(i);
            frame->surface.push_back({x, std::sin(x), std::cos(3 * x)});
            frame->field_values.push_back(x);
        }
        const std::string plain = encode_frame(*frame, 1, 1), bytes = compress_frame(plain);
        const std::size_t front = frame->front_positions.size(), values = 32 + 24 + 28;
        EXPECT_EQ(bytes.size() % 4, 0U);
        EXPECT_EQ(bytes.substr(1, 55), plain.substr(1, 55)) << "header and box";
        EXPECT_EQ(at<std::uint32_t>(bytes, values), count == 0 ? 0U : 3U);
        const auto surface_bytes = at<std::uint32_t>(bytes, values + 12), front_bytes = at<std::uint32_t>(bytes, values + 16);
        const auto* stream = reinterpret_cast<const unsigned char*>(bytes.data()) + values + 20;
        std::vector<std::array<std::uint16_t, 4>> unpacked(std::max(count, front));
        if (count > 0) {
            ASSERT_EQ(meshopt_decodeVertexBuffer(unpacked.data(), count, 8, stream, surface_bytes), 0);
            for (std::size_t i = 0; i < count; ++i) {
                EXPECT_EQ(std::memcmp(unpacked[i].data(), plain.data() + 56 + 6 * i, 6), 0) << i;
                EXPECT_EQ(unpacked[i][3], at<std::uint16_t>(plain, plain.size() - (2 * count + 3) / 4 * 4 + 2 * i)) << i;
            }
        }
        ASSERT_EQ(meshopt_decodeVertexBuffer(unpacked.data(), front, 8, stream + (surface_bytes + 3) / 4 * 4, front_bytes), 0);
        for (std::size_t i = 0; i < front; ++i)
            EXPECT_EQ(std::memcmp(unpacked[i].data(), plain.data() + 56 + (6 * count + 3) / 4 * 4 + 6 * i, 6), 0) << i;
        if (count == 5000) EXPECT_LT(bytes.size(), 0.8 * static_cast<double>(plain.size()));
    }
}

TEST(Protocol, PositionsRoundTripWithinHalfAStep) {
    auto frame = sample_frame();
    frame->surface.clear();
    for (int i = 0; i < 1000; ++i) {
        const float x = static_cast<float>(i);
        frame->surface.push_back({std::sin(x), 100 * std::cos(7 * x), 1e-3F * std::sin(3 * x)});
    }
    const std::string bytes = encode_frame(*frame, 1, 1);
    for (std::size_t i = 0; i < frame->surface.size(); ++i)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double low = at<float>(bytes, 32 + 4 * axis), extent = at<float>(bytes, 44 + 4 * axis);
            const double decoded = low + extent * at<std::uint16_t>(bytes, 56 + 6 * i + 2 * axis) / 65535;
            EXPECT_NEAR(decoded, static_cast<double>(frame->surface[i][axis]), extent * (0.5 / 65535 + 1e-6));
        }
}

TEST(Protocol, PositionsThatAreNotFiniteOrHugeDoNoHarm) {
    auto frame = sample_frame();
    constexpr float infinity = std::numeric_limits<float>::infinity(), huge = std::numeric_limits<float>::max();
    frame->surface[0] = {std::nanf(""), infinity, -infinity};
    frame->front_positions[0] = {-huge, huge, 5};
    const std::string bytes = encode_frame(*frame, 1, 1);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        EXPECT_TRUE(std::isfinite(at<float>(bytes, 32 + 4 * axis)));
        EXPECT_TRUE(std::isfinite(at<float>(bytes, 44 + 4 * axis)));
    }
    EXPECT_EQ(at<std::uint16_t>(bytes, 56), 0);

    frame->surface.clear();
    frame->front_positions.clear();
    EXPECT_EQ(encode_frame(*frame, 1, 1).size(), 32U + 24 + 28);
}

TEST(Protocol, HelloHasACameraThatSeesTheWholeBox) {
    Scene scene = sample_scene();
    scene.view.fitted = true;
    for (const int up : {0, 1, 2}) {
        FrameModel model = *sample_frame()->model;
        model.up = up;
        const auto view = nlohmann::json::parse(hello_of({.scene = scene, .frame_model = std::make_shared<FrameModel>(model), .floor = {}, .recorded = {}}, sample_state()))["view"];
        Vec3 eye, target;
        for (int i = 0; i < 3; ++i) eye[i] = view["eye"][i], target[i] = view["target"][i];
        EXPECT_EQ(target, Vec3(0.5, 1, 2));
        EXPECT_GT(eye[up], target[up]) << "from above";
        for (int corner = 0; corner < 8; ++corner) {
            const Vec3 c(corner & 1 ? 1 : 0, corner & 2 ? 2 : 0, corner & 4 ? 4 : 0);
            const double cosine = (c - eye).normalized().dot((target - eye).normalized());
            EXPECT_GT(cosine, std::cos(scene.view.field_of_view / 2 * std::numbers::pi / 180));
        }
    }
}

TEST(Protocol, EventsAreValidJsonWhateverTheTexts) {
    Scene scene = sample_scene();
    scene.title = "\xff\xfe \" \\ \n";
    SessionState state = sample_state();
    state.status.estimate = std::numeric_limits<double>::quiet_NaN();
    state.status.warning = "\xc3";
    const auto hello = nlohmann::json::parse(hello_of({.scene = scene, .frame_model = sample_frame()->model, .floor = {}, .recorded = {}}, state));
    EXPECT_EQ(hello["type"], "hello");
    EXPECT_EQ(hello["protocol"], 1);
    EXPECT_EQ(hello["limits"]["message_bytes"], 65536);
    EXPECT_TRUE(nlohmann::json::parse(state_event(state, 1))["estimate"].is_null());
    EXPECT_EQ(nlohmann::json::parse(progress_event("mesh", 7, std::nullopt)),
              nlohmann::json({{"type", "progress"}, {"what", "mesh"}, {"fraction", 1.0}, {"remaining", nullptr}}));
    EXPECT_EQ(nlohmann::json::parse(progress_event("mesh", 0.5, 2.5))["remaining"], 2.5);
    EXPECT_EQ(nlohmann::json::parse(ok_reply(9007199254740991)),
              nlohmann::json({{"type", "ok"}, {"id", 9007199254740991}}));
    const auto error = nlohmann::json::parse(error_reply(std::nullopt, {"malformed", "/a~1b", "is\xff"}));
    EXPECT_TRUE(error["id"].is_null());
    EXPECT_EQ(error["pointer"], "/a~1b");
}

}  // namespace
}  // namespace tetfront
