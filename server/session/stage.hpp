#pragma once
// What a session plays: a simulation that is stepped, or a recording whose frames follow each other.
//
//     const auto stage = play_simulation(model);            // or play_recording(recording)
//     while (stage->step()) show(stage->frame(0, Field::none));

#include "engine/scene/scene.hpp"
#include "engine/simulation/frame.hpp"
#include "engine/simulation/simulation.hpp"
#include "server/session/recording.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace tetfront {

/// What stays the same while a session lives.
struct SessionModel {
    Scene scene;  // of a recording: name, title, up, view, time_step (of a frame) and order only
    std::shared_ptr<const FrameModel> frame_model;
    std::optional<double> floor;  // [m] height of the floor in pictures
    struct Recorded {
        std::size_t frames = 0;
        double start = 0, end = 0;  // [s] simulated, of the first and the last frame
        Field field = Field::none;  // that every frame has
    };
    std::optional<Recorded> recorded;  // none: simulated live
};

class Stage {
 public:
    virtual ~Stage() = default;

    /// False: the recording is at its end, and nothing changed.
    virtual bool step() = 0;
    virtual void reset() = 0;
    /// To the last frame not after a moment [s]. Throws InputError for a simulation.
    virtual void seek(double time);
    /// [s] simulated.
    [[nodiscard]] virtual double time() const = 0;
    /// The present moment. A recording has the field that was recorded, whichever is asked for.
    virtual std::shared_ptr<const Frame> frame(double steps_per_second, Field field) = 0;

    /// As in Simulation; a recording has numbers of its own.
    virtual void number_fronts_from(std::uint32_t) {}

    // As in Simulation. Throw InputError for a recording.
    virtual void begin_pull(std::uint64_t pull, const SurfacePoint& point, const Vec3& target);
    virtual void move_pull(std::uint64_t pull, const Vec3& target);  // a recording: nothing
    virtual void end_pull(std::uint64_t pull);                       // a recording: nothing
    virtual void set_gravity(const Vec3& gravity);
    virtual void set_tolerance(double tolerance);
    virtual void set_budget(std::size_t tets, double milliseconds);
    /// The complete state as Simulation::snapshot() has it.
    [[nodiscard]] virtual std::string save_state() const;
    /// Also throws InputError for bytes that are no state of this model, and changes nothing then.
    virtual void restore_state(std::string_view state, const std::string& name);
    virtual void set_order(int order);
    virtual void set_levels(int min_level, int max_level);
    virtual void set_edits(const Edits& edits);
};

std::unique_ptr<Stage> play_simulation(const std::shared_ptr<const Model>& model);
SessionModel session_model(const Model& model);

std::unique_ptr<Stage> play_recording(std::shared_ptr<Recording> recording);
SessionModel session_model(const Recording& recording);

/// Height for a picture's floor: the rest box's lowest when the object stands there, that is, most of its lowest
/// twentieth is pinned; otherwise far enough below for it to hang and swing. None without pins: it would fall through.
std::optional<double> floor_height(const Model& model);

}  // namespace tetfront
