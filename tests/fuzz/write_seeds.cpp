// Writes small valid files for the fuzzers to start from: write_seeds DIRECTORY makes DIRECTORY/gmsh/..., and so on.

#include "server/session/recording.hpp"
#include "tests/engine/mesh/tet_files.hpp"
#include "tests/support/blob_frame.hpp"
#include "tests/support/scenes.hpp"

#include <filesystem>
#include <fstream>
#include <iostream>

int main(int argc, char** argv) {
    using namespace tetfront;
    if (argc != 2) {
        std::cerr << "usage: write_seeds DIRECTORY\n";
        return 2;
    }
    const auto write = [&](const std::string& fuzzer, const std::string& name, const std::string& bytes) {
        const std::filesystem::path directory = std::filesystem::path(argv[1]) / fuzzer;
        std::filesystem::create_directories(directory);
        std::ofstream out(directory / name, std::ios::binary);
        out << bytes;
        if (!out) throw std::runtime_error("cannot write " + (directory / name).string());
    };
    const TetMesh sample = tet_files::sample();
    for (const auto& [name, bytes] : tet_files::all(sample)) {
        const std::string extension = std::filesystem::path(name).extension().string();
        write(extension == ".msh" ? "gmsh" : extension == ".mesh" ? "medit" : extension.substr(1), name, bytes);
    }
    for (int first : {0, 1}) {
        const auto [node, ele] = tet_files::tetgen(sample, first);
        write("tetgen", "pair" + std::to_string(first), node + "\n====\n" + ele);
    }
    const auto recordings = std::filesystem::path(argv[1]) / "recording";
    std::filesystem::create_directories(recordings);
    for (const Field field : {Field::none, Field::stress}) {
        RecordingInfo info;
        info.field = field;
        const auto frame = blob_frame(4);
        frame->field = field;
        if (field != Field::none) frame->field_values.assign(frame->surface.size(), 0.5F);
        RecordingWriter writer(recordings / ("field" + std::to_string(static_cast<int>(field))), info, *frame->model);
        for (int i = 0; i < 2; ++i) writer.add(*frame);
        writer.finish();
    }
    Simulation simulation(testing::snapshot_model());
    simulation.begin_pull(1, {0, Vec3::Constant(1.0 / 3)}, Vec3(-1, 1, 2));
    for (int i = 0; i <= 10; ++i) {
        if (i % 5 == 0) write("snapshot", "step" + std::to_string(i), simulation.snapshot());
        simulation.step();
    }
    write("commands", "play", R"({"id": 1, "command": "play"})");
    write("commands", "pull", R"({"id": 2, "command": "pull_begin", "pull": 0, "triangle": 1, "barycentric": [1, 0, 0], "target": [0, 0.5, -1e3]})");
    write("commands", "force", R"({"id": 3, "command": "force_add", "force": 4, "triangle": 1, "barycentric": [0, 1, 0], "value": [0, 0, 9]})");
    write("commands", "record", R"({"id": 4, "command": "record_start", "name": "run", "fps": 60, "colouring": "stress"})");
    write("commands", "ack", R"({"command": "ack", "frame": 7})");
    // A cube of two by two by one on the grid of fuzz_surface.cpp.
    std::string cube;
    for (int v = 0; v < 16; ++v)
        cube += static_cast<char>((v & 1 ? 2 : 0) | (v & 2 ? 2 : 0) << 3 | (v & 4 ? 1 : 0) << 6);
    for (const auto& t : {std::array{0, 2, 1},
                          {1, 2, 3},
                          {4, 5, 6},
                          {5, 7, 6},
                          {0, 1, 4},
                          {1, 5, 4},
                          {2, 6, 3},
                          {3, 6, 7},
                          {0, 4, 2},
                          {2, 4, 6},
                          {1, 3, 5},
                          {3, 7, 5}}) {
        cube += static_cast<char>(t[0] | t[1] << 4);
        cube += static_cast<char>(t[2]);
    }
    write("surface", "cube", cube);
}
