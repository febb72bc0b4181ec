// Runs the built program: exit statuses, what goes to stdout, signals.

#include "tests/support/child_process.hpp"
#include "tests/support/project.hpp"
#include "tests/support/temporary_folder.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <pugixml.hpp>

namespace tetfront {
namespace {

using Json = nlohmann::json;

constexpr const char* beam = R"({
  "schema_version": 1, "title": "A beam", "up": "z",
  "mesh": {"box": {"low": [0, 0, 0], "high": [4, 1, 1], "cells": [4, 1, 1]}},
  "levels": 1,
  "material": {"density": 1000, "poisson": 0.3, "young": 1e5},
  "pins": [{"half_space": {"point": [0.001, 0, 0], "normal": [1, 0, 0]}}],
  "damping": {"mass": 0.5}
})";

class Program : public testing::Test {
 protected:
    Program() {
        scene_ = folder_.write("beam.json", beam).string();
        web_ = folder_.write("web/index.html", "<!doctype html>").parent_path().string();
    }

    static ChildProcess::Result run(std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), program_path());
        return ChildProcess(arguments).wait();
    }
    static void expect_refusal(const ChildProcess::Result& result, int status, const std::string& part) {
        EXPECT_EQ(result.status, status) << result.err;
        EXPECT_EQ(result.out, "");
        EXPECT_EQ(std::ranges::count(result.err, '\n'), 1) << "one line: " << result.err;
        EXPECT_NE(result.err.find(part), std::string::npos) << result.err;
    }
    [[nodiscard]] std::string path(const std::string& name) const { return (folder_.path() / name).string(); }
    static Json read_json(const std::string& file) {
        std::ifstream in(file);
        return Json::parse(in);
    }

    TemporaryFolder folder_;
    std::string scene_, web_;
};

TEST_F(Program, ShowsVersionAndHelp) {
    const auto version = run({"--version"});
    EXPECT_EQ(version.status, 0);
    EXPECT_EQ(version.out.substr(0, 9), "tetfront ");
    for (const auto& arguments : std::vector<std::vector<std::string>>{
             {"--help"}, {"serve", "--help"}, {"run", "--help"}, {"study", "--help"}, {"info", "--help"}}) {
        const auto help = run(arguments);
        EXPECT_EQ(help.status, 0);
        EXPECT_NE(help.out.find("Exit status: 0 success"), std::string::npos) << help.out;
    }
}

TEST_F(Program, WrongUsageIsStatus2AndOneLine) {
    expect_refusal(run({}), 2, "--help");
    expect_refusal(run({"fly"}), 2, "fly");
    expect_refusal(run({"run"}), 2, "scene");
    expect_refusal(run({"run", scene_, "--steps", "0"}), 2, "steps");
    expect_refusal(run({"run", scene_, "--steps", "x"}), 2, "steps");
    expect_refusal(run({"run", scene_, "--compare", "nothing"}), 2, "finest-quadratic");
    expect_refusal(run({"serve", scene_, "--port", "65536"}), 2, "port");
    const auto refused_study = [&](const std::string& option, const std::string& value, const std::string& part) {
        expect_refusal(run({"study", scene_, option, value, "--out", path("study")}), 2, part);
        EXPECT_FALSE(std::filesystem::exists(path("study"))) << option << value;
    };
    refused_study("--orders", "3", "orders");
    refused_study("--tolerances", "0.1,2", "tolerances");
    refused_study("--budgets", "5s", "500");
    refused_study("--budgets", "0", "500");
    refused_study("--budgets", "-1ms", "5ms");
    refused_study("--seconds", "1e-9", "seconds");
    refused_study("--reference", "best", "finer");
    refused_study("--set", "levels=0", "levels");
    expect_refusal(run({"study", scene_, "--seconds", "1", "--steps", "5"}), 2, "excludes");
    expect_refusal(run({"serve", scene_, "--web", path("none")}), 2, "npm run build");
    expect_refusal(run({"serve", scene_, "--web", web_, "--host", "nowhere"}), 2, "--host");
}

