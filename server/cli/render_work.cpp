#include "server/cli/render_work.hpp"

#include "engine/base/error.hpp"
#include "engine/base/hash.hpp"
#include "engine/scene/json_document.hpp"
#include "server/cli/video.hpp"
#include "server/render/colour_scale.hpp"
#include "server/session/recording.hpp"
#include "server/session/stage.hpp"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <memory>

namespace tetfront {

namespace {

/// "1280x720"
void parse_size(const std::string& text, View& view) {
    const char* const end = text.data() + text.size();
    const auto width = std::from_chars(text.data(), end, view.width);
    const bool cross = width.ec == std::errc{} && width.ptr != end && *width.ptr == 'x';
    const auto height = cross ? std::from_chars(width.ptr + 1, end, view.height) : width;
    if (!cross || height.ec != std::errc{} || height.ptr != end)
        throw InputError("--size", text, "is not of the form WIDTHxHEIGHT", "write for example --size 1920x1080");
    for (const int side : {view.width, view.height}) {
        if (side < 16 || side > 8192)
            throw InputError("--size", text, "has a side of " + std::to_string(side) + " pixels", "use 16 to 8192");
    }
}

/// The scene's view with what the command line says.
ViewSpec view_of(const RenderOptions& options, ViewSpec view) {
    if (options.view.starts_with('{'))
        view = parse_view(options.view, "--view", view);
    else if (!options.view.empty())
        view = parse_view(read_text_file(options.view), options.view, view);
    if (!options.colour.empty()) view = parse_view(R"({"colouring": ")" + options.colour + "\"}", "--colour", view);
    if (!options.range.empty()) {
        const std::size_t colon = options.range.find(':');
        if (colon == std::string::npos)
            throw InputError("--range", options.range, "is not of the form LOW:HIGH", "write for example --range 0:2e5");
        view = parse_view(
            R"({"range": [)" + options.range.substr(0, colon) + ", " + options.range.substr(colon + 1) + "]}", "--range", view);
    }
    if (!options.background.empty())
        view = parse_view(R"({"background": ")" + options.background + "\"}", "--background", view);
    if (!options.overlay.empty()) {
        const auto has = [&](const char* what) { return std::ranges::count(options.overlay, what) > 0; };
        view.wireframe = has("wireframe"), view.arrows = has("arrows"), view.legend = has("legend");
    }
    view.wireframe = view.wireframe || options.wireframe;
    view.surface = view.surface && !options.no_surface;
    view.legend = view.legend && !options.no_legend;
    if (options.camera == "keyframes" && view.keyframes.empty())
        throw InputError("--camera", "keyframes", "has none in the view", "add `keyframes` to the scene's view, or use --view");
    if (options.camera != "keyframes") view.keyframes.clear();
    return view;
}

void describe(Work& work, const RenderOptions& options, const std::string& name, const std::string& title, Hash settings) {
    SequenceOptions& s = work.sequence;
    s.frames = work.numbers.total;
    s.directory = options.directory;
    s.title = title.empty() ? name : title;
    s.turntable = options.camera == "turntable";
    s.png_level = options.png_level;
    settings.add(view_json(s.view)).add(options.size).add(options.camera).add(s.title).add(options.every);
    settings.add(options.supersampling).add(options.png_level).add(options.start_at).add(work.fps);
    settings.add(s.turntable ? s.frames : 0);
    char hash[32];
    std::snprintf(hash, sizeof hash, "%016llx", static_cast<unsigned long long>(settings.value()));
    s.text = {{"Software", std::string("tetfront ") + TETFRONT_VERSION}, {"Scene", name}};
    if (!title.empty()) s.text.emplace_back("Title", title);
    s.text.emplace_back("Command", options.command);
    s.text.emplace_back("View", view_json(s.view));
    s.text.emplace_back("Settings", hash);
}

