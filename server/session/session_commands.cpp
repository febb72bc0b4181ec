// What each command does to a session. All of it runs on the simulation thread.
#include "server/session/session.hpp"

#include "engine/base/error.hpp"
#include "engine/base/overloaded.hpp"
#include "engine/simulation/snapshot.hpp"
#include "server/session/command_json.hpp"
#include "server/session/saved_state.hpp"

#include <algorithm>
#include <ctime>
#include <filesystem>
#include <utility>

namespace tetfront {

namespace {

constexpr int largest_backlog = 100'000;
constexpr std::size_t max_forces = 64, max_pins = 256, max_stiffness = 64;

/// SCENE-20260131-235959, in UTC.
std::string dated_name(const std::string& scene) {
    std::string name;
    for (const char c : scene.substr(0, 40)) name += is_plain_name(std::string(1, c)) ? c : '-';
    if (name.empty()) name = "recording";
    const std::time_t now = std::time(nullptr);
    std::tm utc{};
    gmtime_r(&now, &utc);
    char text[32];
    const std::size_t length = std::strftime(text, sizeof text, "-%Y%m%d-%H%M%S", &utc);
    return name + std::string(text, length);
}

CommandError too_many_files(const char* what) {
    return {"too_many", "", std::string("the server keeps as many ") + what + " as it may; its operator can remove some"};
}

}  // namespace

std::optional<CommandError> Session::apply(ClientId client, const Command& command) {
    if (!model_) return CommandError{"failed", "", failure_};
    if (std::holds_alternative<command::Reset>(command)) restart();
    if (!stage_) return CommandError{"failed", "", failure_};
    frame_dirty_ = state_dirty_ = true;

    using Result = std::optional<CommandError>;
    return std::visit(
        Overloaded{[&](const command::Play&) {
                       if (!playing_) set_playing(true);
                       return Result{};
                   },
                   [&](const command::Pause&) {
                       set_playing(false);
                       return Result{};
                   },
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
                       stage_->begin_pull(pull_id(client, pull.pull), pull.point, pull.target);
                       mine.insert(pull.pull);
                       return {};
                   },
                   [&](const command::PullMove& pull) -> Result {
                       // A pull that a reset has ended is no error: another client may have sent the reset.
                       stage_->move_pull(pull_id(client, pull.pull), pull.target);
                       return {};
                   },
                   [&](const command::PullEnd& pull) -> Result {
                       stage_->end_pull(pull_id(client, pull.pull));
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
                   [&](const command::ForceAdd& force) -> Result {
                       if (edits_.forces.size() >= max_forces && !edits_.forces.contains(force.force))
                           return CommandError{"too_many", "/force", "there are 64 forces already; remove one first"};
                       edit([&](Edits& e) { e.forces[force.force] = {force.point, force.value}; });
                       return {};
                   },
                   [&](const command::ForceMove& force) -> Result {
                       if (!edits_.forces.contains(force.force))
                           return CommandError{"unknown_name", "/force", "there is no such force; add it first"};
                       edit([&](Edits& e) {
                           e.forces[force.force].value = force.value;
                           if (force.point) e.forces[force.force].at = *force.point;
                       });
                       return {};
                   },
                   [&](const command::ForceRemove& force) -> Result {
                       edit([&](Edits& e) { e.forces.erase(force.force); });
                       return {};
                   },
                   [&](const command::Pin& pin) -> Result {
                       Edits wanted = edits_;
                       // What was said of the same place before has no say any more.
                       std::erase_if(wanted.pins, [&](const PinEdit& e) { return e.centre == pin.point && e.radius == pin.radius; });
                       if (wanted.pins.size() >= max_pins)
                           return CommandError{"too_many", "", "256 places are pinned or let go already; load the scene to begin anew"};
                       wanted.pins.push_back({pin.pinned, pin.point, pin.radius});
                       edit([&](Edits& e) { e = wanted; });
                       return {};
                   },
                   [&](const command::StiffnessScale& scale) -> Result {
                       Edits wanted = edits_;
                       if (!scale.part) {
                           wanted.stiffness_scale = scale.value;
                       } else {
                           const StiffnessEdit part{scale.part->point, scale.part->radius, scale.value};
                           std::erase_if(wanted.stiffness, [&](const StiffnessEdit& e) { return e.centre == part.centre && e.radius == part.radius; });
                           wanted.stiffness.push_back(part);
                           // As the scene has them, and none said earlier that they could lie over: nothing to remember.
                           const auto first = std::ranges::find_if(wanted.stiffness, [](const StiffnessEdit& e) { return e.scale != 1; });
                           wanted.stiffness.erase(wanted.stiffness.begin(), first);
                           if (wanted.stiffness.size() > max_stiffness)
                               return CommandError{"too_many", "", "parts have 64 stiffnesses already; give all a factor of 1, or load the scene, to begin anew"};
                       }
                       edit([&](Edits& e) { e = wanted; });
                       return {};
                   },
                   [&](const command::Damping& damping) -> Result {
                       edit([&](Edits& e) { e.mass_damping = damping.mass, e.stiffness_damping = damping.stiffness; });
                       return {};
                   },
                   [&](const command::Order& order) -> Result {
                       stage_->set_order(order.value);
                       order_ = order.value;
                       state_urgent_ = true;
                       return {};
                   },
                   [&](const command::Levels& levels) -> Result {
                       stage_->set_levels(levels.min, levels.max);
                       levels_ = levels;
                       state_urgent_ = true;
                       return {};
                   },
                   [&](const command::Save& wanted) { return save(wanted); },
                   [&](const command::Restore& wanted) { return restore(wanted); },
                   [&](const command::RecordStart& wanted) { return start_recording(wanted); },
                   [&](const command::RecordStop&) -> Result {
                       stop_recording();
                       return {};
                   },
                   [&](const auto&) -> Result { return CommandError{"failed", "", "is not possible here"}; }},
        command);
}

void Session::set_playing(bool playing) {
    playing_ = playing;
    pending_steps_ = 0;
    rate_since_ = next_step_ = Clock::now();
    rate_steps_ = 0;
    state_.steps_per_second = 0;
    state_urgent_ = true;
}

/// What commands have set, on a stage that is new.
void Session::apply_settings() {
    if (gravity_) stage_->set_gravity(*gravity_);
    if (tolerance_) stage_->set_tolerance(*tolerance_);
    if (budget_) stage_->set_budget(static_cast<std::size_t>(budget_->tets), budget_->milliseconds);
    if (order_) stage_->set_order(*order_);
    if (levels_) stage_->set_levels(levels_->min, levels_->max);
    if (edits_ != Edits{}) stage_->set_edits(edits_);
}

/// In place of the present one, before the same viewers: they tell topologies apart by their epochs.
std::unique_ptr<Stage> Session::another_stage() const {
    auto stage = make_stage_();
    stage->number_fronts_from(epoch_);
    return stage;
}

void Session::edit(const std::function<void(Edits&)>& change) {
    Edits wanted = edits_;
    change(wanted);
    stage_->set_edits(wanted);  // or throws, and all stays
    edits_ = std::move(wanted);
    state_urgent_ = true;
}

std::optional<CommandError> Session::save(const command::Save& wanted) {
    if (!settings_.library.keeps()) return CommandError{"failed", "", "nothing is kept here; start the server with --data"};
    if (!is_plain_name(wanted.name + ".tfs")) return CommandError{"out_of_range", "/name", "is too long; use at most 60 characters"};
    if (find(settings_.library.states(), wanted.name + ".tfs"))
        return CommandError{"failed", "/name", "is there already; use another name"};
    if (settings_.library.states().size() >= settings_.files) return too_many_files("saved states");
    write_saved_state(settings_.library.new_state(wanted.name), {.scene = model_->scene.name,
                                                                 .time = stage_->time(),
                                                                 .order = order_.value_or(model_->scene.front.order),
                                                                 .levels = levels_,
                                                                 .edits = edits_,
                                                                 .snapshot = stage_->save_state()});
    return {};
}

/// On a new stage, so that a state that does not fit changes nothing. Pulls end: their clients are of another time.
std::optional<CommandError> Session::restore(const command::Restore& wanted) {
    const auto file = find(settings_.library.states(), wanted.name + ".tfs");
    if (!file) return CommandError{"unknown_name", "/name", "is not a saved state; see the command states"};
    const SavedState saved = read_saved_state(file->path);
    if (saved.scene != model_->scene.name)
        return CommandError{"failed", "/name", "is a state of the scene " + saved.scene + "; load that first"};
    const Snapshot snapshot = decode(saved.snapshot, wanted.name);
    auto stage = another_stage();
    stage->set_order(saved.order);
    if (saved.levels) stage->set_levels(saved.levels->min, saved.levels->max);
    stage->set_edits(saved.edits);
    stage->restore_state(saved.snapshot, wanted.name);
    for (const Snapshot::Pull& pull : snapshot.pulls) stage->end_pull(pull.id);
    stop_recording();
    stage_ = std::move(stage);
    pulls_.clear();
    pending_steps_ = 0;
    order_ = saved.order;
    levels_ = saved.levels;
    edits_ = saved.edits;
    gravity_ = Vec3(snapshot.gravity[0], snapshot.gravity[1], snapshot.gravity[2]);
    tolerance_ = snapshot.tolerance;
    budget_ = command::Budget{static_cast<int>(std::min<std::uint64_t>(snapshot.budget_tets, 1 << 28)), snapshot.budget_milliseconds};
    next_step_ = Clock::now();
    state_urgent_ = true;
    return {};
}

std::optional<CommandError> Session::start_recording(const command::RecordStart& wanted) {
    if (model_->recorded) return CommandError{"failed", "", "this is a recording already"};
    if (!settings_.library.keeps()) return CommandError{"failed", "", "nothing is kept here; start the server with --data"};
    if (recorder_ && recorder_->status().active)
        return CommandError{"failed", "", recorder_->status().name + " is being recorded; stop it first"};
    const std::string name = wanted.name.empty() ? dated_name(model_->scene.name) : wanted.name;
    if (!is_plain_name(name + ".tfr")) return CommandError{"out_of_range", "/name", "is too long; use at most 60 characters"};
    if (find(settings_.library.recordings(), name + ".tfr"))
        return CommandError{"failed", "/name", "is there already; use another name"};
    if (settings_.library.recordings().size() >= settings_.files) return too_many_files("recordings");
    const std::filesystem::path file = settings_.library.new_recording(name);
    recorder_ = std::make_unique<LiveRecording>(file, *model_,
                                                LiveRecording::Settings{.fps = wanted.fps,
                                                                        .field = wanted.field,
                                                                        .most_bytes = settings_.recording_bytes,
                                                                        .order = order_.value_or(model_->scene.front.order)});
    state_urgent_ = true;
    record();
    if (recorder_->status().active) return {};
    const std::string problem = settings_.library.without_folders(recorder_->status().problem);
    recorder_.reset();
    std::error_code ignored;
    std::filesystem::remove(file, ignored);  // it was never begun
    return CommandError{"failed", "", problem};
}

void Session::stop_recording() {
    if (!recorder_ || !recorder_->status().active) return;
    recorder_->finish();
    state_urgent_ = true;
}

/// What a client has just done, so that the recording says why the object moves as it does.
void Session::record_event(ClientId client, const Command& command) {
    if (!recorder_ || !recorder_->status().active) return;
    if (const auto json = recorded_json(client, command))
        if (!recorder_->add(RecordedEvent{stage_->time(), *json})) state_urgent_ = true;
}

/// After each step.
void Session::record() {
    if (!recorder_ || !recorder_->status().active || !recorder_->due()) return;
    if (!recorder_->add(*stage_->frame(state_.steps_per_second, recorder_->field()))) state_urgent_ = true;
}

}  // namespace tetfront