TEST_F(Program, BadScenesAreStatus2AndSayWhere) {
    expect_refusal(run({"info", path("missing.json")}), 2, "missing.json");
    expect_refusal(run({"run", scene_, "--set", "material.poisson=0.7"}), 2, "/material/poisson");
    expect_refusal(run({"run", scene_, "--set", "nothing=1"}), 2, "/nothing");
    expect_refusal(run({"run", scene_, "--set", "nothing"}), 2, "PATH=VALUE");
    folder_.write("broken.json", "{\"schema_version\": 1,");
    expect_refusal(run({"serve", path("broken.json"), "--web", web_}), 2, "broken.json");
    folder_.write("lost.json", R"({"schema_version": 1, "mesh": {"surface": {"file": "lost.obj"}}})");
    expect_refusal(run({"info", path("lost.json")}), 2, "lost.obj");
}

TEST_F(Program, AKilledRunResumesToTheSameState) {
    const std::string state = path("run.state");
    const auto hash_of = [&](std::vector<std::string> more) -> std::string {
        std::vector<std::string> arguments = {"run", scene_, "--no-cache", "--set", "front/tolerance=0.005", "--steps", "300", "--report", path("out.json")};
        arguments.insert(arguments.end(), more.begin(), more.end());
        const auto result = run(arguments);
        EXPECT_EQ(result.status, 0) << result.err;
        const Json report = read_json(path("out.json"));
        EXPECT_NE(result.out.find(report["state_hash"].get<std::string>()), std::string::npos) << result.out;
        return report["state_hash"].get<std::string>() + " from " + std::to_string(report["resumed_at_step"].get<int>() > 0);
    };
    const std::string whole = hash_of({});
    {
        ChildProcess killed({program_path(), "run", scene_, "--no-cache", "--set", "front/tolerance=0.005", "--steps", "100000", "--save", state, "--save-every", "20"});
        while (!std::filesystem::exists(state)) std::this_thread::yield();
        killed.signal(SIGKILL);
        EXPECT_EQ(killed.wait().status, -SIGKILL);
    }
    const std::string kept = path("kept.state");
    std::filesystem::copy_file(state, kept);
    EXPECT_EQ(hash_of({"--resume", state, "--save", state}).substr(0, 16), whole.substr(0, 16));
    // The same twice: what was saved is not used up.
    const std::string again = hash_of({"--resume", kept});
    EXPECT_EQ(again, whole.substr(0, 16) + " from 1");
    EXPECT_EQ(whole.substr(17), "from 0");

    const auto refused = [&](std::vector<std::string> more, const std::string& part) {
        more.insert(more.begin(), {"run", scene_, "--no-cache", "--set", "front/tolerance=0.005"});
        expect_refusal(run(more), 2, part);
    };
    refused({"--resume", state, "--steps", "300"}, "has made 300 of 300 steps");
    refused({"--resume", kept, "--steps", "300", "--set", "material/young=2e5"}, "other settings of this scene");
    refused({"--resume", path("none.state")}, "does not exist");
    refused({"--resume", scene_}, "is no state of a simulation");
    refused({"--resume", kept, "--compare", "finest"}, "excludes");
    refused({"--save-every", "5"}, "--save");
    refused({"--save", scene_}, "beam.json");
    std::filesystem::resize_file(kept, 1000);
    refused({"--resume", kept}, "is cut short");
    expect_refusal(run({"run", scene_, "--save", path("no/such/folder.state")}), 4, "cannot be written");
}

TEST_F(Program, InfoDescribesTheScene) {
    const auto result = run({"info", scene_});
    EXPECT_EQ(result.status, 0) << result.err;
    for (const char* part : {"24", "192", "4000", "100000", "MiB"})
        EXPECT_NE(result.out.find(part), std::string::npos) << part << result.out;
}

