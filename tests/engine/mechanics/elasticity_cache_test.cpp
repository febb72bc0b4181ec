#include "engine/mechanics/elasticity_cache.hpp"

#include "tests/support/temporary_folder.hpp"

#include <fstream>
#include <thread>

#include <gtest/gtest.h>

namespace tetfront {
namespace {

namespace fs = std::filesystem;

class ElasticityCache : public testing::Test {
 protected:
    ElasticityCache() { settings_.sampling.emplace(); }

    CoarseMaterials get(double young = 1e6) {
        return coarse_materials(tree_, function(young), settings_,
                                {directory_, [this](const std::string& line) { warnings_.push_back(line); }});
    }
    static StiffnessFunction function(double young) {
        return StiffnessFunction(layers(0, {0.4}),
                                 {{.young = constant(1e4), .mass_damping = constant(0.5)},
                                  {.young = gradient(1, {0, 1}, {1e5, young}, Interpolation::linear)}});
    }
    fs::path file() { return cache_file(tree_, function(1e6), settings_, directory_); }
    std::string content() {
        std::ifstream in(file(), std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    void replace(const std::string& bytes) { std::ofstream(file(), std::ios::binary | std::ios::trunc) << bytes; }
    static void expect_same(const CoarseMaterials& a, const CoarseMaterials& b) {
        EXPECT_EQ(a.matrices.elasticity, b.matrices.elasticity);
        EXPECT_EQ(a.matrices.bracket, b.matrices.bracket);
        EXPECT_EQ(a.matrices.valid_range, b.matrices.valid_range);
        EXPECT_EQ(a.matrices.mass_damping, b.matrices.mass_damping);
        EXPECT_EQ(a.matrices.stiffness_damping, b.matrices.stiffness_damping);
        EXPECT_EQ(a.density, b.density);
        ASSERT_EQ(a.matrices.report.size(), b.matrices.report.size());
        for (std::size_t i = 0; i < a.matrices.report.size(); ++i)
            EXPECT_EQ(a.matrices.report[i].finite_ranges, b.matrices.report[i].finite_ranges);
    }

    TetTree tree_{box_mesh({0, 0, 0}, {1, 1, 1}, {1, 1, 1}), 2};
    EstimationSettings settings_;
    TemporaryFolder folder_;
    fs::path directory_ = folder_.path() / "cache";
    std::vector<std::string> warnings_;
};

TEST_F(ElasticityCache, SecondTimeComesFromTheFileAndIsTheSame) {
    const CoarseMaterials first = get(), second = get();
    EXPECT_FALSE(first.from_cache);
    EXPECT_TRUE(second.from_cache);
    EXPECT_FALSE(first.matrices.valid_range.empty());
    expect_same(first, second);
    EXPECT_TRUE(warnings_.empty());
    EXPECT_EQ(std::distance(fs::directory_iterator(directory_), {}), 1);  // no temporary file is left
}

TEST_F(ElasticityCache, AnythingThatMattersChangesTheKey) {
    get();
    EXPECT_FALSE(get(2e6).from_cache);
    settings_.sampling->relative_tolerance = 2e-2;
    EXPECT_FALSE(get().from_cache);
    settings_ = {CellProblem::average, {}};
    EXPECT_FALSE(get().from_cache);
    const fs::path before = file();
    tree_ = TetTree(box_mesh({0, 0, 0}, {1, 1, 1.0000001}, {1, 1, 1}), 2);
    EXPECT_NE(file(), before);
    const fs::path other = file();
    tree_ = TetTree(box_mesh({0, 0, 0}, {1, 1, 1.0000001}, {1, 1, 1}), 1);
    EXPECT_NE(file(), other);
}

TEST_F(ElasticityCache, DamagedFilesAreReportedOnceAndReplaced) {
    const CoarseMaterials first = get();
    const std::string good = content();
    std::string flipped = good, older = good, foreign = good;
    flipped[good.size() / 2] ^= 1;
    older[8] ^= 3;
    foreign[16] ^= 1;
    int expected = 0;
    for (const std::string& bad :
         {good.substr(0, good.size() / 2), good.substr(0, 10), good + "x", std::string(),
          std::string("hello, this is no cache file, but long enough for a header"), flipped, older, foreign}) {
        replace(bad);
        const CoarseMaterials again = get();
        EXPECT_FALSE(again.from_cache);
        expect_same(first, again);
        EXPECT_EQ(static_cast<int>(warnings_.size()), ++expected);
        EXPECT_NE(warnings_.back().find(file().string()), std::string::npos);
        EXPECT_TRUE(get().from_cache);
        EXPECT_EQ(static_cast<int>(warnings_.size()), expected);
    }
}

TEST_F(ElasticityCache, DirectoryThatCannotBeMadeIsReportedAndDoneWithout) {
    std::ofstream(directory_) << "a file where the directory should be";
    const CoarseMaterials m = get();
    EXPECT_EQ(m.matrices.elasticity.size(), tree_.tet_count());
    EXPECT_EQ(warnings_.size(), 2U);  // it could neither be read nor written
    fs::remove(directory_);
}

TEST_F(ElasticityCache, NoDirectoryNoFiles) {
    directory_.clear();
    EXPECT_FALSE(get().from_cache);
    EXPECT_FALSE(get().from_cache);
    EXPECT_TRUE(warnings_.empty());
}

TEST_F(ElasticityCache, ManyAtOnceAllSucceed) {
    const CoarseMaterials expected = coarse_materials(tree_, function(1e6), settings_, {});
    std::array<CoarseMaterials, 4> results;
    {
        std::vector<std::jthread> threads;
        for (CoarseMaterials& r : results)
            threads.emplace_back([&] { r = coarse_materials(tree_, function(1e6), settings_, {directory_, {}}); });
    }
    for (const CoarseMaterials& r : results) expect_same(r, expected);
    EXPECT_TRUE(get().from_cache);
    EXPECT_EQ(std::distance(fs::directory_iterator(directory_), {}), 1);
}

}  // namespace
}  // namespace tetfront
