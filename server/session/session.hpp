#pragma once
// A live simulation, or a recording that is played, on a thread of its own. The thread owns the Stage; everyone else sends commands, which are
// applied between steps, and receives immutable Frames.
//
// It keeps pace with real time times `speed` when the machine can, and drops the lag when it cannot, so that it never
// falls into a spiral; `steps_per_second` tells what it reached. While paused without commands the thread sleeps.
//
//     Session session(load_scene("assets/scenes/bunny.json"), /*playing=*/true);
//     session.start({.frame = [](std::shared_ptr<const Frame> frame) { ... }});
//     session.submit(client, command::Pause{}, [](const std::optional<CommandError>& error) { ... });
//     session.stop();

#include "engine/scene/scene.hpp"
#include "engine/simulation/frame.hpp"
#include "engine/simulation/simulation.hpp"
#include "server/session/command.hpp"
#include "server/session/stage.hpp"

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

namespace tetfront {

using ClientId = std::uint32_t;

/// The numbers of the moment that the last published frame shows.
struct SessionState {
    bool playing = false;
    double speed = 1;
    double steps_per_second = 0;  // measured over the last half second of playing; 0: none
    FrameStatus status;
    std::vector<std::uint32_t> tets_by_level;  // [depth+1]
    Vec3 gravity = Vec3::Zero();               // [m/s^2]
};

class Session {
 public:
    /// Called on the simulation thread, one at a time, never after stop() has returned. They must not block and must
    /// not throw. Any may be empty.
    struct Listener {
        Progress progress = {};                                        // while the model is being built
        std::function<void(std::shared_ptr<const SessionModel>)> model = {};  // once, before the first frame
        std::function<void(std::shared_ptr<const Frame>)> frame = {};  // at most about 60 a second
        std::function<void(const SessionState&)> state = {};           // on a change, and 10 a second while stepping
        std::function<void(std::exception_ptr)> build_failed = {};     // no model, frame or state will come
    };
    /// Called exactly once per command: on the simulation thread, or within submit() when the queue is full.
    /// nullopt: done (step: begun).
    using Reply = std::function<void(const std::optional<CommandError>&)>;

    static constexpr std::size_t max_queue = 4096;  // commands that wait for the end of a step
    static constexpr std::size_t max_client_pulls = 16;

    /// cache: for build_model; its warnings come on the simulation thread.
    Session(Scene scene, bool playing, CacheSettings cache = {});
    Session(Recording recording, bool playing);
    ~Session();  // stop()
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    /// Starts the thread, which builds the model first. Once only.
    void start(Listener listener);
    /// Ends the thread after the step (or stage of the build) that it is in; waiting commands are answered `failed`.
    void stop();

    /// Any thread. Pull numbers of different clients never meet.
    void submit(ClientId client, Command command, Reply reply);
    /// Any thread. Calls `use` on the simulation thread with the present moment, which has this field (a recording: if
    /// it was recorded); with null when there is none.
    void capture(Field field, std::function<void(std::shared_ptr<const Frame>)> use);
    /// Any thread. Ends the client's pulls.
    void disconnect(ClientId client);

 private:
    using Clock = std::chrono::steady_clock;
    struct Disconnect {};
    struct Capture {
        Field field;
        std::function<void(std::shared_ptr<const Frame>)> use;
    };
    struct Request {
        ClientId client;
        std::variant<Command, Disconnect, Capture> what;
        Reply reply;
    };

    // All below run on the simulation thread.
    void run();
    bool build();
    bool take_requests(std::vector<Request>& requests);
    [[nodiscard]] std::optional<Clock::time_point> deadline() const;
    [[nodiscard]] bool stepping() const { return playing_ || pending_steps_ > 0; }
    void apply(Request& request);
    void capture(const Capture& wanted);
    std::optional<CommandError> apply(ClientId client, const Command& command);
    void step_if_due();
    void publish_if_due();
    void publish_frame();
    void measure_rate();
    void restart();
    void break_down(const std::string& what);

    std::optional<Scene> scene_;  // to build; none: play recording_
    CacheSettings cache_;
    std::shared_ptr<Recording> recording_;
    Listener listener_;
    std::thread thread_;

    std::mutex mutex_;  // guards the three below
    std::condition_variable wake_;
    std::vector<Request> queue_;
    bool stopping_ = false;

    // Owned by the simulation thread.
    std::shared_ptr<const SessionModel> model_;
    std::function<std::unique_ptr<Stage>()> make_stage_;
    std::unique_ptr<Stage> stage_;  // null: not built, or broken (failure_ says why)
    std::string failure_;
    std::map<ClientId, std::set<std::uint32_t>> pulls_;
    std::optional<Vec3> gravity_;  // set by a command: survives a restart
    std::optional<double> tolerance_;
    std::optional<command::Budget> budget_;
    bool playing_;
    double speed_ = 1;
    int pending_steps_ = 0;
    Clock::time_point next_step_{};
    bool frame_dirty_ = false, state_dirty_ = false, state_urgent_ = false;
    Clock::time_point last_frame_{}, last_state_{};
    Clock::time_point rate_since_{};
    int rate_steps_ = 0;
    SessionState state_;
};

}  // namespace tetfront
