// Commands that change what is simulated or shown, from the wire to the frames.

#include "server/net/compressed_frame.hpp"
#include "tests/server/net/commands_fixture.hpp"

#include <deque>

namespace tetfront {
namespace {

TEST_F(CommandsTest, ColouringAddsValuesForThisClientAlone) {
    start();
    Client plain(connect(), host()), coloured(connect(), host());
    coloured.until(is_frame);
    EXPECT_EQ(coloured.command({{"id", 1}, {"command", "colouring"}, {"value", "displacement"}})["type"], "ok");
    const Message frame = coloured.until([](const Message& m) { return m.type() == 4; });
    const std::size_t surface = frame.at<std::uint32_t>(12), begin = frame.bytes.size() - 12 - (2 * surface + 3) / 4 * 4;
    EXPECT_EQ(frame.at<std::uint32_t>(begin), 1U);
    plain.command({{"id", 2}, {"command", "step"}, {"count", 3}});
    const auto moved = [](const Message& m) { return is_frame(m) && m.at<double>(16) > 0.04; };
    EXPECT_EQ(plain.until(moved).type(), 3);
    const Message later = coloured.until(moved);
    EXPECT_EQ(later.type(), 4);
    EXPECT_GT(later.at<float>(begin + 4), 0) << "something has moved";
    EXPECT_EQ(coloured.command({{"id", 3}, {"command", "colouring"}, {"value", "level"}})["type"], "ok");
    plain.command({{"id", 4}, {"command", "step"}});
    EXPECT_EQ(coloured.until([](const Message& m) { return is_frame(m) && m.at<double>(16) > 0.06; }).type(), 3);
}

TEST_F(CommandsTest, CompressesTheFramesOfThisClientAlone) {
    start();
    Client plain(connect(), host()), small(connect(), host());
    small.until(is_frame);
    EXPECT_EQ(small.command({{"id", 1}, {"command", "compression"}, {"value", true}})["type"], "ok");
    const auto one_step = [&](int id) { plain.command({{"id", id}, {"command", "step"}}); };
    const auto at = [](const Message& m, double time) { return m.type() >= 3 && std::abs(m.at<double>(16) - time) < 1e-9; };
    one_step(1);
    const Message wanted = plain.until([&](const Message& m) { return at(m, 1.0 / 60); });
    EXPECT_EQ(wanted.type(), 3);
    EXPECT_EQ(small.until([&](const Message& m) { return at(m, 1.0 / 60); }).bytes, compress_frame(wanted.bytes));
    EXPECT_EQ(small.command({{"id", 2}, {"command", "colouring"}, {"value", "stress"}})["type"], "ok");
    const auto coloured = small.until([](const Message& m) { return m.type() == 5 && m.at<std::uint32_t>(56) == 3; });
    EXPECT_GT(coloured.at<float>(60), 0);
    EXPECT_EQ(small.command({{"id", 3}, {"command", "compression"}, {"value", false}})["type"], "ok");
    one_step(2);
    EXPECT_EQ(small.until([&](const Message& m) { return at(m, 2.0 / 60); }).type(), 4);
}

TEST_F(CommandsTest, AFrameIsEncodedOnceOfEachKindForAllClients) {
    start();
    std::deque<Client> clients;
    for (int i = 0; i < 6; ++i) {
        clients.emplace_back(connect(), host());
        clients.back().until(is_frame);
        if (i % 2 == 1) clients.back().command({{"id", 1}, {"command", "compression"}, {"value", true}});
    }
    const auto encoded = [&] {
        const std::string page = request(http::verb::get, "/metrics").body(), name = "\ntetfront_frames_encoded_total ";
        return std::stoi(page.substr(page.find(name) + name.size()));
    };
    const int before = encoded();
    constexpr int steps = 5;
    for (int step = 1; step <= steps; ++step) {
        clients[0].command({{"id", step}, {"command", "step"}});
        for (Client& client : clients)
            client.until([&](const Message& m) { return m.type() >= 3 && m.at<double>(16) > (step - 0.5) / 60; });
    }
    EXPECT_EQ(encoded() - before, 2 * steps) << "one plain and one compressed of each frame";
}

TEST_F(CommandsTest, EditsAreSharedAndSurviveTheirClient) {
    start();
    {
        Client editor(connect(), host());
        EXPECT_EQ(editor.command(place({{"id", 1}, {"command", "force_add"}, {"force", 7}, {"value", {0, 0, 5}}}))["type"], "ok");
        EXPECT_EQ(editor.command({{"id", 2}, {"command", "force_move"}, {"force", 7}, {"value", {0, 0, 9}}})["type"], "ok");
        EXPECT_EQ(editor.command({{"id", 3}, {"command", "force_move"}, {"force", 8}, {"value", {0, 0, 9}}})["code"], "unknown_name");
        EXPECT_EQ(editor.command(place({{"id", 4}, {"command", "pin"}, {"radius", 0.5}}))["type"], "ok");
        EXPECT_EQ(editor.command({{"id", 5}, {"command", "stiffness_scale"}, {"value", 2}})["type"], "ok");
        for (const double value : {5.0, 3.0})
            EXPECT_EQ(editor.command(place({{"id", 9}, {"command", "stiffness_scale"}, {"value", value}, {"radius", 0.5}}))["type"], "ok");
        EXPECT_EQ(editor.command({{"id", 6}, {"command", "damping"}, {"mass", 1}, {"stiffness", 0.5}})["type"], "ok");
        EXPECT_EQ(editor.command({{"id", 7}, {"command", "order"}, {"value", 1}})["type"], "ok");
        EXPECT_EQ(editor.command({{"id", 10}, {"command", "levels"}, {"min", 1}, {"max", 9}})["type"], "ok");
        Json bad = place({{"id", 8}, {"command", "force_add"}, {"force", 9}, {"value", {0, 0, 5}}});
        bad["triangle"] = 99999;
        const Json refusal = editor.command(bad);
        EXPECT_EQ(refusal["code"], "failed");
        EXPECT_EQ(refusal["pointer"], "/triangle");
    }
    Client late(connect(), host());
    const Json settings = late.event("settings");
    EXPECT_EQ(settings["forces"], Json::array({place({{"force", 7}, {"value", {0.0, 0.0, 9.0}}})}));
    EXPECT_EQ(settings["pins"].size(), 1U);
    EXPECT_EQ(settings["stiffness_scale"], 2.0);
    EXPECT_EQ(settings["stiffness_parts"], Json::array({place({{"value", 3.0}, {"radius", 0.5}})})) << "the same place again replaces it";
    EXPECT_EQ(settings["damping"], Json({{"mass", 1.0}, {"stiffness", 0.5}}));
    EXPECT_EQ(settings["order"], 1);
    EXPECT_EQ(settings["levels"], Json({{"min", 1}, {"max", 1}})) << "as deep as the scene goes";
    EXPECT_EQ(late.command({{"id", 1}, {"command", "force_remove"}, {"force", 7}})["type"], "ok");
    EXPECT_EQ(late.event("settings")["forces"], Json::array());
    EXPECT_EQ(late.command({{"id", 2}, {"command", "step"}, {"count", 5}})["type"], "ok");
    late.until([](const Message& m) { return m.text && m.json["type"] == "state" && m.json["step"] == 5; });
}

TEST_F(CommandsTest, ForcesAreBounded) {
    start();
    Client client(connect(), host());
    for (int i = 0; i < 64; ++i)
        EXPECT_EQ(client.command(place({{"id", i}, {"command", "force_add"}, {"force", i}, {"value", {0, 0, 1}}}))["type"], "ok");
    EXPECT_EQ(client.command(place({{"id", 99}, {"command", "force_add"}, {"force", 99}, {"value", {0, 0, 1}}}))["code"], "too_many");
    EXPECT_EQ(client.command(place({{"id", 98}, {"command", "force_add"}, {"force", 3}, {"value", {0, 0, 1}}}))["type"], "ok");
}

TEST_F(CommandsTest, PartsOfOtherStiffnessAreBounded) {
    start();
    Client client(connect(), host());
    for (int i = 0; i < 64; ++i)
        EXPECT_EQ(client.command(place({{"id", i}, {"command", "stiffness_scale"}, {"value", 2}, {"radius", i / 64.0}}))["type"], "ok");
    EXPECT_EQ(client.command(place({{"id", 99}, {"command", "stiffness_scale"}, {"value", 2}, {"radius", 3}}))["code"], "too_many");
    EXPECT_EQ(client.command(place({{"id", 98}, {"command", "stiffness_scale"}, {"value", 4}, {"radius", 0.25}}))["type"], "ok");
}

TEST_F(CommandsTest, APartAsTheSceneHasItIsForgottenUnlessItLiesOverAnother) {
    start();
    Client client(connect(), host());
    using Parts = std::vector<std::pair<double, double>>;
    const auto become = [&](double value, double radius, const Parts& wanted) {
        EXPECT_EQ(client.command(place({{"id", 1}, {"command", "stiffness_scale"}, {"value", value}, {"radius", radius}}))["type"], "ok");
        Parts parts;
        for (int i = 0; i < 500; ++i) {  // everybody is told soon after the answer
            Client late(connect(), host());
            const Json settings = late.event("settings");
            parts.clear();
            for (const Json& part : settings["stiffness_parts"]) parts.emplace_back(part["value"], part["radius"]);
            if (parts == wanted) break;
            std::this_thread::sleep_for(10ms);
        }
        EXPECT_EQ(parts, wanted);
    };
    become(5, 0.5, {{5, 0.5}});
    become(1, 0.25, {{5, 0.5}, {1, 0.25}});  // a hole in the stiffer part
    become(2, 0.125, {{5, 0.5}, {1, 0.25}, {2, 0.125}});
    become(5, 0.5, {{2, 0.125}, {5, 0.5}});  // the hole is filled
    become(1, 0.125, {{5, 0.5}, {1, 0.125}});
    become(1, 0.5, {});
}

TEST_F(CommandsTest, AnAcknowledgingClientHasTwoFramesInFlight) {
    start(true);
    Client client(connect(), host());
    const Message first = client.until(is_frame);
    client.acknowledge(first);
    // Everything that was sent before the acknowledgement arrived comes in; then nothing, until the next one.
    std::uint32_t newest = first.at<std::uint32_t>(8);
    const auto read = [&] {
        Message m = client.read();
        if (is_frame(m)) newest = m.at<std::uint32_t>(8);
        return m;
    };
    for (Message m = read(); !(m.text && m.json["type"] == "link"); m = read()) {
    }
    for (int id = 1; id < 40; ++id) {
        client.send(Json({{"id", id}, {"command", "speed"}, {"value", 1}}).dump());
        for (Message m = read(); !(m.text && m.json.contains("id")); m = read()) {
        }
    }
    const std::uint32_t held = newest;
    std::this_thread::sleep_for(200ms);
    client.send(Json({{"id", 100}, {"command", "speed"}, {"value", 1}}).dump());
    for (Message m = client.read(); !(m.text && m.json.contains("id")); m = client.read())
        EXPECT_FALSE(is_frame(m)) << "a third frame in flight";
    client.send(Json({{"command", "ack"}, {"frame", held}}).dump());
    EXPECT_GT(client.until(is_frame).at<std::uint32_t>(8), held);
    EXPECT_GT(client.event("link")["dropped"], 0);
}

TEST_F(CommandsTest, ListsAndLoadsScenes) {
    start_with_library();
    Client client(connect(), host()), other(connect(), host());
    const Json hello = client.event("hello");
    EXPECT_EQ(hello["generation"], 1);
    const Json list = client.command({{"id", 1}, {"command", "scenes"}});
    ASSERT_FALSE(list["scenes"].empty());
    EXPECT_EQ(list["scenes"].back(), Json({{"name", "small"}, {"title", "Another"}}));
    for (const Json& scene : list["scenes"]) EXPECT_NE(scene["name"], "none");
    EXPECT_EQ(client.command({{"id", 2}, {"command", "load"}, {"scene", "nowhere"}})["code"], "unknown_name");
    EXPECT_EQ(client.command({{"id", 2}, {"command", "load"}, {"scene", "none"}})["code"], "failed") << "a file, but no scene";
    EXPECT_EQ(client.command({{"id", 3}, {"command", "load"}, {"scene", "../small"}})["code"], "out_of_range");
    const Json missing = client.command({{"id", 4}, {"command", "load"}, {"scene", "bad"}});
    EXPECT_EQ(missing["code"], "failed");
    EXPECT_NE(missing["message"].get<std::string>().find("missing.obj"), std::string::npos) << "names the mesh: " << missing;
    EXPECT_EQ(client.command({{"id", 5}, {"command", "step"}})["type"], "ok") << "the first scene goes on";
    EXPECT_EQ(client.command({{"id", 6}, {"command", "stiffness_scale"}, {"value", 2}})["type"], "ok");
    client.send(R"({"id": 7, "command": "load", "scene": "small"})");
    for (Client* viewer : {&client, &other}) {
        const Message again = viewer->until([](const Message& m) { return m.text && m.json["type"] == "hello" && m.json["generation"] == 2; });
        EXPECT_EQ(again.json["scene"]["title"], "Another");
        EXPECT_EQ(again.json["gravity"], Json({0.0, 0.0, -1.0}));
        const Message model = viewer->until([](const Message& m) { return !m.text; });
        EXPECT_EQ(model.type(), 1);
        EXPECT_EQ(model.at<std::uint16_t>(2), 2);
        EXPECT_EQ(viewer->until([](const Message& m) { return !m.text; }).type(), 2);
        EXPECT_EQ(viewer->until([](const Message& m) { return !m.text; }).type(), 3);
        EXPECT_EQ(viewer->event("settings")["stiffness_scale"], 1.0) << "edits belong to their scene";
    }
    EXPECT_EQ(other.command({{"id", 1}, {"command", "step"}, {"count", 2}})["type"], "ok");
    other.until([](const Message& m) { return m.text && m.json["type"] == "state" && m.json["step"] == 2; });
}

TEST_F(CommandsTest, TheSimulationGoesOnWhileAnotherSceneIsBuilt) {
    start_with_library(true);
    Client client(connect(), host());
    begin_to_load_large(client);
    EXPECT_EQ(client.command({{"id", 2}, {"command", "speed"}, {"value", 2}})["type"], "ok") << "answered before the load";
    EXPECT_EQ(client.command({{"id", 3}, {"command", "load"}, {"scene", "small"}})["code"], "failed") << "one at a time";
    bool loaded = false, ready = false;
    double first = -1, last = -1;  // [s] of frames of the present scene
    while (!(loaded && ready)) {
        const Message m = client.read();
        if (is_frame(m) && m.at<std::uint16_t>(2) == 1) {
            last = m.at<double>(16);
            if (first < 0) first = last;
        }
        if (!m.text) continue;
        if (m.json["type"] == "ok") loaded = true;
        if (m.json["type"] == "hello") {
            ready = true;
            EXPECT_EQ(m.json["scene"]["title"], "Large");
            EXPECT_EQ(m.json["speed"], 2.0);
        }
    }
    EXPECT_GT(last, first) << "it went on meanwhile";
    EXPECT_EQ(client.until(is_frame).at<std::uint16_t>(2), 2);
}

TEST_F(CommandsTest, LoadingEndsARecordingForAllToSee) {
    start_with_library();
    Client client(connect(), host());
    client.until(is_frame);
    const auto recording = [](bool active) {
        return [active](const Message& m) { return m.text && m.json["type"] == "recording" && m.json["active"] == active; };
    };
    EXPECT_EQ(client.command({{"id", 1}, {"command", "record_start"}, {"name", "run"}, {"fps", 60}})["type"], "ok");
    client.until(recording(true));
    client.send(R"({"id": 2, "command": "load", "scene": "small"})");
    client.until(recording(false));
    Client late(connect(), host());
    EXPECT_FALSE(late.event("recording")["active"]) << "also for those who come later";
}

TEST_F(CommandsTest, AServerStopsWhileASceneIsBuilt) {
    start_with_library(true);
    Client client(connect(), host());
    begin_to_load_large(client);
    std::thread stopper([this] { stop(); });
    EXPECT_EQ(client.closed(), 1001);
    stopper.join();
    EXPECT_FALSE(failure_);
}

TEST_F(CommandsTest, ScenesAreBounded) {
    start(false, {}, box_scene(), {.library = Library(scenes_.path(), data_.path()), .tets = 20});
    Client client(connect(), host());
    client.until(is_frame);
    client.send(R"({"id": 1, "command": "load", "scene": "small"})");
    Json refusal, over;
    while (refusal.is_null() || over.is_null()) {  // in either order
        const Message m = client.read();
        if (m.text && m.json["type"] == "error") refusal = m.json;
        if (m.text && m.json["type"] == "progress" && m.json["fraction"] == 1.0) over = m.json;
    }
    EXPECT_EQ(refusal["code"], "failed");
    EXPECT_EQ(refusal["pointer"], "/levels");
    EXPECT_NE(refusal["message"].get<std::string>().find("this server loads scenes of 20 at most"), std::string::npos) << refusal;
}

TEST_F(CommandsTest, HelloSaysWhatTheSceneSays) {
    start();
    Client first(connect(), host());
    Json hello = first.event("hello");
    EXPECT_EQ(hello["budget"], Json({{"tets", nullptr}, {"milliseconds", nullptr}}));
    int id = 0;
    for (Json command : {Json({{"command", "gravity"}, {"value", {1, 2, 3}}}), Json({{"command", "tolerance"}, {"value", 0.5}}),
                         Json({{"command", "order"}, {"value", 1}}), Json({{"command", "levels"}, {"min", 1}, {"max", 1}}),
                         Json({{"command", "budget"}, {"tets", 77}})}) {
        command["id"] = ++id;
        EXPECT_EQ(first.command(command)["type"], "ok") << command;
    }
    Client late(connect(), host());
    EXPECT_EQ(late.event("hello"), hello) << "what one goes back to, not what is now";
    EXPECT_EQ(late.event("settings")["order"], 1);
    EXPECT_EQ(late.event("state")["tolerance"], 0.5);
}

TEST_F(CommandsTest, ThePresentWordOnAPlaceReplacesTheOneBefore) {
    start();
    Client client(connect(), host());
    for (const char* command : {"pin", "unpin", "pin", "unpin"})
        EXPECT_EQ(client.command(place({{"id", 1}, {"command", command}, {"radius", 0.5}}))["type"], "ok");
    EXPECT_EQ(client.command(place({{"id", 2}, {"command", "pin"}, {"radius", 0.25}}))["type"], "ok");
    Client late(connect(), host());
    EXPECT_EQ(late.event("settings")["pins"],
              Json::array({place({{"pinned", false}, {"radius", 0.5}}), place({{"pinned", true}, {"radius", 0.25}})}));
}

TEST_F(CommandsTest, WithoutALibraryNothingIsLoadedOrKept) {
    start();
    Client client(connect(), host());
    const Json hello = client.event("hello");
    EXPECT_EQ(hello["capabilities"], Json({"acknowledge", "colouring", "compress", "edit"}));
    EXPECT_EQ(client.command({{"id", 1}, {"command", "load"}, {"scene", "small"}})["code"], "failed");
    EXPECT_EQ(client.command({{"id", 2}, {"command", "record_start"}})["code"], "failed");
    EXPECT_EQ(client.command({{"id", 3}, {"command", "scenes"}})["scenes"], Json::array());
    EXPECT_EQ(client.command({{"id", 4}, {"command", "recordings"}})["recordings"], Json::array());
}

}  // namespace
}  // namespace tetfront
