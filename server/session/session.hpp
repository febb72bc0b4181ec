#pragma once
// A live simulation, or a recording that is played, on a thread of its own. The thread owns the Stage; everyone else sends commands, which are
// applied between steps, and receives immutable Frames.
//
// Another scene is built beside it while it goes on, and then takes its place.
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
#include "server/session/library.hpp"
#include "server/session/live_recording.hpp"
#include "server/session/scene_build.hpp"
#include "server/session/stage.hpp"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
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

/// The numbers of the moment that the last published frame shows.
struct SessionState {
    bool playing = false;
    double speed = 1;
    double steps_per_second = 0;  // measured over the last half second of playing; 0: none
    bool failed = false;          // the simulation was given up, see status.warning; reset starts again
    FrameStatus status;
    std::vector<std::uint32_t> tets_by_level;  // [depth+1]
    std::vector<FrameForce> scene_forces;      // that act now; of a recording also those of clients
    Vec3 gravity = Vec3::Zero();               // [m/s^2]
    int order = 2;
    command::Levels levels;  // that can be active
    Edits edits;
    command::Budget budget;
    RecordingStatus recording;
    std::uint64_t steps = 0;  // since the session started, resets and loads included
};

/// A client's pull made unique among all clients; `pull` is below 2^31.
inline std::uint64_t pull_id(ClientId client, std::uint32_t pull) { return (std::uint64_t{client} << 31) | pull; }

/// What is published of one moment.
struct Shots {
    std::shared_ptr<const Frame> frame;                    // without values
    std::vector<std::shared_ptr<const Frame>> coloured;    // the same moment, one for each field that is wanted
};

struct SessionSettings {
    CacheSettings cache = {};  // for build_model; its warnings come on the thread that builds
    Library library = {};      // scenes that may be loaded, and where recordings are kept
    std::uint64_t recording_bytes = std::uint64_t{1} << 30;  // of one recording
    std::size_t files = 1000;  // recordings that are kept, and saved states
    std::size_t tets = 4'000'000;  // the smallest ones of a scene that clients load
};

class Session {
 public:
    /// Called on the simulation thread, one at a time, never after stop() has returned. They must not block and must
    /// not throw. Any may be empty.
    struct Listener {
        /// While a model is being built, on the thread that builds; a fraction of 1 says that this is over.
        Progress progress = {};
        std::function<void(std::shared_ptr<const SessionModel>)> model = {};  // before the first frame, and of each scene
        std::function<void(const Shots&)> frame = {};                  // at most about 60 a second
        std::function<void(const SessionState&)> state = {};           // on a change, and 10 a second while stepping
        std::function<void(std::exception_ptr)> build_failed = {};     // no model, frame or state will come
    };
    /// Called exactly once per command: on the simulation thread, or within submit() when the queue is full.
    /// nullopt: done (step: begun).
    using Reply = std::function<void(const std::optional<CommandError>&)>;

    static constexpr std::size_t max_queue = 4096;  // commands that wait for the end of a step
    static constexpr std::size_t max_client_queue = 1024;  // of them of one client
    static constexpr std::size_t max_client_pulls = 16;

    using Settings = SessionSettings;
    Session(Scene scene, bool playing, Settings settings = {});
    Session(Recording recording, bool playing, Settings settings = {});
    ~Session();  // stop()
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    /// Starts the thread, which builds the model first. Once only.
    void start(Listener listener);
    /// The thread is told to end, and all further commands are refused; stop() has to follow. Any thread.
    void begin_stop();
    /// Ends the thread after the step (or stage of the build) that it is in; waiting commands are answered `failed`.
    void stop();
    /// The same, but waits for so long at most. False: the thread still works, and stop() has to be called once more.
    bool stop_within(std::chrono::milliseconds patience);

