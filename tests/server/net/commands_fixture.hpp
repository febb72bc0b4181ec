#pragma once
// A server with a library of scenes, for tests of commands.
//
//     TEST_F(CommandsTest, ...) { start_with_library(); Client client(connect(), host()); ... }

#include "tests/server/net/client.hpp"

namespace tetfront {

inline const auto is_frame = [](const Message& m) { return m.type() == 3 || m.type() == 4; };

class CommandsTest : public ServerTest {
 protected:
    CommandsTest() {
        scenes_.write("small.json", R"({"schema_version": 1, "up": "z", "title": "Another",
            "mesh": {"box": {"low": [0, 0, 0], "high": [1, 1, 1], "cells": [1, 1, 1]}}, "levels": 1,
            "material": {"density": 1000, "poisson": 0.3, "young": 1e5}, "gravity": [0, 0, -1]})");
        scenes_.write("bad.json", R"({"schema_version": 1, "up": "z", "mesh": {"surface": {"file": "missing.obj"}}, "levels": 1,
            "material": {"density": 1000, "poisson": 0.3, "young": 1e5}})");
        scenes_.write("none.json", "[]");
        scenes_.write(".hidden.json", "{}");
    }
    void start_with_library(bool playing = false, std::uint64_t recording_bytes = 1 << 20) {
        start(playing, {}, box_scene(),
              {.library = Library(scenes_.path(), data_.path()), .recording_bytes = recording_bytes});
    }
    /// Returns while that scene is built, which takes a second or so.
    void begin_to_load_large(Client& client) {
        scenes_.write("large.json", R"({"schema_version": 1, "up": "z", "title": "Large",
            "mesh": {"box": {"low": [0, 0, 0], "high": [1, 1, 1], "cells": [6, 6, 6]}}, "levels": 2,
            "material": {"density": 1000, "poisson": 0.3, "young": 1e5}})");
        client.until(is_frame);
        client.send(R"({"id": 1, "command": "load", "scene": "large"})");
        client.until([](const Message& m) { return m.text && m.json["type"] == "progress"; });
    }
    static Json place(Json command) {
        command["triangle"] = 0;
        command["barycentric"] = {1, 0, 0};
        return command;
    }
    TemporaryFolder scenes_, data_;
};

}  // namespace tetfront