Work simulate(const RenderOptions& options, const View& size) {
    if (options.jobs > 1)
        throw InputError("--jobs", std::to_string(options.jobs), "needs a recording, which processes can share",
                         "make one with tetfront record " + shell_quoted(options.scene.file) + " -o run.tfr --frames N");
    Work work;
    work.fps = (options.fps > 0 ? options.fps : 30) / options.every;
    work.numbers = parse_frame_numbers(options.frames, options.seconds, work.fps, 0);
    Scene scene = options.scene.load();
    scene.view = view_of(options, scene.view);
    if (options.stream.empty()) prepare_directory(options.directory);  // before the long work
    const std::shared_ptr<const Model> model = build_with_progress(scene, options.scene.cache(), options.json);
    work.sequence.view = make_view(scene.view, *model->frame_model, size.width, size.height);
    work.sequence.view.floor = floor_height(*model);
    work.sequence.view.supersampling = options.supersampling;
    Hash settings;
    settings.add(read_text_file(options.scene.file));
    for (const std::string& setting : options.scene.settings) settings.add(setting);
    describe(work, options, scene.name, scene.title, settings);
    const auto frames = std::make_shared<SimulatedFrames>(
        model, FrameTimes{work.fps, options.start_at, field_of(scene.view.colouring)});
    work.source = [frames](int number) { return (*frames)(number); };
    work.interrupted = [frames] { return frames->interrupted(); };
    work.complain = [frames] { frames->complain(); };
    return work;
}

Work replay(const RenderOptions& options, const View& size) {
    if (!options.scene.settings.empty())
        throw InputError("--set", options.scene.settings[0], "cannot change a recording", "use it with a scene");
    const auto recording = std::make_shared<Recording>(options.scene.file);
    const RecordingInfo& info = recording->info();
    Work work;
    work.fps = (options.fps > 0 ? options.fps : info.fps) / options.every;
    const auto count = static_cast<int>(std::min<std::size_t>(recording->frame_count(), 1'000'000));
    int start = 0;
    while (start < count && recording->time(static_cast<std::size_t>(start)) < options.start_at - 1e-9) ++start;
    if (start == count)
        throw InputError("--start-at", std::to_string(options.start_at), "is after the recording's last frame",
                         "it ends at " + std::to_string(recording->time(static_cast<std::size_t>(count - 1))) + " s");
    const int available = (count - 1 - start) / options.every + 1;
    work.numbers = parse_frame_numbers(options.frames, options.seconds, work.fps, available);
    if (options.frames.empty() && options.seconds > 0)
        work.numbers.last = std::min(work.numbers.last, static_cast<int>(options.seconds * work.fps + 0.5) - 1);
    ViewSpec spec = view_of(options, info.view);
    const Field field = field_of(spec.colouring);
    if (field != Field::none && field != info.field)
        throw InputError(options.scene.file, "--colour " + name(spec.colouring), "was not recorded",
                         "record it with --colour " + name(spec.colouring));
    // One range for the whole sequence, whichever part of it is asked for.
    if (field != Field::none && !spec.range && recording->field_high() > 0)
        spec.range = {0, readable_ceiling(recording->field_high())};
    if (options.stream.empty()) prepare_directory(options.directory);
    work.sequence.view = make_view(spec, *recording->model(), size.width, size.height);
    work.sequence.view.floor = info.floor;
    work.sequence.view.supersampling = options.supersampling;
    Hash settings;
    settings.add(info.name).add(view_json(info.view)).add(info.fps).add_range(recording->model()->young);
    settings.add_range(recording->model()->triangles).add(recording->field_high());
    describe(work, options, info.name, info.title, settings);
    const auto interruption = std::make_shared<Interruption>();
    work.source = [recording, start, every = options.every](int number) {
        return recording->frame(static_cast<std::size_t>(start + number * every));
    };
    work.interrupted = [interruption] { return interruption->asked(); };
    work.complain = [complete = recording->complete(), file = options.scene.file, count] {
        if (!complete)
            std::fprintf(stderr, "tetfront: %s was cut short; its %d whole frames were used\n", file.c_str(), count);
    };
    return work;
}

}  // namespace

Work prepare(const RenderOptions& options) {
    check_finite("--fps", options.fps), check_finite("--start-at", options.start_at);
    check_finite("--seconds", options.seconds);
    View size;
    parse_size(options.size, size);
    if (!std::filesystem::exists(options.scene.file))
        throw InputError(options.scene.file, "", "does not exist", "check the path");
    return is_recording(options.scene.file) ? replay(options, size) : simulate(options, size);
}

}  // namespace tetfront
