#include "server/session/stage.hpp"

#include "engine/base/error.hpp"

#include <algorithm>
#include <utility>

namespace tetfront {

namespace {

[[noreturn]] void refuse() { throw InputError("", "", "a recording cannot be changed", "serve its scene instead"); }

class SimulationStage : public Stage {
 public:
    explicit SimulationStage(const std::shared_ptr<const Model>& model) : simulation_(model) {}

    bool step() override {
        time_ = simulation_.step().time;
        return true;
    }
    void reset() override {
        simulation_.reset();
        time_ = 0;
    }
    [[nodiscard]] double time() const override { return time_; }
    std::shared_ptr<const Frame> frame(double steps_per_second, Field field) override {
        return simulation_.frame(steps_per_second, field);
    }
    void number_fronts_from(std::uint32_t epoch) override { simulation_.number_fronts_from(epoch); }
    void begin_pull(std::uint64_t pull, const SurfacePoint& point, const Vec3& target) override {
        simulation_.begin_pull(pull, point, target);
    }
    void move_pull(std::uint64_t pull, const Vec3& target) override { simulation_.move_pull(pull, target); }
    void end_pull(std::uint64_t pull) override { simulation_.end_pull(pull); }
    void set_gravity(const Vec3& gravity) override { simulation_.set_gravity(gravity); }
    void set_tolerance(double tolerance) override { simulation_.set_tolerance(tolerance); }
    void set_budget(std::size_t tets, double milliseconds) override { simulation_.set_budget(tets, milliseconds); }
    [[nodiscard]] std::string save_state() const override { return simulation_.snapshot(); }
    void restore_state(std::string_view state, const std::string& name) override {
        simulation_.restore(state, name);
        time_ = simulation_.frame()->status.time;
    }
    void set_order(int order) override { simulation_.set_order(order); }
    void set_levels(int min_level, int max_level) override { simulation_.set_levels(min_level, max_level); }
    void set_edits(const Edits& edits) override { simulation_.set_edits(edits); }

 private:
    Simulation simulation_;
    double time_ = 0;  // [s]
};

class RecordingStage : public Stage {
 public:
    explicit RecordingStage(std::shared_ptr<Recording> recording) : recording_(std::move(recording)) {}

    bool step() override {
        if (at_ + 1 >= recording_->frame_count()) return false;
        ++at_;
        return true;
    }
    void reset() override { at_ = 0; }
    [[nodiscard]] double time() const override { return recording_->time(at_); }
    void seek(double time) override {
        std::size_t low = 0, high = recording_->frame_count();  // the last frame of [low, high) not after `time`, or low
        while (high - low > 1) {
            const std::size_t middle = (low + high) / 2;
            (recording_->time(middle) <= time + 1e-9 ? low : high) = middle;
        }
        at_ = low;
    }
    std::shared_ptr<const Frame> frame(double steps_per_second, Field) override {
        auto frame = std::make_shared<Frame>(*recording_->frame(at_));
        frame->status.steps_per_second = steps_per_second;
        return frame;
    }
    void move_pull(std::uint64_t, const Vec3&) override {}
    void end_pull(std::uint64_t) override {}

 private:
    std::shared_ptr<Recording> recording_;
    std::size_t at_ = 0;
};

}  // namespace

void Stage::seek(double) {
    throw InputError("", "", "a simulation cannot go to another time", "record it, and serve the recording");
}
void Stage::begin_pull(std::uint64_t, const SurfacePoint&, const Vec3&) { refuse(); }
void Stage::move_pull(std::uint64_t, const Vec3&) { refuse(); }
void Stage::end_pull(std::uint64_t) { refuse(); }
void Stage::set_gravity(const Vec3&) { refuse(); }
void Stage::set_tolerance(double) { refuse(); }
void Stage::set_budget(std::size_t, double) { refuse(); }
std::string Stage::save_state() const { refuse(); }
void Stage::restore_state(std::string_view, const std::string&) { refuse(); }
void Stage::set_order(int) { refuse(); }
void Stage::set_levels(int, int) { refuse(); }
void Stage::set_edits(const Edits&) { refuse(); }

std::unique_ptr<Stage> play_simulation(const std::shared_ptr<const Model>& model) {
    return std::make_unique<SimulationStage>(model);
}

SessionModel session_model(const Model& model) {
    return {.scene = model.scene, .frame_model = model.frame_model, .floor = floor_height(model), .recorded = {}};
}

std::unique_ptr<Stage> play_recording(std::shared_ptr<Recording> recording) {
    return std::make_unique<RecordingStage>(std::move(recording));
}

SessionModel session_model(const Recording& recording) {
    const RecordingInfo& info = recording.info();
    SessionModel model{.scene = {}, .frame_model = recording.model(), .floor = info.floor, .recorded = {}};
    model.scene.name = info.name, model.scene.title = info.title, model.scene.view = info.view;
    model.scene.up = recording.model()->up;
    model.scene.time_step = 1 / info.fps;
    model.scene.front.order = info.order;
    const std::size_t frames = recording.frame_count();
    model.recorded = {frames, recording.time(0), recording.time(frames - 1), info.field};
    return model;
}

std::optional<double> floor_height(const Model& model) {
    if (model.scene.ground) return model.scene.ground->height;
    if (!model.has_pins) return std::nullopt;
    const auto& box = model.frame_model->rest_box;
    const auto up = static_cast<std::size_t>(model.frame_model->up);
    const double low = box[up], height = box[up + 3] - box[up];
    std::size_t lowest = 0, pinned = 0;
    for (const VertexId v : ids<VertexId>(model.tree.vertex_count())) {
        if (model.tree.rest(v)[model.frame_model->up] > low + height / 20) continue;
        ++lowest;
        pinned += model.pinned[v] ? 1 : 0;
    }
    return 2 * pinned >= lowest ? low : low - std::max(0.5 * height, 0.6 * model.size);
}

}  // namespace tetfront
