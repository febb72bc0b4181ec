// How a session gets its model: the first one before anything else, another scene beside the present one. All but the building
// of another scene runs on the simulation thread.
#include "server/session/session.hpp"

#include "engine/base/error.hpp"
#include "server/session/session_errors.hpp"

#include <algorithm>
#include <utility>

namespace tetfront {

namespace {
struct BuildStopped {};  // thrown through build_model() by its progress callback
}  // namespace

bool Session::build() {
    try {
        if (scene_) {
            build_scene(*scene_);
        } else {
            make_stage_ = [this] { return play_recording(recording_); };
            model_ = std::make_shared<const SessionModel>(session_model(*recording_));
            stage_ = make_stage_();
        }
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

void Session::build_scene(const Scene& scene) {
    const Progress progress = [this](const std::string& what, double fraction) {
        {
            const std::lock_guard lock(mutex_);
            if (stopping_) throw BuildStopped{};
        }
        note_busy();
        if (listener_.progress) listener_.progress(what, fraction);
    };
    note_busy();
    use(build_model(scene, progress, settings_.cache));
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
        const auto names = settings_.library.scenes();
        if (!settings_.library.has_scenes())
            error = CommandError{"failed", "", "no scenes are served; start the server with --scenes"};
        else if (loading_)
            error = CommandError{"failed", "", "another scene is being loaded; wait for it"};
        else if (std::ranges::find(names, wanted.scene, &Library::SceneEntry::name) == names.end())
            error = CommandError{"unknown_name", "/scene", "is not a scene that is served; see the command scenes"};
        if (error) return reply(error);
        const auto done = [this] {
            const std::lock_guard lock(mutex_);
            built_ = true;
            wake_.notify_all();
        };
        loading_ = std::make_unique<SceneBuild>(settings_.library.load(wanted.scene), settings_.tets, settings_.cache, listener_.progress, done);
        loaded_ = std::move(reply);
    } catch (const InputError& e) {
        reply(refusal(e));
    } catch (...) {
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
        gravity_.reset(), tolerance_.reset(), budget_.reset(), order_.reset();
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
