#include "server/net/command_parser.hpp"

#include <random>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace tetfront {
namespace {

template <class Kind>
Kind accepted(const std::string& text) {
    const ParsedCommand parsed = parse_command(text);
    const Command* command = std::get_if<Command>(&parsed.result);
    if (!command) {
        ADD_FAILURE() << text << ": " << std::get<CommandError>(parsed.result).message;
        return {};
    }
    EXPECT_EQ(parsed.id, 7) << text;
    EXPECT_TRUE(std::holds_alternative<Kind>(*command)) << text;
    return std::holds_alternative<Kind>(*command) ? std::get<Kind>(*command) : Kind{};
}

TEST(CommandParser, ReadsEveryCommand) {
    accepted<command::Play>(R"({"id": 7, "command": "play"})");
    accepted<command::Pause>(R"({"command": "pause", "id": 7})");
    accepted<command::Reset>(R"({"id": 7, "command": "reset"})");
    EXPECT_EQ(accepted<command::Step>(R"({"id": 7, "command": "step"})").count, 1);
    EXPECT_EQ(accepted<command::Step>(R"({"id": 7, "command": "step", "count": 1000})").count, 1000);
    EXPECT_EQ(accepted<command::Speed>(R"({"id": 7, "command": "speed", "value": 0.25})").value, 0.25);
    EXPECT_EQ(accepted<command::Tolerance>(R"({"id": 7, "command": "tolerance", "value": 1e-6})").value, 1e-6);
    const auto budget = accepted<command::Budget>(R"({"id": 7, "command": "budget", "tets": 1, "milliseconds": 2.5})");
    EXPECT_EQ(budget.tets, 1);
    EXPECT_EQ(budget.milliseconds, 2.5);
    const auto unlimited = accepted<command::Budget>(R"({"id": 7, "command": "budget"})");
    EXPECT_EQ(unlimited.tets, 1 << 28);
    EXPECT_EQ(unlimited.milliseconds, 0);
    EXPECT_EQ(accepted<command::Gravity>(R"({"id": 7, "command": "gravity", "value": [0, -1.5, 1e4]})").value,
              Vec3(0, -1.5, 1e4));

    const auto begin = accepted<command::PullBegin>(
        R"({"id": 7, "command": "pull_begin", "pull": 2147483647, "triangle": 12, "barycentric": [0.5, 0.25, 0.2505], "target": [1, -2, 3.5]})");
    EXPECT_EQ(begin.pull, 2147483647U);
    EXPECT_EQ(begin.point.triangle, 12U);
    EXPECT_NEAR(begin.point.barycentric.sum(), 1, 1e-15);
    EXPECT_EQ(begin.target, Vec3(1, -2, 3.5));
    const auto move =
        accepted<command::PullMove>(R"({"id": 7, "command": "pull_move", "pull": 3, "target": [0, 0, 1]})");
    EXPECT_EQ(move.pull, 3U);
    EXPECT_EQ(move.target, Vec3(0, 0, 1));
    EXPECT_EQ(accepted<command::PullEnd>(R"({"id": 7, "command": "pull_end", "pull": 0})").pull, 0U);
}

TEST(CommandParser, ReadsEdits) {
    const auto add = accepted<command::ForceAdd>(
        R"({"id": 7, "command": "force_add", "force": 5, "triangle": 1, "barycentric": [0, 0, 1], "value": [0, 0, -9e8]})");
    EXPECT_EQ(add.force, 5U);
    EXPECT_EQ(add.point.triangle, 1U);
    EXPECT_EQ(add.point.barycentric, Vec3(0, 0, 1));
    EXPECT_EQ(add.value, Vec3(0, 0, -9e8));
    EXPECT_FALSE(accepted<command::ForceMove>(R"({"id": 7, "command": "force_move", "force": 5, "value": [1, 2, 3]})").point);
    const auto move = accepted<command::ForceMove>(
        R"({"id": 7, "command": "force_move", "force": 5, "value": [1, 2, 3], "triangle": 2, "barycentric": [1, 0, 0]})");
    EXPECT_EQ(move.point.value().triangle, 2U);
    EXPECT_EQ(move.value, Vec3(1, 2, 3));
    EXPECT_EQ(accepted<command::ForceRemove>(R"({"id": 7, "command": "force_remove", "force": 5})").force, 5U);
    const std::string place = R"(, "triangle": 4, "barycentric": [0.5, 0.5, 0], "radius": 0.25})";
    const auto pin = accepted<command::Pin>(R"({"id": 7, "command": "pin")" + place);
    EXPECT_TRUE(pin.pinned);
    EXPECT_EQ(pin.point.triangle, 4U);
    EXPECT_EQ(pin.radius, 0.25);
    EXPECT_FALSE(accepted<command::Pin>(R"({"id": 7, "command": "unpin")" + place).pinned);
    const auto everywhere = accepted<command::StiffnessScale>(R"({"id": 7, "command": "stiffness_scale", "value": 100})");
    EXPECT_EQ(everywhere.value, 100);
    EXPECT_FALSE(everywhere.part);
    const auto scale = accepted<command::StiffnessScale>(
        R"({"id": 7, "command": "stiffness_scale", "value": 2, "triangle": 3, "barycentric": [0, 0.25, 0.75], "radius": 0.5})");
    ASSERT_TRUE(scale.part);
    EXPECT_EQ(scale.value, 2);
    EXPECT_EQ(scale.part->point, (SurfacePoint{3, {0, 0.25, 0.75}}));
    EXPECT_EQ(scale.part->radius, 0.5);
    // A place that is told to clients, and comes back, is the same to the bit.
    std::mt19937 random(3);
    for (int i = 0; i < 1000; ++i) {
        Vec3 place = Vec3::NullaryExpr([&] { return std::uniform_real_distribution<double>(0, 1)(random); });
        place /= place.sum() * (1 + 1e-4);
        const auto said = [](const Vec3& at) {
            const nlohmann::json command = {{"id", 7}, {"command", "pin"}, {"triangle", 4}, {"radius", 1}, {"barycentric", {at[0], at[1], at[2]}}};
            return accepted<command::Pin>(command.dump()).point.barycentric;
        };
        const Vec3 told = said(place);
        ASSERT_NEAR(told.sum(), 1, 1e-15);
        ASSERT_EQ(said(told), told);
    }
    const auto damping = accepted<command::Damping>(R"({"id": 7, "command": "damping", "mass": 2, "stiffness": 0.5})");
    EXPECT_EQ(damping.mass, 2);
    EXPECT_EQ(damping.stiffness, 0.5);
    EXPECT_EQ(accepted<command::Order>(R"({"id": 7, "command": "order", "value": 1})").value, 1);
    const auto levels = accepted<command::Levels>(R"({"id": 7, "command": "levels", "min": 1, "max": 3})");
    EXPECT_EQ(levels.min, 1);
    EXPECT_EQ(levels.max, 3);
}

TEST(CommandParser, ReadsWhatConcernsTheServer) {
    EXPECT_EQ(accepted<command::Load>(R"({"id": 7, "command": "load", "scene": "bunny-2.x_"})").scene, "bunny-2.x_");
    EXPECT_EQ(accepted<command::Save>(R"({"id": 7, "command": "save", "name": "a"})").name, "a");
    EXPECT_EQ(accepted<command::Restore>(R"({"id": 7, "command": "restore", "name": "a"})").name, "a");
    const auto plain = accepted<command::RecordStart>(R"({"id": 7, "command": "record_start"})");
    EXPECT_EQ(plain.name, "");
    EXPECT_EQ(plain.fps, 30);
    EXPECT_EQ(plain.field, Field::none);
    const auto record = accepted<command::RecordStart>(
        R"({"id": 7, "command": "record_start", "name": "run", "fps": 60, "colouring": "stress"})");
    EXPECT_EQ(record.name, "run");
    EXPECT_EQ(record.fps, 60);
    EXPECT_EQ(record.field, Field::stress);
    accepted<command::RecordStop>(R"({"id": 7, "command": "record_stop"})");
    EXPECT_EQ(accepted<command::Colouring>(R"({"id": 7, "command": "colouring", "value": "strain"})").field, Field::strain);
    EXPECT_EQ(accepted<command::Colouring>(R"({"id": 7, "command": "colouring", "value": "level"})").field, Field::none);
    EXPECT_TRUE(accepted<command::Compression>(R"({"id": 7, "command": "compression", "value": true})").on);
    EXPECT_EQ(accepted<command::Token>(R"({"id": 7, "command": "token", "value": "secret/?"})").value, "secret/?");
    accepted<command::Scenes>(R"({"id": 7, "command": "scenes"})");
    accepted<command::States>(R"({"id": 7, "command": "states"})");
    accepted<command::Recordings>(R"({"id": 7, "command": "recordings"})");
    const ParsedCommand ack = parse_command(R"({"command": "ack", "frame": 4294967295})");
    EXPECT_FALSE(ack.id);
    EXPECT_EQ(std::get<command::Acknowledge>(std::get<Command>(ack.result)).frame, 0xFFFFFFFFU);
}

struct Refusal {
    std::string text, code, pointer;
    bool id_readable = true;
};
void PrintTo(const Refusal& refusal, std::ostream* out) { *out << refusal.code << ' ' << refusal.pointer; }

class CommandParserRefuses : public testing::TestWithParam<Refusal> {};

TEST_P(CommandParserRefuses, WithCodeAndPointer) {
    const Refusal& expected = GetParam();
    const ParsedCommand parsed = parse_command(expected.text);
    const CommandError* error = std::get_if<CommandError>(&parsed.result);
    ASSERT_NE(error, nullptr) << expected.text.substr(0, 200);
    EXPECT_EQ(error->code, expected.code) << error->message;
    EXPECT_EQ(error->pointer, expected.pointer) << error->message;
    EXPECT_EQ(parsed.id.has_value(), expected.id_readable);
    EXPECT_FALSE(error->message.empty());
    EXPECT_EQ(error->message.find('\n'), std::string::npos);
    EXPECT_LT(error->message.size(), 500U);
}

std::string nested(const std::string& open, const std::string& close, int levels) {
    std::string text;
    for (int i = 0; i < levels; ++i) text += open;
    for (int i = 0; i < levels; ++i) text += close;
    return text;
}

std::string pull(const std::string& triangle, const std::string& barycentric, const std::string& target) {
    return R"({"id":7,"command":"pull_begin","pull":1,"triangle":)" + triangle + R"(,"barycentric":)" + barycentric +
           R"(,"target":)" + target + "}";
}

const std::string third = "[0.5,0.25,0.25]", origin = "[0,0,0]";

INSTANTIATE_TEST_SUITE_P(
    Malformed, CommandParserRefuses,
    testing::Values(Refusal{"", "malformed", "", false}, Refusal{"{", "malformed", "", false},
                    Refusal{"null", "malformed", "", false}, Refusal{"[]", "malformed", "", false},
                    Refusal{"7", "malformed", "", false}, Refusal{R"("play")", "malformed", "", false},
                    Refusal{R"({"id": 7, "command": "play"} x)", "malformed", "", false},
                    Refusal{R"({"id": 7, "command": "play",})", "malformed", "", false},
                    Refusal{R"({'id': 7})", "malformed", "", false}, Refusal{"\xff\xfe", "malformed", "", false},
                    Refusal{"{\"id\": 7, \"command\": \"\xc3\x28\"}", "malformed", "", false},
                    Refusal{std::string("{\"id\": 7\0}", 10), "malformed", "", false},
                    Refusal{R"({"id": 7, "id": 8, "command": "play"})", "malformed", "/id", false},
                    Refusal{R"({"id": 7, "command": "speed", "value": NaN})", "malformed", "", false},
                    Refusal{R"({"id": 7, "command": "speed", "value": Infinity})", "malformed", "", false},
                    Refusal{nested("[", "]", 10'000), "malformed", "", false},
                    Refusal{nested("[", "", 1'000'000), "malformed", "", false},
                    Refusal{R"({"id":)" + nested(R"({"a":)", "}", 10'000) + "}", "malformed", "", false},
                    Refusal{R"({"id": 7, "command": "play", "deep": )" + nested("[", "]", 8) + "}", "malformed", "",
                            false}));

INSTANTIATE_TEST_SUITE_P(
    Keys, CommandParserRefuses,
    testing::Values(Refusal{"{}", "missing_key", "/id", false},
                    Refusal{R"({"command": "play"})", "missing_key", "/id", false},
                    Refusal{R"({"id": 7})", "missing_key", "/command"},
                    Refusal{R"({"id": 7, "command": 1})", "wrong_type", "/command"},
                    Refusal{R"({"id": 7, "command": "Play"})", "unknown_command", "/command"},
                    Refusal{R"({"id": 7, "command": ""})", "unknown_command", "/command"},
                    Refusal{R"({"id": 7, "command": "play", "value": 1})", "unknown_key", "/value"},
                    Refusal{R"({"id": 7, "command": "play", "a/b~c": 1})", "unknown_key", "/a~1b~0c"},
                    Refusal{R"({"id": 7, "command": "speed"})", "missing_key", "/value"},
                    Refusal{R"({"id": 7, "command": "pull_end"})", "missing_key", "/pull"},
                    Refusal{R"({"id": 7, "command": "play", ")" + std::string(60'000, 'k') + R"(": 1})", "unknown_key",
                            "/" + std::string(64, 'k')}));

INSTANTIATE_TEST_SUITE_P(
    Edits, CommandParserRefuses,
    testing::Values(
        Refusal{R"({"id": 7, "command": "load", "scene": "../secret"})", "out_of_range", "/scene"},
        Refusal{R"({"id": 7, "command": "load", "scene": "a/b"})", "out_of_range", "/scene"},
        Refusal{R"({"id": 7, "command": "load", "scene": "a\u0000b"})", "out_of_range", "/scene"},
        Refusal{R"({"id": 7, "command": "load", "scene": ".."})", "out_of_range", "/scene"},
        Refusal{R"({"id": 7, "command": "load", "scene": "%2e%2e"})", "out_of_range", "/scene"},
        Refusal{R"({"id": 7, "command": "load", "scene": "a\\b"})", "out_of_range", "/scene"},
        Refusal{R"({"id": 7, "command": "load", "scene": ""})", "out_of_range", "/scene"},
        Refusal{R"({"id": 7, "command": "load", "scene": 7})", "wrong_type", "/scene"},
        Refusal{R"({"id": 7, "command": "save", "name": ".hidden"})", "out_of_range", "/name"},
        Refusal{R"({"id": 7, "command": "save", "name": ")" + std::string(65, 'a') + "\"}", "out_of_range", "/name"},
        Refusal{R"({"id": 7, "command": "record_start", "name": "/etc/passwd"})", "out_of_range", "/name"},
        Refusal{R"({"id": 7, "command": "record_start", "fps": 0.5})", "out_of_range", "/fps"},
        Refusal{R"({"id": 7, "command": "record_start", "colouring": "red"})", "out_of_range", "/colouring"},
        Refusal{R"({"id": 7, "command": "colouring", "value": 3})", "wrong_type", "/value"},
        Refusal{R"({"id": 7, "command": "compression", "value": 1})", "wrong_type", "/value"},
        Refusal{R"({"id": 7, "command": "order", "value": 3})", "out_of_range", "/value"},
        Refusal{R"({"id": 7, "command": "order", "value": 1.5})", "wrong_type", "/value"},
        Refusal{R"({"id": 7, "command": "levels", "min": 1})", "missing_key", "/max"},
        Refusal{R"({"id": 7, "command": "levels", "min": -1, "max": 1})", "out_of_range", "/min"},
        Refusal{R"({"id": 7, "command": "levels", "min": 2, "max": 1})", "out_of_range", "/max"},
        Refusal{R"({"id": 7, "command": "levels", "min": 0, "max": 1000000000})", "out_of_range", "/max"},
        Refusal{R"({"id": 7, "command": "levels", "min": 0, "max": 0.5})", "wrong_type", "/max"},
        Refusal{R"({"id": 7, "command": "stiffness_scale", "value": 0})", "out_of_range", "/value"},
        Refusal{R"({"id": 7, "command": "stiffness_scale", "value": 1e308})", "out_of_range", "/value"},
        Refusal{R"({"id": 7, "command": "stiffness_scale", "value": 1, "radius": 1})", "missing_key", "/triangle"},
        Refusal{R"({"id": 7, "command": "stiffness_scale", "value": 1, "triangle": 0, "barycentric": [1, 0, 0]})", "missing_key", "/radius"},
        Refusal{R"({"id": 7, "command": "damping", "mass": 1})", "missing_key", "/stiffness"},
        Refusal{R"({"id": 7, "command": "damping", "mass": -1, "stiffness": 0})", "out_of_range", "/mass"},
        Refusal{R"({"id": 7, "command": "damping", "mass": 0, "stiffness": 1e308})", "out_of_range", "/stiffness"},
        Refusal{R"({"id": 7, "command": "force_add", "force": 0, "triangle": 0, "barycentric": [1,0,0], "value": [1e308,0,0]})",
                "out_of_range", "/value/0"},
        Refusal{R"({"id": 7, "command": "force_move", "force": 0, "triangle": 0, "value": [1,0,0]})", "missing_key", "/barycentric"},
        Refusal{R"({"id": 7, "command": "force_remove", "force": 2147483648})", "out_of_range", "/force"},
        Refusal{R"({"id": 7, "command": "pin", "triangle": 0, "barycentric": [1,0,0], "radius": -1})", "out_of_range", "/radius"},
        Refusal{R"({"id": 7, "command": "unpin", "triangle": 0, "barycentric": [1,0,0], "radius": 1e308})", "out_of_range",
                "/radius"},
        Refusal{R"({"id": 7, "command": "token", "value": ")" + std::string(1025, 'a') + "\"}", "out_of_range", "/value"},
        Refusal{R"({"command": "ack"})", "missing_key", "/frame", false},
        Refusal{R"({"command": "ack", "frame": -1})", "out_of_range", "/frame", false},
        Refusal{R"({"command": "ack", "frame": 1, "x": 1})", "unknown_key", "/x", false},
        Refusal{R"({"id": 7, "command": "ack", "frame": 1})", "unknown_command", "/command"}));

INSTANTIATE_TEST_SUITE_P(
    Numbers, CommandParserRefuses,
    testing::Values(Refusal{R"({"id": -1, "command": "play"})", "out_of_range", "/id", false},
                    Refusal{R"({"id": 9007199254740992, "command": "play"})", "out_of_range", "/id", false},
                    Refusal{R"({"id": 18446744073709551615, "command": "play"})", "out_of_range", "/id", false},
                    Refusal{R"({"id": 1.5, "command": "play"})", "wrong_type", "/id", false},
                    Refusal{R"({"id": "7", "command": "play"})", "wrong_type", "/id", false},
                    Refusal{R"({"id": null, "command": "play"})", "wrong_type", "/id", false},
                    Refusal{R"({"id": 7, "command": "step", "count": 0})", "out_of_range", "/count"},
                    Refusal{R"({"id": 7, "command": "step", "count": 1001})", "out_of_range", "/count"},
                    Refusal{R"({"id": 7, "command": "step", "count": 1e2})", "wrong_type", "/count"},
                    Refusal{R"({"id": 7, "command": "step", "count": true})", "wrong_type", "/count"},
                    Refusal{R"({"id": 7, "command": "speed", "value": 0})", "out_of_range", "/value"},
                    Refusal{R"({"id": 7, "command": "speed", "value": 1e308})", "out_of_range", "/value"},
                    Refusal{R"({"id": 7, "command": "speed", "value": 1e309})", "out_of_range", "", false},
                    Refusal{R"({"id": 7, "command": "speed", "value": -1e-320})", "out_of_range", "/value"},
                    Refusal{R"({"id": 7, "command": "speed", "value": null})", "wrong_type", "/value"},
                    Refusal{R"({"id": 7, "command": "tolerance", "value": 1.001})", "out_of_range", "/value"},
                    Refusal{R"({"id": 7, "command": "budget", "tets": 0})", "out_of_range", "/tets"},
                    Refusal{R"({"id": 7, "command": "budget", "tets": 268435457})", "out_of_range", "/tets"},
                    Refusal{R"({"id": 7, "command": "budget", "tets": 1e3})", "wrong_type", "/tets"},
                    Refusal{R"({"id": 7, "command": "budget", "milliseconds": -1})", "out_of_range", "/milliseconds"},
                    Refusal{R"({"id": 7, "command": "budget", "value": 5})", "unknown_key", "/value"},
                    Refusal{R"({"id": 7, "command": "gravity", "value": [0, 1e308, 0]})", "out_of_range", "/value/1"},
                    Refusal{R"({"id": 7, "command": "gravity", "value": [0, 0]})", "wrong_type", "/value"},
                    Refusal{R"({"id": 7, "command": "gravity", "value": [0, 0, "x"]})", "wrong_type", "/value/2"},
                    Refusal{R"({"id": 7, "command": "gravity", "value": {"x": 0}})", "wrong_type", "/value"},
                    Refusal{R"({"id": 7, "command": "pull_end", "pull": 2147483648})", "out_of_range", "/pull"},
                    Refusal{R"({"id": 7, "command": "pull_move", "pull": -1, "target": [0, 0, 0]})", "out_of_range",
                            "/pull"},
                    Refusal{pull("4294967296", third, origin), "out_of_range", "/triangle"},
                    Refusal{pull("-1", third, origin), "out_of_range", "/triangle"},
                    Refusal{pull("0", "[0.5,0.25,0.252]", origin), "out_of_range", "/barycentric"},
                    Refusal{pull("0", "[-0.1,0.55,0.55]", origin), "out_of_range", "/barycentric/0"},
                    Refusal{pull("0", "[0,0,0]", origin), "out_of_range", "/barycentric"},
                    Refusal{pull("0", third, "[0,0,1e308]"), "out_of_range", "/target/2"},
                    Refusal{pull("0", third, "[0,0,1000001]"), "out_of_range", "/target/2"},
                    Refusal{pull("0", third, "[0,0,0,0]"), "wrong_type", "/target"}));

}  // namespace
}  // namespace tetfront