TEST_F(Program, KeepsElasticityMatricesInTheCacheUnlessToldNotTo) {
    const std::string cache = path("cache"), gradient = R"(material.young={"linear": {"axis": "x", "values": [1e5, 2e5]}})";
    const auto info = [&](std::vector<std::string> more) {
        std::vector<std::string> arguments = {"info", scene_, "--coarsening", "--set", gradient};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return run(arguments);
    };
    const auto none = info({"--no-cache"});
    EXPECT_EQ(none.status, 0) << none.err;
    const auto first = info({"--cache", cache});
    EXPECT_EQ(first.out.substr(0, first.out.find("range ends")), none.out.substr(0, none.out.find("range ends")));
    ASSERT_EQ(std::distance(std::filesystem::directory_iterator(cache), {}), 1);
    const std::filesystem::path file = std::filesystem::directory_iterator(cache)->path();
    EXPECT_EQ(info({"--cache", cache}).out, first.out) << "even the times are those of the computation";

    std::filesystem::resize_file(file, std::filesystem::file_size(file) - 1);
    const auto damaged = info({"--cache", cache});
    EXPECT_EQ(damaged.status, 0);
    EXPECT_NE(damaged.err.find(file.filename().string() + " is truncated; computing it again"), std::string::npos)
        << damaged.err;
    EXPECT_EQ(info({"--cache", cache}).err, "") << "replaced";
    EXPECT_NE(first.out.find("mean"), std::string::npos) << first.out;
    expect_refusal(info({"--cache", cache, "--no-cache"}), 2, "--no-cache");
}

TEST_F(Program, ImportWritesASceneThatRuns) {
    // In millimetres, as CAD files are; STL stands along z.
    const std::string model = folder_.write("part/tet.stl", "solid t\n"
        "facet normal 0 0 -1 outer loop vertex 0 0 0 vertex 0 90 0 vertex 80 0 0 endloop endfacet\n"
        "facet normal 0 -1 0 outer loop vertex 0 0 0 vertex 80 0 0 vertex 0 0 100 endloop endfacet\n"
        "facet normal -1 0 0 outer loop vertex 0 0 0 vertex 0 0 100 vertex 0 90 0 endloop endfacet\n"
        "facet normal 1 1 1 outer loop vertex 80 0 0 vertex 0 90 0 vertex 0 0 100 endloop endfacet\nendsolid\n").string();
    const std::string scene = path("scene.json");
    const auto first = run({"import", model, "-o", scene, "--target-tets", "60", "--levels", "1"});
    ASSERT_EQ(first.status, 0) << first.err;
    EXPECT_NE(first.out.find("0.08 x 0.09 x 0.1 m"), std::string::npos) << first.out;
    const Json written = read_json(scene);
    EXPECT_EQ(written["mesh"]["surface"]["file"], "part/tet.stl") << "relative to the scene";
    EXPECT_EQ(written["up"], "z");
    EXPECT_EQ(run({"run", scene, "--steps", "3"}).status, 0);
    expect_refusal(run({"import", model, "-o", scene}), 2, "exists already; choose another name, or use --force");
    EXPECT_EQ(run({"import", model, "-o", scene, "--force", "--up", "y", "--scale", "0.01"}).status, 0);
    EXPECT_EQ(read_json(scene)["up"], "y");
    expect_refusal(run({"import", path("none.ply"), "-o", path("new.json")}), 2, "none.ply");
    EXPECT_FALSE(std::filesystem::exists(path("new.json")));
    expect_refusal(run({"import", model, "-o", path("no/such/folder.json")}), 4, "folder.json");
}

TEST_F(Program, ImportKeepsTheRegionsOfATetMesh) {
    const std::string mesh = folder_.write("two.mesh",
        "MeshVersionFormatted 2\nDimension 3\nVertices\n5\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n1 1 1 0\n"
        "Tetrahedra\n2\n1 2 3 4 1\n2 3 4 5 2\nEnd\n").string();
    ASSERT_EQ(run({"import", mesh, "-o", path("two.json")}).status, 0);
    EXPECT_EQ(read_json(path("two.json"))["material"]["regions"]["materials"].size(), 2U);
    EXPECT_EQ(run({"run", path("two.json"), "--steps", "2"}).status, 0);
}

