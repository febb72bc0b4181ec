#include "engine/base/error.hpp"
#include "server/cli/commands.hpp"
#include "server/cli/frame_work.hpp"
#include "server/render/colour_scale.hpp"
#include "server/session/recording.hpp"
#include "server/session/stage.hpp"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <vector>

#include <nlohmann/json.hpp>

namespace tetfront {

namespace {

struct RecordOptions {
    SceneArguments scene;
    std::string frames, file, colour;
    double seconds = 0, fps = 30, start_at = 0;
};

/// What the scene's timeline does, as the commands that would do it.
std::vector<RecordedEvent> timeline_events(const Scene& scene) {
    std::vector<RecordedEvent> events;
    for (const TimelineEvent& event : scene.timeline) {
        if (event.gravity) {
            const Vec3& g = *event.gravity;
            events.push_back({event.time, nlohmann::ordered_json{{"command", "gravity"}, {"value", {g[0], g[1], g[2]}}}.dump()});
        }
        if (event.release)
            events.push_back({event.time, nlohmann::ordered_json{{"command", "release"}, {"pin", *event.release}}.dump()});
    }
    std::ranges::stable_sort(events, {}, &RecordedEvent::time);
    return events;
}

int record(const RecordOptions& options) {
    check_finite("--fps", options.fps), check_finite("--start-at", options.start_at);
    check_finite("--seconds", options.seconds);
    const FrameNumbers numbers = parse_frame_numbers(options.frames, options.seconds, options.fps, 0);
    Scene scene = options.scene.load();
    if (!options.colour.empty())
        scene.view = parse_view("{\"colouring\": \"" + options.colour + "\"}", "--colour", scene.view);
    check_writable(options.file);
    const Field field = field_of(scene.view.colouring);
    const std::shared_ptr<const Model> model = build_with_progress(scene, options.scene.cache());
    RecordingWriter writer(options.file,
                           {.name = scene.name,
                            .title = scene.title,
                            .software = std::string("tetfront ") + TETFRONT_VERSION,
                            .view = scene.view,
                            .floor = floor_height(*model),
                            .fps = options.fps,
                            .time_step = scene.time_step,
                            .order = scene.front.order,
                            .field = field},
                           *model->frame_model);
    const std::vector<RecordedEvent> events = timeline_events(scene);
    auto next_event = events.begin();
    SimulatedFrames frames(model, {options.fps, options.start_at, field});
    const int count = numbers.last - numbers.first + 1;
    {
        FrameProgress progress(count);
        for (int i = numbers.first; i <= numbers.last && !frames.interrupted(); ++i) {
            const std::shared_ptr<const Frame> frame = frames(i);
            if (!frame) break;
            for (; next_event != events.end() && next_event->time < frame->status.time; ++next_event) writer.add(*next_event);
            writer.add(*frame);
            progress.show(i - numbers.first + 1);
        }
    }
    writer.finish();
    frames.complain();
    if (frames.interrupted())
        std::fprintf(stderr, "tetfront: stopped after %zu of %d frames\n", writer.frames(), count);
    std::printf("%zu frames in %s, %.3g MB: %.3g kB a frame\n", writer.frames(), options.file.c_str(),
                static_cast<double>(writer.bytes()) / 1e6,
                static_cast<double>(writer.bytes()) / 1e3 / static_cast<double>(std::max<std::size_t>(1, writer.frames())));
    return frames.interrupted() ? exit_interrupted : exit_ok;
}

}  // namespace

void add_record(CLI::App& program, Action& action) {
    CLI::App* command = program.add_subcommand("record", "Simulates into a file that render and serve show again");
    const auto options = std::make_shared<RecordOptions>();
    RecordOptions& o = *options;
    o.scene.add_to(*command);
    command->add_option("-o,--out", o.file, "Recording to write; a file of this name is replaced")
        ->required()
        ->type_name("FILE");
    add_frame_options(*command, o.frames, o.seconds, o.start_at);
    command->add_option("--fps", o.fps, "Frames per simulated second")
        ->check(CLI::Range(0.01, 10'000.0))
        ->capture_default_str();
    command->add_option("--colour", o.colour, "Colouring whose values are kept; default: as the scene says")
        ->check(CLI::IsMember(std::vector<std::string>(colouring_names.begin(), colouring_names.end())));
    command->callback([options, &action] { action = [options] { return record(*options); }; });
}

}  // namespace tetfront
