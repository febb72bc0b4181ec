// Folders are floors: a file includes only what lies on strictly lower floors, or in its own folder without going round
// in a circle. Libraries that belong to one floor stay there. Held against every file of engine/ and server/.

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/project.hpp"

namespace tetfront {
namespace {

const std::map<std::string, int> floors = {
    {"engine/base", 1},      {"engine/mesh", 2},  {"engine/material", 3},   {"engine/tree", 3},
    {"engine/mechanics", 4}, {"engine/scene", 4}, {"engine/simulation", 5}, {"server/base", 5}, {"server/session", 6},
    {"server/render", 7},    {"server/net", 8},   {"server/cli", 9},
};

/// Headers that begin so may be included below this path only.
const std::vector<std::pair<std::string, std::string>> homes = {
    {"boost/", "server/net/"},   {"sys/socket.h", "server/net/"}, {"netinet/", "server/net/"},
    {"arpa/", "server/net/"},    {"netdb.h", "server/net/"},      {"GL/", "server/render/"},
    {"png.h", "server/render/"}, {"CLI/", "server/cli/"},         {"ft2build.h", "server/render/"},
    {"spdlog/", "server/"},      {"assimp/", "engine/mesh/"},
    {"meshoptimizer.h", "server/"},     {"tbb/", "engine/"},
};

using Files = std::map<std::string, std::string>;  // path from the repository's root -> text

std::vector<std::string> includes_of(const std::string& text) {
    static const std::regex directive("^[ \t]*#[ \t]*include[ \t]*[<\"]([^>\"]+)[>\"]");
    std::vector<std::string> found;
    std::istringstream lines(text);
    std::smatch match;
    for (std::string line; std::getline(lines, line);) {
        if (std::regex_search(line, match, directive)) found.push_back(match[1]);
    }
    return found;
}

bool starts_with(const std::string& text, const std::string& prefix) { return text.rfind(prefix, 0) == 0; }
bool is_ours(const std::string& path) { return starts_with(path, "engine/") || starts_with(path, "server/"); }
std::string folder_of(const std::string& path) { return path.substr(0, path.find('/', path.find('/') + 1)); }
/// A header and its source are one unit: x.hpp and x.cpp.
std::string unit_of(const std::string& path) { return path.substr(0, path.rfind('.')); }

std::string include_violation(const std::string& file, const std::string& included) {
    const std::string does = file + " includes " + included;
    for (const auto& [prefix, home] : homes) {
        if (starts_with(included, prefix) && !starts_with(file, home)) return does + ", which belongs to " + home;
    }
    if (starts_with(included, ".") || included.find("/../") != std::string::npos) return does + " by a relative path";
    if (!is_ours(included)) return "";
    const auto from = floors.find(folder_of(file));
    const auto to = floors.find(folder_of(included));
    if (to == floors.end()) return does + ", which is on no known floor";
    if (from->first == to->first || from->second > to->second) return "";
    return does + ": floor " + std::to_string(from->second) + " on floor " + std::to_string(to->second);
}

using Graph = std::map<std::string, std::set<std::string>>;  // unit -> units of the same folder that it includes

/// Depth first; `path` is how we came here. Adds one line for each circle that the search closes.
void find_circles(const Graph& graph, const std::string& unit, std::vector<std::string>& path,
                  std::set<std::string>& done, std::vector<std::string>& found) {
    if (const auto at = std::find(path.begin(), path.end(), unit); at != path.end()) {
        std::string circle;
        for (auto i = at; i != path.end(); ++i) circle += *i + " -> ";
        found.push_back("circle: " + circle + unit);
        return;
    }
    if (!done.insert(unit).second) return;
    path.push_back(unit);
    if (const auto next = graph.find(unit); next != graph.end()) {
        for (const std::string& other : next->second) find_circles(graph, other, path, done, found);
    }
    path.pop_back();
}

/// One line for each breach.
std::vector<std::string> violations(const Files& files) {
    std::vector<std::string> found;
    Graph graph;
    for (const auto& [file, text] : files) {
        if (!floors.contains(folder_of(file))) {
            found.push_back(file + " is on no known floor");
            continue;
        }
        for (const std::string& included : includes_of(text)) {
            if (std::string line = include_violation(file, included); !line.empty()) found.push_back(line);
            if (is_ours(included) && folder_of(included) == folder_of(file) && unit_of(included) != unit_of(file)) {
                graph[unit_of(file)].insert(unit_of(included));
            }
        }
    }
    std::set<std::string> done;
    for (const auto& [unit, ignored] : graph) {
        std::vector<std::string> path;
        find_circles(graph, unit, path, done, found);
    }
    return found;
}

Files source_files() {
    const std::filesystem::path root = source_folder();
    Files files;
    for (const char* top : {"engine", "server"}) {
        for (const auto& entry : std::filesystem::recursive_directory_iterator(root / top)) {
            const std::string extension = entry.path().extension().string();
            if (extension != ".cpp" && extension != ".hpp") continue;
            std::ifstream stream(entry.path());
            files[entry.path().lexically_relative(root).generic_string()] =
                std::string(std::istreambuf_iterator<char>(stream), {});
        }
    }
    return files;
}

TEST(Layers, EveryFileKeepsToItsFloor) {
    const Files files = source_files();
    EXPECT_GT(files.size(), 40U);
    std::size_t includes = 0;
    for (const auto& [file, text] : files) includes += includes_of(text).size();
    EXPECT_GT(includes, 4 * files.size()) << "the check does not see the includes";
    for (const std::string& line : violations(files)) ADD_FAILURE() << line;
}

/// The machine's clock jumps when somebody sets it; only what names a moment for people may ask for it.
TEST(Layers, NothingIsTimedByAClockThatJumps) {
    const std::set<std::string> names_a_moment = {"server/session/session_commands.cpp", "server/cli/report_head.hpp", "server/cli/bench_report.cpp"};
    const std::regex jumping("system_clock|high_resolution_clock|CLOCK_REALTIME|gettimeofday|std::time\\(|system_timer|expires_from_now");
    std::set<std::string> found;
    for (const auto& [file, text] : source_files())
        if (std::regex_search(text, jumping)) found.insert(file);
    EXPECT_EQ(found, names_a_moment) << "use steady_clock";
}

TEST(Layers, LowerFloorsAndTheOwnFolderAreAllowed) {
    EXPECT_TRUE(
        violations({{"engine/tree/front.cpp",
                     "#include \"engine/tree/front.hpp\"\n#include <vector>\n#include \"engine/base/types.hpp\"\n"},
                    {"engine/tree/front.hpp", "#include \"engine/tree/tet_tree.hpp\"\n"},
                    {"engine/tree/tet_tree.hpp", "// #include \"engine/tree/front.hpp\"\n"},
                    {"server/net/server.cpp", "#include <boost/asio.hpp>\n"}})
            .empty());
}

TEST(Layers, PlantedFaultsAreFound) {
    const std::vector<std::pair<Files, std::string>> faults = {
        {{{"engine/tree/a.cpp", "#include \"engine/mechanics/b.hpp\"\n"}},
         "engine/tree/a.cpp includes engine/mechanics/b.hpp: floor 3 on floor 4"},
        {{{"engine/scene/a.cpp", "  #  include <engine/mechanics/b.hpp>\n"}},
         "engine/scene/a.cpp includes engine/mechanics/b.hpp: floor 4 on floor 4"},
        {{{"engine/simulation/a.hpp", "#include \"server/session/b.hpp\"\n"}},
         "engine/simulation/a.hpp includes server/session/b.hpp: floor 5 on floor 6"},
        {{{"server/render/a.hpp", "#include \"server/net/b.hpp\"\n"}},
         "server/render/a.hpp includes server/net/b.hpp: floor 7 on floor 8"},
        {{{"server/cli/a.cpp", "#include <boost/asio.hpp>\n"}},
         "server/cli/a.cpp includes boost/asio.hpp, which belongs to server/net/"},
        {{{"engine/base/a.cpp", "#include <GL/osmesa.h>\n"}},
         "engine/base/a.cpp includes GL/osmesa.h, which belongs to server/render/"},
        {{{"engine/base/a.cpp", "#include \"../mesh/b.hpp\"\n"}},
         "engine/base/a.cpp includes ../mesh/b.hpp by a relative path"},
        {{{"engine/base/a.cpp", "#include \"engine/attic/b.hpp\"\n"}},
         "engine/base/a.cpp includes engine/attic/b.hpp, which is on no known floor"},
        {{{"engine/attic/a.cpp", ""}}, "engine/attic/a.cpp is on no known floor"},
        {{{"engine/a.cpp", ""}}, "engine/a.cpp is on no known floor"},
        {{{"engine/tree/a.hpp", "#include \"engine/tree/b.hpp\"\n"},
          {"engine/tree/b.cpp", "#include \"engine/tree/c.hpp\"\n"},
          {"engine/tree/c.hpp", "#include \"engine/tree/a.hpp\"\n"}},
         "circle: engine/tree/a -> engine/tree/b -> engine/tree/c -> engine/tree/a"},
    };
    for (const auto& [files, expected] : faults) EXPECT_EQ(violations(files), std::vector<std::string>{expected});
}

}  // namespace
}  // namespace tetfront
