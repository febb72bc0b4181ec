#include "server/session/session.hpp"

#include "engine/base/error.hpp"
#include "engine/base/overloaded.hpp"

#include <algorithm>
#include <utility>

namespace tetfront {

namespace {

using namespace std::chrono_literals;

constexpr auto frame_interval = 15ms;  // a little under 1/60 s, so that 60 steps a second give 60 frames
constexpr auto state_interval = 100ms;
constexpr auto rate_window = 500ms;
constexpr auto largest_lag = 50ms;  // more than this behind real time is dropped
constexpr int largest_backlog = 100'000;

struct BuildStopped {};  // thrown through build_model() by its progress callback

std::string text_of(const std::exception_ptr& error) {
    try {
        std::rethrow_exception(error);
    } catch (const std::exception& e) {
        return e.what();
    } catch (...) {
        return "unknown error";
    }
}

/// The client's number made unique among all clients; `pull` is below 2^31.
std::uint64_t pull_name(ClientId client, std::uint32_t pull) { return (std::uint64_t{client} << 31) | pull; }

}  // namespace

Session::Session(Scene scene, bool playing, CacheSettings cache)
    : scene_(std::move(scene)), cache_(std::move(cache)), playing_(playing) {}
Session::Session(Recording recording, bool playing)
    : recording_(std::make_shared<Recording>(std::move(recording))), playing_(playing) {}

Session::~Session() { stop(); }

void Session::start(Listener listener) {
    ENSURE(!thread_.joinable(), "a session starts once");
    listener_ = std::move(listener);
    thread_ = std::thread([this] { run(); });
}

void Session::stop() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    wake_.notify_all();
    if (thread_.joinable()) thread_.join();
}

void Session::submit(ClientId client, Command command, Reply reply) {
    bool stopping = false;
    {
        const std::lock_guard lock(mutex_);
        stopping = stopping_;
        if (!stopping && queue_.size() < max_queue) {
            queue_.push_back({client, std::move(command), std::move(reply)});
            wake_.notify_all();
            return;
        }
    }
    if (stopping)
        reply(CommandError{"failed", "", "the server is shutting down"});
    else
        reply(CommandError{"too_many", "", "too many commands are waiting for the simulation; send fewer"});
}

void Session::capture(Field field, std::function<void(std::shared_ptr<const Frame>)> use) {
    {
        const std::lock_guard lock(mutex_);
        if (!stopping_) {
            queue_.push_back({0, Capture{field, std::move(use)}, {}});
            wake_.notify_all();
            return;
        }
    }
    use(nullptr);
}

void Session::disconnect(ClientId client) {
    const std::lock_guard lock(mutex_);  // not subject to max_queue: it must not get lost, and comes once per client
    queue_.push_back({client, Disconnect{}, {}});
    wake_.notify_all();
}

void Session::run() {
    if (build()) {
        next_step_ = rate_since_ = Clock::now();
        frame_dirty_ = state_urgent_ = true;
    }
    for (std::vector<Request> requests; take_requests(requests);) {
        for (Request& request : requests) apply(request);
        requests.clear();
        step_if_due();
        publish_if_due();
    }
}

bool Session::build() {
    try {
        if (scene_) {
            const Progress progress = [this](const std::string& what, double fraction) {
                {
                    const std::lock_guard lock(mutex_);
                    if (stopping_) throw BuildStopped{};
                }
                if (listener_.progress) listener_.progress(what, fraction);
            };
            const auto model = build_model(*scene_, progress, cache_);
            make_stage_ = [model] { return play_simulation(model); };
            model_ = std::make_shared<const SessionModel>(session_model(*model));
        } else {
            make_stage_ = [this] { return play_recording(recording_); };
            model_ = std::make_shared<const SessionModel>(session_model(*recording_));
        }
        stage_ = make_stage_();
    } catch (const BuildStopped&) {
        return false;
    } catch (...) {
        const std::exception_ptr error = std::current_exception();
        model_.reset();
        failure_ = "the model could not be built: " + text_of(error);
        if (listener_.build_failed) listener_.build_failed(error);
        return false;
    }
    if (listener_.model) listener_.model(model_);
    return true;
}

/// Sleeps until there is something to do; false: stop. What waits is moved to `requests`.
bool Session::take_requests(std::vector<Request>& requests) {
    const auto until = deadline();
    bool stopping = false;
    {
        std::unique_lock lock(mutex_);
        const auto ready = [this] { return stopping_ || !queue_.empty(); };
        if (until)
            wake_.wait_until(lock, *until, ready);
        else
            wake_.wait(lock, ready);
        stopping = stopping_;
        std::swap(requests, queue_);
    }
    if (!stopping) return true;
    for (Request& request : requests) {
        if (const auto* capture = std::get_if<Capture>(&request.what)) capture->use(nullptr);
        if (request.reply) request.reply(CommandError{"failed", "", "the server is shutting down"});
    }
    return false;
}