    /// Any thread. Pull numbers of different clients never meet.
    void submit(ClientId client, Command command, Reply reply);
    /// Any thread. Calls `use` on the simulation thread with the present moment, which has this field (a recording: if
    /// it was recorded); with null when there is none.
    void capture(Field field, std::function<void(std::shared_ptr<const Frame>)> use);
    /// Any thread. Ends the client's pulls.
    void disconnect(ClientId client);
    /// Any thread. Frames come with these fields from now on.
    void show_fields(std::set<Field> fields);
    /// Any thread. Commands that wait for the simulation.
    [[nodiscard]] std::size_t waiting() const;
    /// Any thread. [s] that the simulation thread has been busy with one thing: a step, a stage of a build. 0: it waits.
    [[nodiscard]] double busy_for() const;
    [[nodiscard]] const Settings& settings() const { return settings_; }

 private:
    using Clock = std::chrono::steady_clock;
    struct Disconnect {};
    struct Capture {
        Field field;
        std::function<void(std::shared_ptr<const Frame>)> use;
    };
    struct ShowFields {
        std::set<Field> fields;
    };
    struct Request {
        ClientId client;
        std::variant<Command, Disconnect, Capture, ShowFields> what;
        Reply reply;
    };

    // All below run on the simulation thread.
    void run();
    bool build();
    std::shared_ptr<const Model> build_first();
    void note_built();  // any thread
    void use(const std::shared_ptr<const Model>& model);
    void note_busy();  // any thread
    bool take_requests(std::deque<Request>& requests);
    void refuse_all(std::deque<Request>& requests);
    [[nodiscard]] std::optional<Clock::time_point> deadline() const;
    [[nodiscard]] bool stepping() const { return playing_ || pending_steps_ > 0; }
    void apply(Request& request);
    void capture(const Capture& wanted);
    std::optional<CommandError> apply(ClientId client, const Command& command);
    void apply_settings();
    [[nodiscard]] std::unique_ptr<Stage> another_stage() const;
    void edit(const std::function<void(Edits&)>& change);
    void begin_load(const command::Load& wanted, Reply reply);
    void end_load();
    std::optional<CommandError> save(const command::Save& wanted);
    std::optional<CommandError> restore(const command::Restore& wanted);
    std::optional<CommandError> start_recording(const command::RecordStart& wanted);
    void stop_recording();
    void set_playing(bool playing);
    void record();
    void record_event(ClientId client, const Command& command);
    void step_if_due();
    void publish_if_due();
    void publish_frame();
    void measure_rate();
    void restart();
    void break_down(const std::string& what);

    const Settings settings_;
    std::optional<Scene> scene_;  // to build; none: play recording_
    std::atomic<std::size_t> commands_taken_{0};  // from queue_ and not yet carried out
    std::atomic<std::int64_t> busy_since_{0};  // [ns] of Clock; 0: not busy
    std::shared_ptr<Recording> recording_;
    Listener listener_;
    std::thread thread_;

    mutable std::mutex mutex_;  // guards what follows up to the next comment
    std::condition_variable wake_, end_;
    std::deque<Request> queue_;
    std::size_t commands_queued_ = 0;              // in queue_
    std::map<ClientId, std::size_t> queued_by_;    // the same by client
    bool stopping_ = false;
    bool built_ = false;  // a SceneBuild has finished
    bool ended_ = false;  // the thread calls nobody any more

    // Owned by the simulation thread.
    std::shared_ptr<const SessionModel> model_;
    std::function<std::unique_ptr<Stage>()> make_stage_;
    std::uint32_t epoch_ = 0;  // of the last frame that was published
    std::unique_ptr<Stage> stage_;  // null: not built, or broken (failure_ says why)
    std::string failure_;
    std::map<ClientId, std::set<std::uint32_t>> pulls_;
    std::optional<Vec3> gravity_;  // set by a command: survives a restart
    std::optional<double> tolerance_;
    std::optional<command::Budget> budget_;
    std::optional<int> order_;
    std::optional<command::Levels> levels_;
    Edits edits_;
    std::set<Field> fields_;
    std::unique_ptr<LiveRecording> recorder_;
    std::unique_ptr<SceneBuild> loading_;  // another scene
    Reply loaded_;                         // to the command that asked for it
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
