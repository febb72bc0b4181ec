#include "server/session/session.hpp"

#include "engine/base/error.hpp"
#include "tests/support/blob_frame.hpp"
#include "tests/support/box_scene.hpp"
#include "tests/support/temporary_folder.hpp"

#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <filesystem>
#include <functional>
#include <future>
#include <mutex>
#include <numeric>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace tetfront {
namespace {

using namespace std::chrono_literals;

/// A session whose events can be waited for.
class TestSession {
 public:
    explicit TestSession(bool playing, Scene scene = box_scene()) : session(std::move(scene), playing) { start(); }
    TestSession(bool playing, Recording recording) : session(std::move(recording), playing) { start(); }
    void start() {
        session.start({.progress = [this](const std::string& what, double) { note([&] { stages.push_back(what); }); },
                       .model = [this](auto m) { note([&] { model = m; }); },
                       .frame =
                           [this](const Shots& shots) {
                               note([&] {
                                   frame = shots.frame;
                                   ++frames;
                               });
                           },
                       .state = [this](const SessionState& s) { note([&] { state = s; }); },
                       .build_failed = [this](std::exception_ptr e) { note([&] { build_error = e; }); }});
    }
    ~TestSession() { session.stop(); }

    /// Waits until the condition holds for the events so far; false after 60 s.
    bool wait(const std::function<bool()>& condition) {
        std::unique_lock lock(mutex_);
        return changed_.wait_for(lock, 60s, condition);
    }
    std::optional<CommandError> send(Command command, ClientId client = 1) {
        std::promise<std::optional<CommandError>> answer;
        session.submit(client, std::move(command), [&](const auto& error) { answer.set_value(error); });
        return answer.get_future().get();
    }
    /// What a reader of the events sees, without waiting.
    template <class Read>
    auto look(const Read& read) {
        const std::lock_guard lock(mutex_);
        return read();
    }

    std::vector<std::string> stages;
    std::shared_ptr<const SessionModel> model;
    std::shared_ptr<const Frame> frame;
    SessionState state;
    int frames = 0;
    std::exception_ptr build_error;

 private:
    void note(const std::function<void()>& change) {
        const std::lock_guard lock(mutex_);
        change();
        changed_.notify_all();
    }
    std::mutex mutex_;
    std::condition_variable changed_;

