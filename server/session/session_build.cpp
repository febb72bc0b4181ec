// How a session gets its model: the first one before anything else, another scene beside the present one. All but the
// building runs on the simulation thread.
#include "server/session/session.hpp"

#include "engine/base/error.hpp"
#include "server/session/session_errors.hpp"

#include <limits>
#include <utility>

namespace tetfront {

bool Session::build() {
    try {
        if (scene_) {
            const auto model = build_first();
            if (!model) return false;
            use(model);
        } else {
            make_stage_ = [this] { return play_recording(recording_); };
            model_ = std::make_shared<const SessionModel>(session_model(*recording_));
            stage_ = make_stage_();
        }
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

/// Commands wait meanwhile, and each stage counts as one thing that the session is busy with. Null: the session stops.
std::shared_ptr<const Model> Session::build_first() {
    const Progress progress = [this](const std::string& what, double fraction) {
        note_busy();
        if (listener_.progress) listener_.progress(what, fraction);
    };
    note_busy();
    SceneBuild build([this] { return *scene_; }, std::numeric_limits<std::size_t>::max(), settings_.cache, progress, [this] { note_built(); });
    std::unique_lock lock(mutex_);
    wake_.wait(lock, [this] { return stopping_ || built_; });
    built_ = false;
    return stopping_ ? nullptr : build.take();
}

void Session::note_built() {
    const std::lock_guard lock(mutex_);
    built_ = true;
    wake_.notify_all();
}

void Session::use(const std::shared_ptr<const Model>& model) {
    auto session = std::make_shared<const SessionModel>(session_model(*model));
    stage_ = play_simulation(model);
    make_stage_ = [model] { return play_simulation(model); };
    model_ = std::move(session);
}

/// Errors that need no building are answered at once.
void Session::begin_load(const command::Load& wanted, Reply reply) {
    try {
        std::optional<CommandError> error;
        const auto file = settings_.library.scene_file(wanted.scene);
        if (!settings_.library.has_scenes())
            error = CommandError{"failed", "", "no scenes are served; start the server with --scenes"};
        else if (loading_)
            error = CommandError{"failed", "", "another scene is being loaded; wait for it"};
        else if (!file)
            error = CommandError{"unknown_name", "/scene", "is not a scene that is served; see the command scenes"};
        if (error) return reply(error);
        loading_ = std::make_unique<SceneBuild>([file = *file] { return load_scene(file); }, settings_.tets, settings_.cache, listener_.progress,
                                                [this] { note_built(); });
        loaded_ = std::move(reply);
    } catch (...) {  // no thread or no memory
        reply(CommandError{"failed", "", text_of(std::current_exception())});
    }
}

/// The other scene takes the place of the present one, or the present one goes on.
void Session::end_load() {
    const auto build = std::move(loading_);
    const Reply reply = std::exchange(loaded_, nullptr);
    std::optional<CommandError> error;
    try {
        use(build->take());
    } catch (const InputError& e) {
        error = refusal(e);
    } catch (...) {
        error = CommandError{"failed", "", text_of(std::current_exception())};
    }
    if (!error) {
        stop_recording();
        pulls_.clear();
        gravity_.reset(), tolerance_.reset(), budget_.reset(), order_.reset(), levels_.reset();
        edits_ = {};
        recording_.reset();
        failure_.clear();
        set_playing(playing_);
        frame_dirty_ = true;
        if (listener_.model) listener_.model(model_);
    } else if (listener_.progress) {
        listener_.progress("the other scene could not be built", 1);
    }
    reply(error);
}

}  // namespace tetfront
