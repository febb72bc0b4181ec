#include "server/session/live_recording.hpp"

#include "engine/base/atomic_file.hpp"

#include <algorithm>
#include <cmath>

namespace tetfront {

namespace {
/// Colours by what is recorded; by levels where the scene's colours need more than that.
ViewSpec recorded_view(ViewSpec view, Field field) {
    const Colouring before = view.colouring;
    switch (field) {
        case Field::displacement: view.colouring = Colouring::displacement; break;
        case Field::strain: view.colouring = Colouring::strain; break;
        case Field::stress: view.colouring = Colouring::stress; break;
        case Field::error: view.colouring = Colouring::error; break;
        case Field::none:
            if (before != Colouring::stiffness) view.colouring = Colouring::level;
    }
    if (view.colouring != before) view.range.reset();
    return view;
}
}  // namespace

LiveRecording::LiveRecording(const std::filesystem::path& file, const SessionModel& model, const Settings& settings)
    : settings_(settings) {
    const double dt = model.scene.time_step;
    stride_ = static_cast<std::uint64_t>(std::max(1.0, std::round(1 / (settings.fps * dt))));
    writer_ = std::make_unique<RecordingWriter>(file,
                                                RecordingInfo{.name = model.scene.name,
                                                              .title = model.scene.title,
                                                              .software = std::string("tetfront ") + TETFRONT_VERSION,
                                                              .view = recorded_view(model.scene.view, settings.field),
                                                              .floor = model.floor,
                                                              .fps = 1 / (static_cast<double>(stride_) * dt),
                                                              .time_step = dt,
                                                              .order = settings.order,
                                                              .field = settings.field},
                                                *model.frame_model);
    status_ = {.active = true, .name = file.filename().string(), .frames = 0, .seconds = 0, .bytes = writer_->bytes(), .problem = ""};
}

bool LiveRecording::add(const Frame& frame) {
    if (status_.frames == 0) start_ = frame.status.time;
    return write([&](RecordingWriter& writer) {
        writer.add(frame);
        status_.frames = writer.frames();
        status_.seconds = frame.status.time - start_;
    });
}

bool LiveRecording::add(const RecordedEvent& event) {
    return write([&](RecordingWriter& writer) { writer.add(event); });
}

/// False: it has ended, by an error or at the limit.
bool LiveRecording::write(const std::function<void(RecordingWriter&)>& what) {
    try {
        what(*writer_);
    } catch (const OutputError& error) {
        end(error.what());
        return false;
    }
    status_.bytes = writer_->bytes();
    if (status_.bytes < settings_.most_bytes) return true;
    finish();
    if (status_.problem.empty()) status_.problem = "the limit of " + std::to_string(settings_.most_bytes) + " bytes is reached";
    return false;
}

void LiveRecording::finish() {
    if (!writer_) return;
    try {
        writer_->finish();
        status_.bytes = writer_->bytes();
        end("");
    } catch (const OutputError& error) {
        end(error.what());
    }
}

void LiveRecording::end(const std::string& problem) {
    writer_.reset();
    status_.active = false;
    status_.problem = problem;
    std::ranges::replace(status_.problem, '\n', ' ');
}

}  // namespace tetfront
