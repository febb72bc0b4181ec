#include "server/render/sequence.hpp"

#include "engine/base/error.hpp"
#include "server/render/bounded_queue.hpp"
#include "tests/support/blob_frame.hpp"
#include "tests/support/pictures.hpp"
#include "tests/support/temporary_folder.hpp"

#include <algorithm>
#include <set>
#include <thread>

#include <gtest/gtest.h>

namespace tetfront {
namespace {

TEST(BoundedQueue, HandsOverInOrderAndEnds) {
    BoundedQueue<int> queue(2);
    std::jthread producer([&queue] {
        for (int i = 0; i < 1000; ++i) queue.push(i);
        queue.close();
    });
    for (int expected = 0; expected < 1000; ++expected) ASSERT_EQ(queue.pop(), expected);
    EXPECT_EQ(queue.pop(), std::nullopt);
    EXPECT_FALSE(queue.push(1)) << "closed";
}

TEST(BoundedQueue, ClosingWakesWhoWaits) {
    BoundedQueue<int> full(1), empty(1);
    full.push(1);
    bool pushed = true;
    std::optional<int> popped = 1;
    {
        std::jthread producer([&] { pushed = full.push(2); });
        std::jthread consumer([&] { popped = empty.pop(); });
        full.close(), empty.close();
    }
    EXPECT_FALSE(pushed);
    EXPECT_EQ(popped, std::nullopt);
    EXPECT_EQ(full.pop(), 1) << "what was in it can still be taken";
}

TEST(SequenceSteps, NeverDrift) {
    for (const int index : {0, 1, 7, 100, 99'999, 1'000'000})
        EXPECT_EQ(steps_until_frame(index, 30, 0, 1.0 / 60), 2LL * index);
    EXPECT_EQ(steps_until_frame(0, 30, 2.5, 1.0 / 60), 150);
    // 2.5 steps a frame: never more than half a step off, and no frame is skipped.
    for (int index = 0; index < 1000; ++index) {
        EXPECT_NEAR(static_cast<double>(steps_until_frame(index, 24, 0, 1.0 / 60)), 2.5 * index, 0.5 + 1e-9);
        EXPECT_GT(steps_until_frame(index + 1, 24, 0, 1.0 / 60), steps_until_frame(index, 24, 0, 1.0 / 60));
    }
    EXPECT_EQ(steps_until_frame(10, 1000, 0, 0.1), 0) << "faster than the simulation: frames repeat";
}

class Sequence : public testing::Test {
 protected:
    Sequence() {
        options_.frames = 5;
        options_.directory = folder_.path() / "out";
        options_.view = make_view(ViewSpec{}, *frame_->model, 96, 64);
        options_.view.legend = false;
        options_.text = {{"Software", "test"}};
    }
    /// Frame k is the lump lifted by k millimetres... enough to tell the pictures apart.
    [[nodiscard]] std::shared_ptr<const Frame> lifted(int index) const {
        auto frame = std::make_shared<Frame>(*frame_);
        for (auto& p : frame->surface) p[2] += 0.03F * static_cast<float>(index);
        frame->status.time = index / 30.0;
        return frame;
    }
    [[nodiscard]] std::vector<std::string> files() const {
        std::vector<std::string> names;
        for (const auto& entry : std::filesystem::directory_iterator(options_.directory))
            names.push_back(entry.path().filename().string());
        std::ranges::sort(names);
        return names;
    }
    static bool go_on(int) { return true; }

    TemporaryFolder folder_;
    std::shared_ptr<Frame> frame_ = blob_frame(8);
    SequenceOptions options_;
};

TEST_F(Sequence, WritesEveryFrameInOrder) {
    std::vector<int> asked, written;
    const SequenceReport report = render_sequence(
        options_,
        [&](int index) {
            asked.push_back(index);
            return lifted(index);
        },
        [&](int count) {
            written.push_back(count);
            EXPECT_TRUE(std::filesystem::exists(options_.directory / frame_name(count - 1)));
            return true;
        });
    EXPECT_EQ(asked, (std::vector<int>{0, 1, 2, 3, 4}));
    EXPECT_EQ(written, (std::vector<int>{1, 2, 3, 4, 5}));
    EXPECT_EQ(report.written, 5);
    EXPECT_GT(report.render, 0);
    EXPECT_EQ(files(),
              (std::vector<std::string>{"000000.png", "000001.png", "000002.png", "000003.png", "000004.png"}));
    std::set<std::vector<std::uint8_t>> different;
    for (const std::string& name : files()) {
        const Image image = read_png(options_.directory / name);
        EXPECT_EQ(image.width, 96);
        EXPECT_EQ(image.height, 64);
        different.insert(image.pixels);
    }
    EXPECT_EQ(different.size(), 5U);
}

TEST_F(Sequence, SameBytesTwice) {
    const auto bytes = [&] {
        std::vector<std::string> all;
        render_sequence(
            options_, [&](int index) { return lifted(index); }, go_on);
        for (const std::string& name : files()) {
            std::ifstream in(options_.directory / name, std::ios::binary);
            all.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
        }
        return all;
    };
    const auto first = bytes();
    std::filesystem::remove_all(options_.directory);
    EXPECT_EQ(first, bytes());
    EXPECT_NE(first[3].find(std::string("Frame\0003", 7)), std::string::npos);
    EXPECT_NE(first[3].find(std::string("Time\0000.100000", 13)), std::string::npos);
}

TEST_F(Sequence, TurntableTurnsTheCamera) {
    options_.frames = 4;
    const auto still = [&](int) { return lifted(0); };
    render_sequence(options_, still, go_on);
    EXPECT_EQ(read_png(options_.directory / "000000.png").pixels, read_png(options_.directory / "000002.png").pixels);
    options_.turntable = true;
    render_sequence(options_, still, go_on);
    EXPECT_NE(read_png(options_.directory / "000000.png").pixels, read_png(options_.directory / "000002.png").pixels);
}

TEST_F(Sequence, EndsEarlyWithWholeFiles) {
    options_.frames = 1000;
    const SequenceReport report = render_sequence(
        options_, [&](int index) { return lifted(index); }, [](int written) { return written < 3; });
    EXPECT_GE(report.written, 3);
    EXPECT_LT(report.written, 20);
    ASSERT_EQ(static_cast<int>(files().size()), report.written);
    for (int i = 0; i < report.written; ++i) EXPECT_EQ(read_png(options_.directory / frame_name(i)).width, 96);
}

TEST_F(Sequence, PassesOnWhatGoesWrong) {
    const auto fails = [&](int index) {
        if (index == 2) throw std::runtime_error("the simulation fell over");
        return lifted(index);
    };
    EXPECT_THROW(render_sequence(options_, fails, go_on), std::runtime_error);
    for (const std::string& name : files()) EXPECT_NO_THROW(read_png(options_.directory / name));

    const auto no_file = [&](int index) {  // a directory where the third file should go
        std::filesystem::create_directories(options_.directory / "000002.png");
        return lifted(index);
    };
    EXPECT_THROW(render_sequence(options_, no_file, go_on), OutputError);

    const auto broken = [&](int) {
        auto frame = std::make_shared<Frame>(*frame_);
        frame->surface.pop_back();
        return frame;
    };
    EXPECT_THROW(render_sequence(options_, broken, go_on), LogicError);

    const auto progress_fails = [](int) -> bool { throw std::runtime_error("broken pipe"); };
    options_.directory = folder_.path() / "other";
    EXPECT_THROW(render_sequence(
                     options_, [&](int i) { return lifted(i); }, progress_fails),
                 std::runtime_error);

    options_.view.width = 3;
    EXPECT_THROW(render_sequence(options_, fails, go_on), InputError);
}

}  // namespace
}  // namespace tetfront
