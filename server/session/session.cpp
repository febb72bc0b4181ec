#include "server/session/session.hpp"

#include "engine/base/atomic_file.hpp"
#include "engine/base/error.hpp"
#include "server/session/session_errors.hpp"

#include <algorithm>
#include <utility>

namespace tetfront {

namespace {

using namespace std::chrono_literals;

constexpr auto frame_interval = 15ms;  // a little under 1/60 s, so that 60 steps a second give 60 frames
constexpr auto state_interval = 100ms;
constexpr auto rate_window = 500ms;
constexpr auto turn = 20ms;         // for commands, before a step and a frame have theirs
constexpr auto largest_lag = 50ms;  // more than this behind real time is dropped

}  // namespace

Session::Session(Scene scene, bool playing, Settings settings)
    : settings_(std::move(settings)), scene_(std::move(scene)), playing_(playing) {}
Session::Session(Recording recording, bool playing, Settings settings)
    : settings_(std::move(settings)), recording_(std::make_shared<Recording>(std::move(recording))), playing_(playing) {}

Session::~Session() { stop(); }

void Session::start(Listener listener) {
    ENSURE(!thread_.joinable(), "a session starts once");
    listener_ = std::move(listener);
    thread_ = std::thread([this] { run(); });
}

void Session::begin_stop() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    wake_.notify_all();
}

void Session::stop() {
    begin_stop();
    if (thread_.joinable()) thread_.join();
}

bool Session::stop_within(std::chrono::milliseconds patience) {
    if (thread_.joinable()) {
        std::unique_lock lock(mutex_);
        stopping_ = true;
        wake_.notify_all();
        if (!end_.wait_for(lock, patience, [this] { return ended_; })) return false;
    }
    stop();
    return true;
}