/// When the thread has something to do without any command; nullopt: never.
std::optional<Session::Clock::time_point> Session::deadline() const {
    std::optional<Clock::time_point> first;
    const auto at = [&first](Clock::time_point time) { first = first ? std::min(*first, time) : time; };
    if (pending_steps_ > 0) at(Clock::time_point{});
    if (playing_) at(next_step_);
    if (frame_dirty_) at(last_frame_ + frame_interval);
    if (state_urgent_) at(Clock::time_point{});
    if (state_dirty_) at(last_state_ + state_interval);
    return first;
}

void Session::apply(Request& request) {
    if (std::holds_alternative<Disconnect>(request.what)) {
        const auto pulls = pulls_.extract(request.client);
        if (!pulls || !stage_) return;
        for (const std::uint32_t pull : pulls.mapped()) stage_->end_pull(pull_name(request.client, pull));
        frame_dirty_ = true;
        return;
    }
    if (const auto* wanted = std::get_if<Capture>(&request.what)) return capture(*wanted);
    std::optional<CommandError> error;
    try {
        error = apply(request.client, std::get<Command>(request.what));
    } catch (const InputError& e) {
        error = CommandError{"failed", e.where, e.problem + (e.remedy.empty() ? "" : "; " + e.remedy)};
    } catch (...) {
        break_down(text_of(std::current_exception()));
        error = CommandError{"failed", "", failure_};
    }
    if (request.reply) request.reply(error);
}

void Session::capture(const Capture& wanted) {
    std::shared_ptr<const Frame> frame;
    try {
        if (stage_) frame = stage_->frame(state_.steps_per_second, wanted.field);
    } catch (...) {
        break_down(text_of(std::current_exception()));
    }
    wanted.use(std::move(frame));
}

std::optional<CommandError> Session::apply(ClientId client, const Command& command) {
    if (!model_) return CommandError{"failed", "", failure_};
    if (std::holds_alternative<command::Reset>(command)) restart();
    if (!stage_) return CommandError{"failed", "", failure_};
    frame_dirty_ = state_dirty_ = true;

    using Result = std::optional<CommandError>;
    const auto set_playing = [&](bool playing) -> Result {
        playing_ = playing;
        pending_steps_ = 0;
        rate_since_ = next_step_ = Clock::now();
        rate_steps_ = 0;
        state_.steps_per_second = 0;
        state_urgent_ = true;
        return {};
    };
    return std::visit(
        Overloaded{[&](const command::Play&) { return playing_ ? Result{} : set_playing(true); },
                   [&](const command::Pause&) { return set_playing(false); },
                   [&](const command::Reset&) -> Result {
                       state_urgent_ = true;
                       return {};
                   },
                   [&](const command::Step& step) -> Result {
                       if (playing_) return CommandError{"failed", "", "the simulation is playing; pause it first"};
                       if (pending_steps_ + step.count > largest_backlog)
                           return CommandError{"too_many", "/count", "too many steps are waiting already"};
                       pending_steps_ += step.count;
                       return {};
                   },
                   [&](const command::Speed& speed) -> Result {
                       speed_ = speed.value;
                       next_step_ = Clock::now();
                       state_urgent_ = true;
                       return {};
                   },
                   [&](const command::PullBegin& pull) -> Result {
                       const std::size_t triangles = model_->frame_model->triangles.size();
                       if (pull.point.triangle >= triangles)
                           return CommandError{"out_of_range", "/triangle",
                                               "is " + std::to_string(pull.point.triangle) + "; use 0.." +
                                                   std::to_string(triangles - 1)};
                       auto& mine = pulls_[client];
                       if (mine.size() >= max_client_pulls && !mine.contains(pull.pull))
                           return CommandError{"too_many", "/pull",
                                               "a client pulls at most " + std::to_string(max_client_pulls) +
                                                   " points at a time; end another pull first"};
                       stage_->begin_pull(pull_name(client, pull.pull), pull.point, pull.target);
                       mine.insert(pull.pull);
                       return {};
                   },
                   [&](const command::PullMove& pull) -> Result {
                       // A pull that a reset has ended is no error: another client may have sent the reset.
                       stage_->move_pull(pull_name(client, pull.pull), pull.target);
                       return {};
                   },
                   [&](const command::PullEnd& pull) -> Result {
                       stage_->end_pull(pull_name(client, pull.pull));
                       pulls_[client].erase(pull.pull);
                       return {};
                   },
                   [&](const command::Gravity& gravity) -> Result {
                       stage_->set_gravity(gravity.value);
                       gravity_ = gravity.value;
                       state_urgent_ = true;
                       return {};
                   },
                   [&](const command::Seek& seek) -> Result {
                       stage_->seek(seek.time);
                       next_step_ = Clock::now();
                       state_urgent_ = true;
                       return {};
                   },
                   [&](const command::Tolerance& tolerance) -> Result {
                       stage_->set_tolerance(tolerance.value);
                       tolerance_ = tolerance.value;
                       state_urgent_ = true;
                       return {};
                   },
                   [&](const command::Budget& budget) -> Result {
                       stage_->set_budget(static_cast<std::size_t>(budget.tets), budget.milliseconds);
                       budget_ = budget;
                       return {};
                   },
                   [&](const auto&) -> Result { return CommandError{"failed", "", "is not possible here"}; }},
        command);
}

