// What the server keeps for its clients: recordings and saved states, their lists, and what happens when there is no room.

#include "server/session/recording.hpp"
#include "tests/server/net/commands_fixture.hpp"

#include <set>

namespace tetfront {
namespace {

TEST_F(CommandsTest, FilesAreBounded) {
    start(false, {}, box_scene(), {.library = Library(scenes_.path(), data_.path()), .files = 1});
    Client client(connect(), host());
    client.until(is_frame);
    for (const auto& [start, end] : {std::pair("record_start", "record_stop"), std::pair("save", "states")}) {
        EXPECT_EQ(client.command({{"id", 1}, {"command", start}, {"name", "one"}})["type"], "ok");
        EXPECT_EQ(client.command({{"id", 2}, {"command", end}})["type"], "ok");
        const Json refusal = client.command({{"id", 3}, {"command", start}, {"name", "two"}});
        EXPECT_EQ(refusal["code"], "too_many") << refusal;
    }
    EXPECT_EQ(Library({}, data_.path()).recordings().size(), 1U);
    EXPECT_EQ(Library({}, data_.path()).states().size(), 1U);
}

TEST_F(CommandsTest, ARecordingKeepsWhatWasDoneMeanwhile) {
    start_with_library();
    Client client(connect(), host());
    client.until(is_frame);
    int id = 0;
    const auto done = [&](Json command) {
        command["id"] = ++id;
        EXPECT_EQ(client.command(command)["type"], "ok") << command;
    };
    done({{"command", "gravity"}, {"value", {0, 0, -1}}});  // before it
    done({{"command", "record_start"}, {"name", "run"}, {"fps", 60}});
    std::vector<Json> commands = {{{"command", "gravity"}, {"value", {0.0, 0.0, -2.0}}},
                                  {{"command", "tolerance"}, {"value", 0.5}},
                                  {{"command", "budget"}, {"tets", 1000}, {"milliseconds", 5.0}},
                                  place({{"command", "force_add"}, {"force", 7}, {"value", {0.0, 0.0, 5.0}}}),
                                  {{"command", "force_move"}, {"force", 7}, {"value", {0.0, 0.0, 9.0}}},
                                  {{"command", "force_remove"}, {"force", 7}},
                                  place({{"command", "pin"}, {"radius", 0.5}}),
                                  place({{"command", "unpin"}, {"radius", 0.25}}),
                                  {{"command", "stiffness_scale"}, {"value", 2.0}},
                                  place({{"command", "stiffness_scale"}, {"value", 5.0}, {"radius", 0.5}}),
                                  {{"command", "damping"}, {"mass", 1.0}, {"stiffness", 0.5}},
                                  {{"command", "order"}, {"value", 1}},
                                  {{"command", "levels"}, {"min", 0}, {"max", 1}},
                                  place({{"command", "pull_begin"}, {"pull", 3}, {"target", {1.0, 0.0, 2.0}}}),
                                  {{"command", "pull_move"}, {"pull", 3}, {"target", {1.0, 0.0, 3.0}}}};
    for (const Json& command : commands) done(command);
    done({{"command", "speed"}, {"value", 2}});  // changes nothing that is simulated
    EXPECT_EQ(client.command({{"id", 99}, {"command", "gravity"}, {"value", {0, 0, 1e9}}})["type"], "error");
    done({{"command", "step"}, {"count", 3}});
    client.until([](const Message& m) { return m.text && m.json["type"] == "state" && m.json["step"] == 3; });
    {
        Client other(connect(), host());  // pulls, and leaves
        other.until(is_frame);
        other.command(place({{"id", 1}, {"command", "pull_begin"}, {"pull", 3}, {"target", {0.0, 0.0, 0.0}}}));
        client.until([](const Message& m) { return is_frame(m) && m.at<std::uint32_t>(28) == 2; });
    }
    client.until([](const Message& m) { return is_frame(m) && m.at<std::uint32_t>(28) == 1; });
    done({{"command", "record_stop"}});

    const Recording recording(data_.path() / "recordings" / "run.tfr");
    ASSERT_EQ(recording.events().size(), commands.size() + 2);
    for (std::size_t i = 0; i < commands.size(); ++i) {
        Json event = Json::parse(recording.events()[i].json);
        if (event.contains("pull")) EXPECT_EQ(event["client"], 1);
        event.erase("client");
        EXPECT_EQ(recording.events()[i].time, 0);
        EXPECT_EQ(event, commands[i]);
    }
    const RecordedEvent& begin = recording.events()[commands.size()];
    EXPECT_EQ(Json::parse(begin.json)["client"], 2) << "the same number of another client";
    EXPECT_NEAR(begin.time, 3.0 / 60, 1e-12);
    EXPECT_EQ(Json::parse(recording.events().back().json), Json({{"command", "pull_end"}, {"client", 2}, {"pull", 3}}));
}

TEST_F(CommandsTest, RecordsAndOffersTheFile) {
    start_with_library();
    Client client(connect(), host());
    client.until(is_frame);
    client.send(Json({{"id", 1}, {"command", "record_start"}, {"name", "run"}, {"fps", 60}, {"colouring", "strain"}}).dump());
    for (bool answered = false, active = false; !(answered && active);) {  // in either order
        const Message m = client.read();
        if (!m.text) continue;
        if (m.json["type"] == "recording") active = m.json["active"];
        if (!m.json.contains("id")) continue;
        ASSERT_EQ(m.json["type"], "ok");
        answered = true;
    }
    EXPECT_EQ(client.command({{"id", 2}, {"command", "record_start"}})["code"], "failed") << "one at a time";
    EXPECT_EQ(client.command({{"id", 3}, {"command", "step"}, {"count", 9}})["type"], "ok");
    client.until([](const Message& m) { return m.text && m.json["type"] == "state" && m.json["step"] == 9; });
    EXPECT_EQ(client.command({{"id", 4}, {"command", "record_stop"}})["type"], "ok");
    const Json end = client.until([](const Message& m) { return m.text && m.json["type"] == "recording" && !m.json["active"]; }).json;
    EXPECT_EQ(end["name"], "run.tfr");
    EXPECT_EQ(end["frames"], 10);
    EXPECT_EQ(end["problem"], "");
    const Json list = client.command({{"id", 5}, {"command", "recordings"}})["recordings"];
    ASSERT_EQ(list.size(), 1U);
    EXPECT_EQ(list[0], Json({{"name", "run.tfr"}, {"bytes", end["bytes"]}}));
    EXPECT_EQ(client.command({{"id", 6}, {"command", "record_start"}, {"name", "run"}})["code"], "failed") << "nothing is replaced";

    const auto file = request(http::verb::get, "/recordings/run.tfr");
    EXPECT_EQ(file.result_int(), 200);
    EXPECT_EQ(file.body().size(), end["bytes"]);
    EXPECT_EQ(file.body().substr(0, 8), "tetfront");
    Recording recording(data_.path() / "recordings" / "run.tfr");
    EXPECT_TRUE(recording.complete());
    EXPECT_EQ(recording.frame_count(), 10U);
    EXPECT_EQ(recording.info().field, Field::strain);
    EXPECT_EQ(request(http::verb::head, "/recordings/run.tfr")[http::field::content_length], std::to_string(file.body().size()));
}

TEST_F(CommandsTest, SavesAMomentAndGoesBackToIt) {
    start_with_library();
    Client client(connect(), host());
    client.until(is_frame);
    const auto at_step = [&](int step) {
        client.until([&](const Message& m) { return m.text && m.json["type"] == "state" && m.json["step"] == step; });
    };
    EXPECT_EQ(client.command(place({{"id", 1}, {"command", "force_add"}, {"force", 7}, {"value", {0, 0, 5}}}))["type"], "ok");
    EXPECT_EQ(client.command(place({{"id", 1}, {"command", "stiffness_scale"}, {"value", 5}, {"radius", 0.5}}))["type"], "ok");
    EXPECT_EQ(client.command({{"id", 2}, {"command", "order"}, {"value", 1}})["type"], "ok");
    EXPECT_EQ(client.command({{"id", 2}, {"command", "levels"}, {"min", 0}, {"max", 0}})["type"], "ok");
    EXPECT_EQ(client.command({{"id", 3}, {"command", "step"}, {"count", 6}})["type"], "ok");
    at_step(6);
    EXPECT_EQ(client.command({{"id", 4}, {"command", "save"}, {"name", "six"}})["type"], "ok");
    EXPECT_EQ(client.command({{"id", 5}, {"command", "save"}, {"name", "six"}})["code"], "failed") << "nothing is replaced";
    const Json states = client.command({{"id", 6}, {"command", "states"}})["states"];
    ASSERT_EQ(states.size(), 1U);
    EXPECT_EQ(states[0]["name"], "six");
    EXPECT_EQ(states[0]["scene"], "beam");
    EXPECT_NEAR(states[0]["time"].get<double>(), 0.1, 1e-9);
    EXPECT_EQ(client.command({{"id", 7}, {"command", "force_remove"}, {"force", 7}})["type"], "ok");
    EXPECT_EQ(client.command(place({{"id", 7}, {"command", "stiffness_scale"}, {"value", 1}, {"radius", 0.5}}))["type"], "ok");
    EXPECT_EQ(client.command({{"id", 8}, {"command", "levels"}, {"min", 0}, {"max", 9}})["type"], "ok");
    EXPECT_EQ(client.command({{"id", 8}, {"command", "reset"}})["type"], "ok");
    at_step(0);
    EXPECT_EQ(client.command({{"id", 9}, {"command", "restore"}, {"name", "seven"}})["code"], "unknown_name");
    EXPECT_EQ(client.command({{"id", 10}, {"command", "restore"}, {"name", "six"}})["type"], "ok");
    const Json settings = client.event("settings");
    EXPECT_EQ(settings["forces"].size(), 1U);
    EXPECT_EQ(settings["stiffness_parts"], Json::array({place({{"value", 5.0}, {"radius", 0.5}})}));
    EXPECT_EQ(settings["order"], 1);
    EXPECT_EQ(settings["levels"], Json({{"min", 0}, {"max", 0}}));
    at_step(6);
    data_.write("states/bad.tfs", "{\"tetfront_state\": 1}\nbytes");
    EXPECT_EQ(client.command({{"id", 11}, {"command", "restore"}, {"name", "bad"}})["code"], "failed");
    EXPECT_EQ(client.command({{"id", 12}, {"command", "step"}})["type"], "ok");
    at_step(7);
}

TEST_F(CommandsTest, ARecordingThatCannotBeginIsRefused) {
    start_with_library(false, 100);
    Client client(connect(), host());
    client.until(is_frame);
    const Json refusal = client.command({{"id", 1}, {"command", "record_start"}, {"name", "run"}});
    EXPECT_EQ(refusal["code"], "failed");
    EXPECT_NE(refusal["message"].get<std::string>().find("limit of 100 bytes"), std::string::npos) << refusal;
    EXPECT_TRUE(Library({}, data_.path()).recordings().empty()) << "its name stays free";
    EXPECT_EQ(client.command({{"id", 2}, {"command", "step"}})["type"], "ok");
}

TEST_F(CommandsTest, ListsAreNotForFloods) {
    start_with_library();
    Client client(connect(), host());
    std::map<std::string, int> answers;
    for (int id = 0; id < 200; ++id) {
        const Json answer = client.command({{"id", id}, {"command", id % 2 ? "recordings" : "states"}});
        ++answers[answer["type"] == "ok" ? "ok" : answer["code"].get<std::string>()];
    }
    EXPECT_GE(answers["ok"], 10);
    EXPECT_GE(answers["too_many"], 1) << "two hundred took a second each ten";
    EXPECT_EQ(client.command({{"id", 201}, {"command", "pause"}})["type"], "ok");
}

TEST_F(CommandsTest, TopologiesOfAStateThatIsRestoredAreNewToAll) {
    start_with_library();
    Client client(connect(), host());
    int id = 0;
    const auto done = [&](Json command) {
        command["id"] = ++id;
        EXPECT_EQ(client.command(command)["type"], "ok") << command;
    };
    done({{"command", "save"}, {"name", "quadratic"}});
    done({{"command", "order"}, {"value", 1}});
    done({{"command", "save"}, {"name", "linear"}});
    std::set<std::uint32_t> epochs;
    for (const char* name : {"quadratic", "linear", "quadratic", "linear"}) {
        client.send(Json({{"id", ++id}, {"command", "restore"}, {"name", name}}).dump());
        const Message topology = client.until([](const Message& m) { return m.type() == 2; });
        const Message frame = client.until(is_frame);
        EXPECT_EQ(frame.at<std::uint32_t>(4), topology.at<std::uint32_t>(4));
        EXPECT_TRUE(epochs.insert(topology.at<std::uint32_t>(4)).second) << "viewers know another topology by this number";
    }
}

TEST_F(CommandsTest, ARecordingHasTheColoursThatWereRecorded) {
    start_with_library();
    {
        Client client(connect(), host());
        client.until(is_frame);
        EXPECT_EQ(client.command({{"id", 1}, {"command", "record_start"}, {"name", "run"}, {"colouring", "stress"}})["type"], "ok");
        EXPECT_EQ(client.command({{"id", 2}, {"command", "step"}, {"count", 10}})["type"], "ok");
        client.until([](const Message& m) { return m.text && m.json["type"] == "state" && m.json["step"] == 10; });
        EXPECT_EQ(client.command({{"id", 3}, {"command", "record_stop"}})["type"], "ok");
    }
    stop();
    serve(std::make_unique<Session>(Recording(data_.path() / "recordings" / "run.tfr"), false));
    Client client(connect(), host());
    EXPECT_EQ(client.event("hello")["recording"]["colouring"], "stress");
    EXPECT_EQ(client.command({{"id", 1}, {"command", "colouring"}, {"value", "stress"}})["type"], "ok");
    const Json refusal = client.command({{"id", 2}, {"command", "colouring"}, {"value", "strain"}});
    EXPECT_EQ(refusal["code"], "failed");
    EXPECT_EQ(refusal["pointer"], "/value");
    EXPECT_EQ(client.command({{"id", 3}, {"command", "colouring"}, {"value", "stiffness"}})["type"], "ok");
}

TEST_F(CommandsTest, ARecordingEndsAtTheLimitAndSaysSo) {
    start_with_library(true, 20'000);
    Client client(connect(), host());
    client.until(is_frame);
    EXPECT_EQ(client.command({{"id", 1}, {"command", "record_start"}})["type"], "ok");
    const Json log = client.event("log");
    EXPECT_EQ(log["level"], "warning");
    EXPECT_NE(log["message"].get<std::string>().find("limit of 20000 bytes"), std::string::npos);
    const auto files = Library({}, data_.path()).recordings();
    ASSERT_EQ(files.size(), 1U);
    EXPECT_LT(files[0].bytes, 40'000U);
    EXPECT_TRUE(Recording(files[0].path).complete());
}

TEST_F(CommandsTest, AnUnwritableFolderIsAnAnswer) {
    scenes_.write("file", "");
    start(false, {}, box_scene(), {.library = Library({}, scenes_.path() / "file")});
    Client client(connect(), host());
    client.until(is_frame);
    const Json refusal = client.command({{"id", 1}, {"command", "record_start"}});
    EXPECT_EQ(refusal["code"], "failed");
    EXPECT_EQ(refusal["message"].get<std::string>().find('/'), std::string::npos) << "where it lies is nobody's business: " << refusal;
    EXPECT_EQ(client.command({{"id", 2}, {"command", "step"}})["type"], "ok");
}

}  // namespace
}  // namespace tetfront