TEST_F(Program, CoarseningOfAUniformMaterialIsOneLine) {
    const auto result = run({"info", scene_, "--coarsening", "--no-cache"});
    EXPECT_EQ(result.status, 0);
    EXPECT_NE(result.out.find("coarsening the material is uniform"), std::string::npos) << result.out;
}

TEST_F(Program, RunWritesAReport) {
    const auto result = run({"run", scene_, "--steps", "5", "--report", path("out.json"), "--compare", "finest",
                             "--compare", "finest-linear", "--set", "front.tolerance=0.05"});
    EXPECT_EQ(result.status, 0) << result.err;
    EXPECT_NE(result.out.find("5 steps"), std::string::npos);
    EXPECT_EQ(result.err, "") << "no progress bar without a terminal";
    const Json report = read_json(path("out.json"));
    ASSERT_EQ(report["steps"].size(), 5U);
    EXPECT_EQ(report["tolerance"], 0.05);
    for (const Json& step : report["steps"]) {
        EXPECT_GT(step["time"], 0);
        EXPECT_EQ(step["tets_by_level"].size(), 2U);
        for (const char* phase : {"total", "adapt", "setup", "assemble", "solve", "other"})
            EXPECT_GE(step["milliseconds"][phase], 0);
        EXPECT_GT(step["solver_iterations"], 0);
        EXPECT_TRUE(step["converged"]);
        EXPECT_GE(step["compare"]["finest"]["error_max"], step["compare"]["finest"]["error_mean"]);
        EXPECT_GT(step["compare"]["finest-linear"]["error_mean"], 0) << "another order moves differently";
    }
    const Json& summary = report["summary"];
    EXPECT_EQ(summary["steps"], 5);
    EXPECT_NEAR(summary["simulated_time"], 5.0 / 60, 1e-12);
    EXPECT_EQ(summary["compare"]["finest"]["tets"], 24);
    EXPECT_EQ(summary["compare"]["finest-linear"]["tets"], 192);
    EXPECT_GT(summary["compare"]["finest"]["time_ratio"], 0);
}

/// Fields of the lines of a CSV without commas in its fields.
std::vector<std::vector<std::string>> read_csv(const std::string& file) {
    std::vector<std::vector<std::string>> rows;
    std::ifstream in(file);
    for (std::string line, field; std::getline(in, line);) {
        rows.emplace_back();
        for (std::istringstream fields(line + ','); std::getline(fields, field, ',');) rows.back().push_back(field);
    }
    return rows;
}

