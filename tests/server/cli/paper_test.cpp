// `tetfront paper`, by its figure that needs no simulation.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <pugixml.hpp>

#include "tests/support/child_process.hpp"
#include "tests/support/project.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tetfront {
namespace {

ChildProcess::Result paper(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {program_path(), "paper"});
    return ChildProcess(arguments).wait();
}

std::string text_of(const std::filesystem::path& file) {
    std::stringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
}

TEST(Paper, WritesAPageThatSetsStatementsBesideNumbers) {
    const TemporaryFolder folder;
    const std::filesystem::path out = folder.path() / "paper";
    const auto result = paper({"--figures", "3", "--out", out.string()});
    ASSERT_EQ(result.status, 0) << result.err;
    const std::string page = text_of(out / "paper.md");
    EXPECT_NE(page.find("## Figure 3"), std::string::npos);
    EXPECT_EQ(page.find("## Figure 6"), std::string::npos) << "only what was asked for";
    EXPECT_NE(page.find("| the paper says | here | what differs, and why |"), std::string::npos);
    EXPECT_NE(page.find("--figures 3"), std::string::npos) << "the command that makes it again";
    EXPECT_NE(page.find("](paper_3.svg)"), std::string::npos);
    EXPECT_TRUE(pugi::xml_document().load_file((out / "paper_3.svg").c_str()));

    // The samples: as many on both sides, stress 0 between them, and the paper's reading softer than ours.
    std::ifstream csv(out / "paper_3.csv");
    std::string line;
    std::getline(csv, line);
    EXPECT_EQ(line, "problem,alpha,stress_xx_Pa,fitted_xx_Pa");
    double slopes[2] = {0, 0};
    int rows[2] = {0, 0};
    while (std::getline(csv, line)) {
        const int ours = line.starts_with("mean_strain,");
        double alpha = 0, stress = 0, fitted = 0;
        ASSERT_EQ(std::sscanf(line.substr(line.find(',') + 1).c_str(), "%lf,%lf,%lf", &alpha, &stress, &fitted), 3) << line;
        EXPECT_GT(stress * alpha, 0) << line;
        slopes[ours] = fitted / alpha;
        ++rows[ours];
        if (std::abs(alpha) < 0.05) EXPECT_NEAR(stress / fitted, 1, 0.05) << line;
    }
    EXPECT_GE(rows[0], 16);
    EXPECT_GE(rows[1], 16);
    EXPECT_LT(slopes[0], 0.9 * slopes[1]);
}

TEST(Paper, RefusesBeforeItWritesAnything) {
    const TemporaryFolder folder;
    const std::filesystem::path out = folder.path() / "paper";
    const auto unknown = paper({"--figures", "3,5", "--out", out.string()});
    EXPECT_EQ(unknown.status, 2);
    EXPECT_NE(unknown.err.find("figures"), std::string::npos) << unknown.err;
    folder.write("armadillo.json", R"({"schema_version": 1, "mesh": {"surface": {"file": "armadillo.off"}}})");
    const auto missing = paper({"--figures", "12", "--scenes", folder.path().string(), "--out", out.string()});
    EXPECT_EQ(missing.status, 2);
    EXPECT_NE(missing.err.find("assets/fetch armadillo"), std::string::npos) << missing.err;
    EXPECT_FALSE(std::filesystem::exists(out));
}

}  // namespace
}  // namespace tetfront
