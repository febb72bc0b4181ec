#include "server/net/command_parser.hpp"

#include <string>

#include <gtest/gtest.h>

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
    EXPECT_LT(error->message.size(), 400U);
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