TEST_F(Program, StudyWritesACsvAndAPicture) {
    for (const std::string reference : {"finest", "finer"}) {
        const std::string directory = path("a/" + reference);
        const auto result = run({"study", scene_, "--set", "front.budget.tets=30", "--seconds", "0.1", "--tolerances", "0.01,0.1", "--budgets",
                                 "none,40", "--out", directory, "--reference", reference});
        ASSERT_EQ(result.status, 0) << result.err;
        EXPECT_NE(result.out.find("study.svg"), std::string::npos) << result.out;
        const auto rows = read_csv(directory + "/study.csv");
        const std::size_t finer = reference == "finer";
        ASSERT_EQ(rows.size(), 1 + finer + 2 + 2 * 2 * 2);  // head, reference, finest levels, orders x tolerances x budgets
        const std::vector<std::string> head = {"front", "order", "tolerance", "budget_tets", "budget_milliseconds", "milliseconds_per_step", "tets_mean",
                                               "tets_max", "error_mean", "error_max", "relative_error", "estimate", "cg_iterations_per_step",
                                               "front_changed_per_step", "steps_in_trouble"};
        EXPECT_EQ(rows[0], head);
        for (const auto& row : rows) EXPECT_EQ(row.size(), head.size());
        EXPECT_EQ(rows[1][0], finer ? "\"finer quadratic\"" : "\"finest quadratic\"");
        EXPECT_EQ(rows[1][8], "") << "the reference has no error";
        EXPECT_EQ(rows[1][7], finer ? "192" : "24");
        EXPECT_EQ(rows[2 + finer][0], "\"finest linear\"");
        EXPECT_EQ(rows[2 + finer][7], "192") << "the scene's budget does not stop the finest level";
        for (std::size_t i = 2; i < rows.size(); ++i) {
            EXPECT_GT(std::stod(rows[i][5]), 0);
            EXPECT_GE(std::stod(rows[i][9]), std::stod(rows[i][8]));
            if (rows[i][3] == "40") {
                EXPECT_LE(std::stod(rows[i][7]), 40);
            }
        }
        pugi::xml_document svg;
        ASSERT_TRUE(svg.load_file((directory + "/study.svg").c_str()));
        EXPECT_STREQ(svg.child("svg").child("title").text().get(), "Speed against error: beam");
        EXPECT_EQ(svg.select_nodes("//polyline").size(), 4U) << "a line for each order and budget";
    }
}

TEST_F(Program, TheFinestFrontAgainstItselfHasNoError) {
    const auto result = run({"run", scene_, "--steps", "3", "--report", path("out.json"), "--compare", "finest",
                             "--set", "front.order=1", "--set", "front.min_level=1"});
    EXPECT_EQ(result.status, 0) << result.err;
    EXPECT_EQ(read_json(path("out.json"))["summary"]["compare"]["finest"]["error_max"], 0);
}

TEST_F(Program, OutputThatCannotBeWrittenIsStatus4) {
    expect_refusal(run({"run", scene_, "--steps", "1", "--report", path("none/out.json")}), 4, "out.json");
    expect_refusal(run({"run", scene_, "--steps", "1", "--report", folder_.path().string()}), 4, "cannot be written");
    expect_refusal(run({"study", scene_, "--out", scene_}), 4, "beam.json");
    std::filesystem::create_directories(path("taken/study.svg"));
    expect_refusal(run({"study", scene_, "--out", path("taken")}), 4, "study.svg");
    ChildProcess full({program_path(), "info", scene_}, "/dev/full");
    EXPECT_EQ(full.wait().status, 4);
}

TEST_F(Program, ServePrintsOneUrlAndEndsWell) {
    for (const int signal : {SIGTERM, SIGINT}) {
        ChildProcess serve({program_path(), "serve", scene_, "--port", "0", "--web", web_});
        const std::string url = serve.read_line();
        EXPECT_EQ(url.substr(0, 17), "http://127.0.0.1:") << url;
        EXPECT_TRUE(url.ends_with("/"));
        serve.signal(signal);
        const auto result = serve.wait();
        EXPECT_EQ(result.status, 0) << result.err;
        EXPECT_EQ(result.out, "") << "nothing after the URL";
    }
}

TEST_F(Program, ATakenPortIsStatus3) {
    ChildProcess first({program_path(), "serve", scene_, "--port", "0", "--web", web_});
    const std::string url = first.read_line(), port = url.substr(17, url.size() - 18);
    expect_refusal(run({"serve", scene_, "--port", port, "--web", web_}), 3, port);
    first.signal(SIGTERM);
    EXPECT_EQ(first.wait().status, 0);
}

TEST_F(Program, ServeEndsWithStatus2WhenTheModelCannotBeBuilt) {
    folder_.write("lost.json", R"({"schema_version": 1, "mesh": {"surface": {"file": "lost.obj"}}})");
    const auto result = run({"serve", path("lost.json"), "--port", "0", "--web", web_});
    EXPECT_EQ(result.status, 2);
    EXPECT_NE(result.err.find("lost.obj"), std::string::npos) << result.err;
}

}  // namespace
}  // namespace tetfront