void Session::step_if_due() {
    if (!stage_ || !stepping()) return;
    if (playing_ && Clock::now() < next_step_) return;
    try {
        if (!stage_->step()) {  // a recording's end
            playing_ = false;
            pending_steps_ = 0;
            state_.steps_per_second = 0;
            state_urgent_ = true;
            return;
        }
    } catch (...) {
        break_down(text_of(std::current_exception()));
        return;
    }
    frame_dirty_ = state_dirty_ = true;
    if (playing_) {
        next_step_ +=
            std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(model_->scene.time_step / speed_));
        const auto now = Clock::now();
        if (next_step_ + largest_lag < now) next_step_ = now;
        measure_rate();
    } else if (--pending_steps_ == 0) {
        state_urgent_ = true;
    }
}

void Session::measure_rate() {
    ++rate_steps_;
    const auto now = Clock::now();
    if (now - rate_since_ < rate_window) return;
    state_.steps_per_second = rate_steps_ / std::chrono::duration<double>(now - rate_since_).count();
    rate_since_ = now;
    rate_steps_ = 0;
}

void Session::publish_if_due() {
    const auto now = Clock::now();
    const bool state = state_urgent_ || (state_dirty_ && now >= last_state_ + state_interval);
    // A state never speaks of a moment that no frame has shown.
    if (frame_dirty_ && (state || now >= last_frame_ + frame_interval)) publish_frame();
    if (!state) return;
    last_state_ = now;
    state_dirty_ = state_urgent_ = false;
    state_.playing = playing_;
    state_.speed = speed_;
    state_.gravity = gravity_.value_or(model_ ? model_->scene.gravity : Vec3::Zero());
    if (listener_.state) listener_.state(state_);
}

void Session::publish_frame() {
    frame_dirty_ = false;
    last_frame_ = Clock::now();
    if (!stage_) return;
    try {
        const std::shared_ptr<const Frame> frame = stage_->frame(state_.steps_per_second, Field::none);
        state_.status = frame->status;
        state_.tets_by_level = frame->topology->tets_by_level;
        if (listener_.frame) listener_.frame(frame);
    } catch (...) {
        break_down(text_of(std::current_exception()));
    }
}

/// Back to rest, also after a failure; settings stay.
void Session::restart() {
    pulls_.clear();
    pending_steps_ = 0;
    try {
        if (stage_) {
            stage_->reset();
        } else {
            stage_ = make_stage_();
            if (gravity_) stage_->set_gravity(*gravity_);
            if (tolerance_) stage_->set_tolerance(*tolerance_);
            if (budget_) stage_->set_budget(static_cast<std::size_t>(budget_->tets), budget_->milliseconds);
        }
    } catch (...) {
        break_down(text_of(std::current_exception()));
        return;
    }
    failure_.clear();
    next_step_ = rate_since_ = Clock::now();
    rate_steps_ = 0;
    frame_dirty_ = state_urgent_ = true;
}

/// A bug or a lack of memory: the simulation is given up, the session lives on and says so.
void Session::break_down(const std::string& what) {
    stage_.reset();
    failure_ = "the simulation failed: " + what + "; reset to start again";
    std::ranges::replace(failure_, '\n', ' ');
    state_.status.warning = failure_;
    playing_ = false;
    pending_steps_ = 0;
    frame_dirty_ = false;
    state_urgent_ = true;
}

}  // namespace tetfront