 public:
    Session session;  // last: its thread ends before the rest goes
};

command::PullBegin pull_up(std::uint32_t number) { return {number, SurfacePoint{}, Vec3(0, 0, 1.25)}; }

TEST(Session, PausedShowsTheRestStateAndSteps) {
    TestSession s(false);
    ASSERT_TRUE(s.wait([&] { return s.model && s.frame && !s.state.tets_by_level.empty(); }));
    EXPECT_FALSE(s.look([&] { return s.state.playing; }));
    EXPECT_EQ(s.look([&] { return s.frame->status.step; }), 0U);
    EXPECT_FALSE(s.send(command::Step{7}));
    ASSERT_TRUE(s.wait([&] { return s.state.status.step == 7; }));
    EXPECT_EQ(s.look([&] { return s.frame->status.step; }), 7U)
        << "a state never speaks of a moment that no frame showed";
}

TEST(Session, PausedWithoutCommandsDoesNothing) {
    TestSession s(false);
    ASSERT_TRUE(s.wait([&] { return s.frame && !s.state.tets_by_level.empty(); }));
    const int frames = s.look([&] { return s.frames; });
    std::this_thread::sleep_for(150ms);
    EXPECT_EQ(s.look([&] { return s.frames; }), frames);
}

TEST(Session, PlaysPausesAndResets) {
    TestSession s(true);
    ASSERT_TRUE(s.wait([&] { return s.frame && s.frame->status.step > 3; }));
    EXPECT_FALSE(s.send(command::Pause{}));
    ASSERT_TRUE(s.wait([&] { return !s.state.playing; }));
    EXPECT_FALSE(s.send(command::Reset{}));
    ASSERT_TRUE(s.wait([&] { return s.state.status.step == 0; }));
    EXPECT_FALSE(s.look([&] { return s.state.playing; }));
    EXPECT_FALSE(s.send(command::Play{}));
    EXPECT_FALSE(s.send(command::Reset{}));
    ASSERT_TRUE(s.wait([&] { return s.state.playing && s.state.status.step > 3; })) << "what plays goes on playing";
}

TEST(Session, RefusesToStepWhilePlaying) {
    TestSession s(true);
    const auto error = s.send(command::Step{1});
    ASSERT_TRUE(error);
    EXPECT_EQ(error->code, "failed");
}

TEST(Session, ReportsTheRateThatItReaches) {
    TestSession s(true);
    ASSERT_TRUE(s.wait([&] { return s.state.steps_per_second > 0; }));
    EXPECT_FALSE(s.send(command::Pause{}));
    ASSERT_TRUE(s.wait([&] { return !s.state.playing; }));
    EXPECT_EQ(s.look([&] { return s.state.steps_per_second; }), 0);
}

TEST(Session, SpeedScalesSimulatedTime) {
    Scene scene = box_scene();
    scene.time_step = 1;  // at speed 0.01 the next step is 100 s away
    TestSession s(true, scene);
    EXPECT_FALSE(s.send(command::Speed{0.01}));
    ASSERT_TRUE(s.wait([&] { return s.state.speed == 0.01 && s.state.status.step >= 1; }));
    const auto step = s.look([&] { return s.state.status.step; });
    EXPECT_FALSE(s.send(command::Tolerance{0.5}));
    EXPECT_LE(s.look([&] { return s.state.status.step; }), step + 1);
    EXPECT_FALSE(s.send(command::Speed{10}));
    ASSERT_TRUE(s.wait([&] { return s.state.status.step > step + 3; }));
}

TEST(Session, SettingsReachTheSimulationAndSurviveAReset) {
    TestSession s(false);
    EXPECT_FALSE(s.send(command::Gravity{{0, 1, 0}}));
    EXPECT_FALSE(s.send(command::Tolerance{0.125}));
    EXPECT_FALSE(s.send(command::Levels{0, 0}));
    EXPECT_FALSE(s.send(command::Reset{}));
    EXPECT_FALSE(s.send(command::Step{10}));
    ASSERT_TRUE(s.wait([&] { return s.state.status.step == 10; }));
    EXPECT_EQ(s.state.gravity, Vec3(0, 1, 0));
    EXPECT_EQ(s.state.status.tolerance, 0.125);
    EXPECT_EQ(s.state.levels.max, 0);
    EXPECT_EQ(std::accumulate(s.state.tets_by_level.begin() + 1, s.state.tets_by_level.end(), 0U), 0U);
    float most = 0;
    for (const auto& p : s.frame->surface) most = std::max(most, p[1]);
    EXPECT_GT(most, 1.001F) << "the beam falls sideways";
}

TEST(Session, TheStateHasTheForcesOfTheSceneAlone) {
    Scene scene = box_scene();
    scene.forces = {{.region = Box{{3.9, -1, -1}, {4.1, 2, 2}}, .force = {0, 0, -25}, .end = 0.1}};
    TestSession s(false, scene);
    EXPECT_FALSE(s.send(command::ForceAdd{.force = 1, .point = {0, Vec3(1, 0, 0)}, .value = {1, 2, 3}}));
    EXPECT_FALSE(s.send(command::Step{1}));
    ASSERT_TRUE(s.wait([&] { return s.state.status.step == 1; }));
    ASSERT_EQ(s.state.scene_forces.size(), 1U);
    EXPECT_NEAR(s.state.scene_forces[0].at[0], 4, 0.1);
    EXPECT_EQ(s.state.scene_forces[0].value[2], -25);
    EXPECT_FALSE(s.send(command::Step{20}));
    ASSERT_TRUE(s.wait([&] { return s.state.status.step == 21; }));
    EXPECT_TRUE(s.state.scene_forces.empty()) << "over";
    EXPECT_FALSE(s.state.failed);
}

TEST(Session, ABudgetActsLiveAndSurvivesAReset) {
    Scene scene = box_scene();
    scene.levels = 3;
    TestSession s(false, scene);
    ASSERT_TRUE(s.wait([&] { return s.frame != nullptr; }));
    const auto tets_after = [&](std::uint64_t step) {
        EXPECT_FALSE(s.send(command::Step{10}));
        EXPECT_TRUE(s.wait([&] { return s.state.status.step == step; }));
        return s.look([&] { return std::accumulate(s.state.tets_by_level.begin(), s.state.tets_by_level.end(), 0U); });
    };
    EXPECT_FALSE(s.send(command::Tolerance{1e-6}));
    EXPECT_FALSE(s.send(command::Budget{.tets = 60}));
    const unsigned limited = tets_after(10);
    EXPECT_LE(limited, 60U);
    EXPECT_GT(limited, 24U);
    EXPECT_FALSE(s.send(command::Reset{}));
    EXPECT_LE(tets_after(10), 60U);
    EXPECT_FALSE(s.send(command::Budget{}));
    EXPECT_GT(tets_after(20), 60U);
}

TEST(Session, PullsBelongToTheirClientAndEndWithIt) {
    TestSession s(false);
    EXPECT_FALSE(s.send(pull_up(1), 1));
    EXPECT_FALSE(s.send(pull_up(1), 2));
    ASSERT_TRUE(s.wait([&] { return s.frame && s.frame->pulls.size() == 2; }));
    EXPECT_FALSE(s.send(command::PullMove{1, Vec3(0, 0, 1.5)}, 2));
    ASSERT_TRUE(s.wait([&] {
        const auto& pulls = s.frame->pulls;
        return pulls.size() == 2 && std::abs(pulls[0].to[2] - pulls[1].to[2]) > 0.2F;
    }));
    EXPECT_FALSE(s.send(command::PullEnd{1}, 3)) << "of a client that has none: nothing";
    s.session.disconnect(1);
    ASSERT_TRUE(s.wait([&] { return s.frame->pulls.size() == 1; }));
    EXPECT_EQ(s.look([&] { return s.frame->pulls[0].to[2]; }), 1.5F);
    EXPECT_FALSE(s.send(command::PullEnd{1}, 2));
    ASSERT_TRUE(s.wait([&] { return s.frame->pulls.empty(); }));
}

TEST(Session, RefusesTrianglesThatAreNotThereAndTooManyPulls) {
    TestSession s(false);
    auto pull = pull_up(1);
    pull.point.triangle = 1'000'000;
    auto error = s.send(pull);
    ASSERT_TRUE(error);
    const auto last = std::to_string(s.look([&] { return s.model->frame_model->triangles.size(); }) - 1);
    EXPECT_EQ(*error, (CommandError{"out_of_range", "/triangle", "is 1000000; use 0.." + last}));
    for (std::uint32_t i = 0; i < Session::max_client_pulls; ++i) EXPECT_FALSE(s.send(pull_up(i)));
    EXPECT_FALSE(s.send(pull_up(0))) << "grabbing anew is not one more";
    error = s.send(pull_up(99));
    ASSERT_TRUE(error);
    EXPECT_EQ(error->code, "too_many");
    EXPECT_FALSE(s.send(pull_up(99), 2)) << "another client";
}

TEST(Session, AFailedBuildIsAnEvent) {
    Scene scene = box_scene();
    scene.mesh = SurfaceMeshSpec{{"/nowhere/model.obj"}, 1, 100};
    TestSession s(true, scene);
    ASSERT_TRUE(s.wait([&] { return s.build_error != nullptr; }));
    EXPECT_THROW(std::rethrow_exception(s.build_error), InputError);
    const auto error = s.send(command::Play{});
    ASSERT_TRUE(error);
    EXPECT_EQ(error->code, "failed");
    EXPECT_FALSE(s.frame);
}

TEST(Session, EveryCommandIsAnsweredOnceFromManyThreadsAndAcrossAStop) {
    std::atomic<int> answers = 0;
    constexpr int threads = 4, each = 2000;
    {
        TestSession s(true);
        std::vector<std::thread> senders;
        for (int t = 0; t < threads; ++t)
            senders.emplace_back([&, t] {
                for (int i = 0; i < each; ++i) {
                    const auto client = static_cast<ClientId>(t + 1);
                    const Command command = i % 2 ? Command(command::PullMove{1, Vec3(0, 0, 1)}) : Command(pull_up(1));
                    s.session.submit(client, command, [&](const auto&) { ++answers; });
                    if (i % 500 == 499) s.session.disconnect(client);
                }
            });
        ASSERT_TRUE(s.wait([&] { return s.frame != nullptr; }));
        s.session.stop();
        for (auto& sender : senders) sender.join();
    }
    EXPECT_EQ(answers, threads * each);
}

/// Takes seconds to build.
Scene large_scene() {
    Scene scene = box_scene();
    scene.mesh = BoxMeshSpec{{0, 0, 0}, {4, 1, 1}, {16, 4, 4}};
    scene.levels = 3;
    return scene;
}

TEST(Session, OneClientDoesNotFillTheQueueOfAll) {
    std::atomic<int> refused = 0, others = 0;
    {
        TestSession s(false, large_scene());
        ASSERT_TRUE(s.wait([&] { return !s.stages.empty(); }));  // commands wait until it is built
        for (int i = 0; i < 3000; ++i) s.session.submit(1, command::Pause{}, [&](const auto& error) { refused += error && error->code == "too_many"; });
        EXPECT_EQ(refused, 3000 - static_cast<int>(Session::max_client_queue));
        EXPECT_EQ(s.session.waiting(), Session::max_client_queue);
        s.session.submit(2, command::Pause{}, [&](const auto& error) { others += error && error->code == "too_many"; });
        EXPECT_EQ(others, 0);
        EXPECT_EQ(s.session.waiting(), Session::max_client_queue + 1);
    }
    EXPECT_EQ(refused, 3000 - static_cast<int>(Session::max_client_queue)) << "the others were told that the server stops";
}

TEST(Session, ManyCommandsLeaveRoomForFrames) {
    Scene scene = box_scene();
    scene.mesh = BoxMeshSpec{{0, 0, 0}, {4, 1, 1}, {8, 4, 4}};
    scene.levels = 2;
    TestSession s(false, scene);
    ASSERT_TRUE(s.wait([&] { return s.frame != nullptr; }));
    std::atomic<int> done = 0;
    const int before = s.look([&] { return s.frames; });
    // Each makes another front, which costs the tree.
    constexpr int count = 1000;
    for (int i = 0; i < count; ++i) s.session.submit(1, command::Order{1 + i % 2}, [&](const auto&) { ++done; });
    ASSERT_TRUE(s.wait([&] { return s.frames >= before + 3 || done == count; }));
    EXPECT_LT(done, count) << "all were carried out before anybody saw anything";
}

TEST(Session, StopsWhileItBuilds) {
    Session session(large_scene(), true);
    std::promise<void> begun;
    std::atomic<bool> first = true;
    session.start({.progress = [&](const std::string&, double) {
        if (first.exchange(false)) begun.set_value();
    }});
    begun.get_future().wait();
    session.stop();  // returns: that is the test
}

/// Ten frames at ten a second of the hand-made lump.
Recording short_recording(const TemporaryFolder& folder) {
    const auto base = blob_frame(6);
    RecordingInfo info;
    info.name = "lump", info.fps = 10;
    RecordingWriter writer(folder.path() / "run.tfr", info, *base->model);
    for (int i = 0; i < 10; ++i) {
        base->status.time = i / 10.0;
        base->status.step = static_cast<std::uint64_t>(i);
        writer.add(*base);
    }
    writer.finish();
    return Recording(folder.path() / "run.tfr");
}

TEST(Session, AFailureIsAnEventAndAResetStartsAgain) {
    const TemporaryFolder folder;
    Recording recording = short_recording(folder);
    // What cannot happen to a simulation on purpose can to a recording: its second half is gone once it is open.
    std::filesystem::resize_file(folder.path() / "run.tfr", std::filesystem::file_size(folder.path() / "run.tfr") / 2);
    TestSession s(true, std::move(recording));
    ASSERT_TRUE(s.wait([&] { return s.state.failed; }));
    EXPECT_NE(s.look([&] { return s.state.status.warning; }).find("reset to start again"), std::string::npos);
    EXPECT_FALSE(s.look([&] { return s.state.playing; }));
    const auto error = s.send(command::Play{});
    ASSERT_TRUE(error);
    EXPECT_EQ(error->code, "failed");
    EXPECT_EQ(s.send(command::Reset{}), std::nullopt);
    ASSERT_TRUE(s.wait([&] { return !s.state.failed && s.frame->status.step == 0; }));
    EXPECT_EQ(s.send(command::Step{}), std::nullopt);
    EXPECT_TRUE(s.wait([&] { return s.frame->status.step == 1; }));
}

TEST(Session, PlaysARecordingToItsEnd) {
    const TemporaryFolder folder;
    TestSession s(false, short_recording(folder));
    ASSERT_TRUE(s.wait([&] { return s.model && s.frame; }));
    ASSERT_TRUE(s.look([&] { return s.model->recorded; }));
    EXPECT_EQ(s.look([&] { return s.model->recorded->frames; }), 10U);
    EXPECT_EQ(s.look([&] { return s.model->recorded->end; }), 0.9);
    EXPECT_EQ(s.send(command::Step{3}), std::nullopt);
    EXPECT_TRUE(s.wait([&] { return s.frame->status.step == 3; }));
    EXPECT_EQ(s.send(command::Seek{0.55}), std::nullopt);
    EXPECT_TRUE(s.wait([&] { return s.frame->status.step == 5; }));
    EXPECT_EQ(s.send(command::Seek{99}), std::nullopt);
    EXPECT_TRUE(s.wait([&] { return s.frame->status.step == 9; }));
    EXPECT_EQ(s.send(command::Reset{}), std::nullopt);
    EXPECT_TRUE(s.wait([&] { return s.frame->status.step == 0; }));
    EXPECT_EQ(s.send(command::Speed{10}), std::nullopt);
    EXPECT_EQ(s.send(command::Play{}), std::nullopt);
    EXPECT_TRUE(s.wait([&] { return s.frame->status.step == 9 && !s.state.playing; })) << "it stops at the end";
}

TEST(Session, ARecordingCannotBeChanged) {
    const TemporaryFolder folder;
    TestSession s(false, short_recording(folder));
    ASSERT_TRUE(s.wait([&] { return s.frame != nullptr; }));
    for (const Command& command : {Command{command::Gravity{{0, 0, 1}}}, Command{command::Tolerance{0.1}}, Command{command::Levels{0, 1}},
                                   Command{command::PullBegin{1, {0, Vec3::Constant(1.0 / 3)}, {0, 0, 0}}}}) {
        const auto error = s.send(command);
        ASSERT_TRUE(error);
        EXPECT_EQ(error->code, "failed");
        EXPECT_NE(error->message.find("recording"), std::string::npos) << error->message;
    }
    EXPECT_EQ(s.send(command::PullEnd{1}), std::nullopt);
    TestSession live(false);
    ASSERT_TRUE(live.wait([&] { return live.frame != nullptr; }));
    EXPECT_EQ(live.send(command::Seek{1})->code, "failed") << "nor can a simulation go to another time";
}

TEST(Session, CapturesTheMomentWithAField) {
    TestSession s(false);
    const auto capture = [&](Field field) {
        std::promise<std::shared_ptr<const Frame>> answer;
        s.session.capture(field, [&](auto frame) { answer.set_value(frame); });
        return answer.get_future().get();
    };
    const auto frame = capture(Field::stress);  // asked for while the model is being built: comes when it is
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->field_values.size(), frame->surface.size());
    s.session.stop();
    EXPECT_EQ(capture(Field::none), nullptr);
}

}  // namespace
}  // namespace tetfront