void Session::submit(ClientId client, Command command, Reply reply) {
    bool stopping = false;
    {
        const std::lock_guard lock(mutex_);
        stopping = stopping_;
        if (std::size_t& mine = queued_by_[client]; !stopping && commands_queued_ < max_queue && mine < max_client_queue) {
            ++mine, ++commands_queued_;
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

void Session::show_fields(std::set<Field> fields) {
    const std::lock_guard lock(mutex_);
    if (!queue_.empty() && std::holds_alternative<ShowFields>(queue_.back().what)) queue_.pop_back();  // never shown
    queue_.push_back({0, ShowFields{std::move(fields)}, {}});
    wake_.notify_all();
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
    for (std::deque<Request> requests; take_requests(requests);) {
        // Not all at once, should they be many that take long: others want to see something.
        for (const auto until = Clock::now() + turn; !requests.empty() && Clock::now() < until; requests.pop_front()) apply(requests.front());
        commands_taken_ = requests.size();
        if (loading_ && loading_->finished()) end_load();
        step_if_due();
        publish_if_due();
    }
    stop_recording();  // completes its file
    loading_.reset();
    if (loaded_) loaded_(CommandError{"failed", "", "the server is shutting down"});
    const std::lock_guard lock(mutex_);
    ended_ = true;
    end_.notify_all();
}

void Session::note_busy() { busy_since_ = Clock::now().time_since_epoch().count(); }

double Session::busy_for() const {
    const std::int64_t since = busy_since_;
    return since == 0 ? 0 : std::chrono::duration<double>(Clock::now().time_since_epoch() - Clock::duration(since)).count();
}

std::size_t Session::waiting() const {
    const std::lock_guard lock(mutex_);
    return commands_queued_ + commands_taken_;
}

/// Sleeps until there is something to do; false: stop. When `requests` is empty, what waits is moved there.
bool Session::take_requests(std::deque<Request>& requests) {
    const auto until = requests.empty() ? deadline() : Clock::time_point{};
    bool stopping = false;
    busy_since_ = 0;
    {
        std::unique_lock lock(mutex_);
        const auto ready = [this] { return stopping_ || built_ || !queue_.empty(); };
        if (until)
            wake_.wait_until(lock, *until, ready);
        else
            wake_.wait(lock, ready);
        stopping = stopping_;
        built_ = false;
        if (requests.empty()) {
            std::swap(requests, queue_);
            commands_queued_ = 0;
            queued_by_.clear();
        }
    }
    note_busy();
    if (!stopping) return true;
    refuse_all(requests);
    std::deque<Request> last;
    {
        const std::lock_guard lock(mutex_);
        std::swap(last, queue_);
    }
    refuse_all(last);
    return false;
}

void Session::refuse_all(std::deque<Request>& requests) {
    for (Request& request : requests) {
        if (const auto* capture = std::get_if<Capture>(&request.what)) capture->use(nullptr);
        if (request.reply) request.reply(CommandError{"failed", "", "the server is shutting down"});
    }
    requests.clear();
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
        try {
            for (const std::uint32_t pull : pulls.mapped()) {
                stage_->end_pull(pull_id(request.client, pull));
                record_event(request.client, command::PullEnd{pull});
            }
        } catch (...) {
            break_down(text_of(std::current_exception()));
        }
        frame_dirty_ = true;
        return;
    }
    if (const auto* wanted = std::get_if<Capture>(&request.what)) return capture(*wanted);
    if (auto* shown = std::get_if<ShowFields>(&request.what)) {
        fields_ = std::move(shown->fields);
        frame_dirty_ = true;
        return;
    }
    if (const auto* command = std::get_if<Command>(&request.what))
        if (const auto* load = std::get_if<command::Load>(command)) return begin_load(*load, std::move(request.reply));
    std::optional<CommandError> error;
    try {
        error = apply(request.client, std::get<Command>(request.what));
        if (!error) record_event(request.client, std::get<Command>(request.what));
    } catch (const OutputError& e) {
        error = CommandError{"failed", "", settings_.library.without_folders(e.what())};
    } catch (const InputError& e) {
        error = refusal(e);
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
    ++state_.steps;
    try {
        record();
    } catch (...) {
        break_down(text_of(std::current_exception()));
        return;
    }
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
    state_.failed = !failure_.empty();
    state_.speed = speed_;
    state_.gravity = gravity_.value_or(model_ ? model_->scene.gravity : Vec3::Zero());
    if (model_) {
        FrontSpec front = model_->scene.front;
        state_.order = front.order = order_.value_or(front.order);
        if (levels_) front.min_level = levels_->min, front.max_level = levels_->max;
        state_.levels.max = front.finest(model_->frame_model->depth);
        state_.levels.min = std::min(front.min_level, state_.levels.max);
        state_.budget = budget_.value_or(command::Budget{front.budget_tets, front.budget_milliseconds});
    }
    state_.edits = edits_;
    if (recorder_) {
        state_.recording = recorder_->status();
        state_.recording.problem = settings_.library.without_folders(state_.recording.problem);
    }
    if (listener_.state) listener_.state(state_);
}

void Session::publish_frame() {
    frame_dirty_ = false;
    last_frame_ = Clock::now();
    if (!stage_) return;
    try {
        const std::shared_ptr<const Frame> frame = stage_->frame(state_.steps_per_second, Field::none);
        epoch_ = frame->topology->epoch;
        state_.status = frame->status;
        state_.tets_by_level = frame->topology->tets_by_level;
        const std::size_t of_clients = std::min(edits_.forces.size(), frame->forces.size());  // behind the scene's
        state_.scene_forces.assign(frame->forces.begin(), frame->forces.end() - static_cast<std::ptrdiff_t>(of_clients));
        Shots shots{frame, {}};
        for (const Field field : fields_)
            if (auto coloured = stage_->frame(state_.steps_per_second, field); !coloured->field_values.empty())
                shots.coloured.push_back(std::move(coloured));
        if (listener_.frame) listener_.frame(shots);
    } catch (...) {
        break_down(text_of(std::current_exception()));
    }
}

/// Back to rest, also after a failure; settings stay.
void Session::restart() {
    pulls_.clear();
    pending_steps_ = 0;
    stop_recording();
    try {
        if (stage_) {
            stage_->reset();
        } else {
            stage_ = another_stage();
            apply_settings();
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
    stop_recording();
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
