#include "engine/base/error.hpp"
#include "engine/base/hash.hpp"
#include "engine/scene/json_document.hpp"
#include "server/cli/commands.hpp"
#include "server/cli/frame_work.hpp"
#include "server/cli/render_jobs.hpp"
#include "server/cli/video.hpp"
#include "server/render/colour_scale.hpp"
#include "server/render/sequence.hpp"
#include "server/session/recording.hpp"
#include "server/session/stage.hpp"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include <nlohmann/json.hpp>

namespace tetfront {

namespace {

using Json = nlohmann::ordered_json;

struct RenderOptions {
    SceneArguments scene;
    std::string frames, view, colour, command;
    double seconds = 0, fps = 0, start_at = 0;  // fps 0: 30, or the recording's
    int every = 1, jobs = 1;
    std::string size = "1280x720", directory = "frames", camera = "fixed", background, range, video;
    std::vector<std::string> overlay;
    bool wireframe = false, no_surface = false, no_legend = false, resume = false, json = false;
    int supersampling = 2, png_level = 1;
};

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
    if (!options.view.empty()) view = parse_view(read_text_file(options.view), options.view, view);
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

/// Where frames come from, and what is the same for all of them.
struct Work {
    SequenceOptions sequence;
    FrameNumbers numbers;
    double fps = 30;
    FrameSource source;
    std::function<bool()> interrupted;
    std::function<void()> complain;
};

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
    prepare_directory(options.directory);  // before the long work
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
    prepare_directory(options.directory);
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

/// A file that a killed process was writing: "000012.png.XXXXXX", of one of these frames.
void remove_leftovers(const std::filesystem::path& directory, const FrameNumbers& numbers) {
    std::error_code ignored;
    for (const auto& entry : std::filesystem::directory_iterator(directory, ignored)) {
        const std::string file = entry.path().filename().string();
        int number = -1;
        const auto parsed = std::from_chars(file.data(), file.data() + file.size(), number);
        const std::string frame = frame_name(number);
        if (parsed.ec == std::errc{} && number >= numbers.first && number <= numbers.last &&
            file.size() == frame.size() + 7 && file.starts_with(frame + "."))
            std::filesystem::remove(entry.path(), ignored);
    }
}

/// Those that are not there yet, when the work goes on; else all. Throws InputError when those that are there were made
/// in another way.
std::vector<int> numbers_to_write(const RenderOptions& options, const Work& work) {
    const auto setting = std::ranges::find(work.sequence.text, "Settings", [](const auto& text) { return text.first; });
    bool checked = false;
    std::vector<int> numbers;
    for (int i = work.numbers.first; i <= work.numbers.last; ++i) {
        const std::filesystem::path file = work.sequence.directory / frame_name(i);
        if (!options.resume || !std::filesystem::is_regular_file(file)) {
            numbers.push_back(i);
            continue;
        }
        if (!std::exchange(checked, true) && read_png_text(file, "Settings") != setting->second)
            throw InputError(file.string(), "", "was made from another scene or with other options",
                             "give the same options again, or another --out");
    }
    return numbers;
}

void print_event(const Json& event) {
    std::printf("%s\n", event.dump(-1, ' ', false, Json::error_handler_t::replace).c_str());
    std::fflush(stdout);
}

/// What the jobs are started with: this command without what concerns all of them.
std::vector<std::string> job_arguments(const RenderOptions& o) {
    const auto number = [](double x) {
        char text[32];
        std::snprintf(text, sizeof text, "%.17g", x);
        return std::string(text);
    };
    std::vector<std::string> words = {"render", o.scene.file, "--out", o.directory, "--size", o.size, "--camera", o.camera,
                                      "--every", std::to_string(o.every), "--start-at", number(o.start_at),
                                      "--supersampling", std::to_string(o.supersampling), "--png-level",
                                      std::to_string(o.png_level), "--command", o.command};
    const auto add = [&](const char* option, const std::string& value) {
        if (!value.empty()) words.insert(words.end(), {option, value});
    };
    add("--view", o.view), add("--colour", o.colour), add("--range", o.range), add("--background", o.background);
    if (o.fps > 0) add("--fps", number(o.fps));
    for (const std::string& what : o.overlay) add("--overlay", what);
    for (const auto& [flag, set] : {std::pair{"--wireframe", o.wireframe}, {"--no-surface", o.no_surface}, {"--no-legend", o.no_legend}, {"--resume", o.resume}})
        if (set) words.emplace_back(flag);
    return words;
}

int render(const RenderOptions& options) {
    check_finite("--fps", options.fps), check_finite("--start-at", options.start_at);
    check_finite("--seconds", options.seconds);
    View size;
    parse_size(options.size, size);
    if (!std::filesystem::exists(options.scene.file))
        throw InputError(options.scene.file, "", "does not exist", "check the path");
    Work work = is_recording(options.scene.file) ? replay(options, size) : simulate(options, size);
    std::vector<int>& numbers = work.sequence.numbers;
    numbers = numbers_to_write(options, work);
    if (options.resume) remove_leftovers(options.directory, work.numbers);
    const int count = work.numbers.last - work.numbers.first + 1, missing = static_cast<int>(numbers.size());
    const VideoJob video{.directory = options.directory,
                         .first = work.numbers.first,
                         .count = count,
                         .fps = work.fps,
                         .even = size.width % 2 == 0 && size.height % 2 == 0,
                         .file = options.video};
    if (options.json)
        print_event({{"event", "start"}, {"frames", count}, {"missing", missing}, {"directory", options.directory},
                     {"size", {size.width, size.height}}, {"fps", work.fps}});
    SequenceReport report;
    const auto start = std::chrono::steady_clock::now();
    int status = exit_ok;
    if (missing > 0) {
        FrameProgress progress(missing, options.json);
        const auto wrote = [&](int number, int written) {
            if (options.json)
                print_event({{"event", "frame"},
                             {"frame", number},
                             {"file", (work.sequence.directory / frame_name(number)).string()},
                             {"written", written}});
            progress.show(written);
        };
        if (options.jobs > 1) {
            status = run_jobs(job_arguments(options), numbers, options.jobs,
                              [&](int number) { wrote(number, ++report.written); });
            report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        } else {
            report = render_sequence(work.sequence, work.source, [&](int written) {
                wrote(numbers[static_cast<std::size_t>(written - 1)], written);
                return !work.interrupted();
            });
        }
    }
    work.complain();
    if (status == exit_ok && report.written < missing) status = exit_interrupted;
    if (status == exit_interrupted)
        std::fprintf(stderr, "tetfront: stopped after %d of %d frames\n", report.written, missing);
    else if (status != exit_ok)
        return status;  // the job has said why
    const double each = 1000.0 / std::max(report.written, 1);
    if (options.json) {
        print_event({{"event", "end"}, {"written", report.written}, {"seconds", report.seconds},
                     {"simulate", report.simulate}, {"render", report.render}, {"encode", report.encode},
                     {"ffmpeg", command_line(video)}});
    } else {
        std::printf("%d frames in %s, %.3g s: %.3g a second", report.written, options.directory.c_str(), report.seconds,
                    report.written / std::max(report.seconds, 1e-9));
        if (options.jobs == 1 && report.written > 0)
            std::printf(" (simulate %.3g, render %.3g, encode %.3g ms a frame)", each * report.simulate,
                        each * report.render, each * report.encode);
        std::printf("\n");
    }
    if (status != exit_ok) return status;
    if (!options.video.empty() && run_ffmpeg(video)) {
        if (!options.json) std::printf("%s\n", options.video.c_str());
    } else if (!options.json) {
        std::printf(options.video.empty() ? "To make a video of them:\n%s\n"
                                          : "There is no ffmpeg here; to make the video:\n%s\n",
                    command_line(video).c_str());
    }
    return status;
}

}  // namespace

void add_render(CLI::App& program, Action& action) {
    CLI::App* command =
        program.add_subcommand("render", "Writes a sequence of PNG files of a scene or a recording, without a display");
    const auto options = std::make_shared<RenderOptions>();
    RenderOptions& o = *options;
    o.scene.add_to(*command);
    add_frame_options(*command, o.frames, o.seconds, o.start_at);
    command->add_option("--fps", o.fps, "Frames per simulated second; default: 30, or the recording's")
        ->check(CLI::Range(0.01, 10'000.0));
    command->add_option("--every", o.every, "Only every K-th of them, numbered anew")
        ->type_name("K")
        ->check(CLI::Range(1, 1'000'000))
        ->capture_default_str();
    command->add_option("--size", o.size, "Pixels, each side 16 to 8192")
        ->type_name("WIDTHxHEIGHT")
        ->capture_default_str();
    command->add_option("--out", o.directory, "Directory for 000000.png ...; files of the same names are replaced")
        ->type_name("DIR")
        ->capture_default_str();
    command->add_flag("--resume", o.resume, "Keeps the files that are there and writes those that are missing");
    command->add_option("--jobs", o.jobs, "Processes that render at a time; needs a recording")
        ->check(CLI::Range(1, 256))
        ->capture_default_str();
    command->add_option("--view", o.view, "JSON file with an object as in the scene's `view`; replaces its keys")
        ->type_name("FILE");
    command
        ->add_option("--colour", o.colour,
                     "What colours show: level, stiffness, displacement, strain, stress or error; default: as the scene says")
        ->check(CLI::IsMember(std::vector<std::string>(colouring_names.begin(), colouring_names.end())));
    command->add_option("--range", o.range, "What the ends of the colours mean; default: fitted to the values")
        ->type_name("LOW:HIGH");
    command->add_option("--overlay", o.overlay, "Exactly these of wireframe, arrows, legend; or none")
        ->delimiter(',')
        ->check(CLI::IsMember({"wireframe", "arrows", "legend", "none"}));
    command->add_flag("--wireframe", o.wireframe, "Shows the edges of the tetrahedra, too");
    command->add_flag("--no-surface", o.no_surface, "Shows nothing but the edges of the tetrahedra");
    command->add_flag("--no-legend", o.no_legend, "No title, numbers and legend");
    command->add_option("--camera", o.camera, "fixed; turntable: once around; keyframes: the view's")
        ->check(CLI::IsMember({"fixed", "turntable", "keyframes"}))
        ->capture_default_str();
    command->add_option("--background", o.background, "light, dark or transparent; default: as the scene says")
        ->check(CLI::IsMember({"light", "dark", "transparent"}));
    command->add_option("--supersampling", o.supersampling, "Samples along each side of a pixel")
        ->check(CLI::Range(1, 4))
        ->capture_default_str();
    command->add_option("--png-level", o.png_level, "Compression, 0 fast to 9 small")
        ->check(CLI::Range(0, 9))
        ->capture_default_str();
    command->add_option("--video", o.video, "Also makes this video of them, with ffmpeg: .mp4, .mkv, .mov ..., or .webp, .apng, .gif that go round")->type_name("FILE");
    command->add_flag("--json", o.json, "Tells on stdout in JSON lines how far it is, for programs");
    command->add_option("--command", o.command)->group("");  // of the process that started this job
    command->callback([options, command, &action] {
        if (options->command.empty()) {
            // What the pictures say about their making must not depend on how the work was split.
            options->command = "tetfront render " + shell_quoted(options->scene.file);
            for (const CLI::Option* option : command->get_options()) {
                const std::string& option_name = option->get_name();
                if (option->count() == 0 || !option_name.starts_with("--")) continue;
                if (std::ranges::count(std::initializer_list<std::string>{"--out", "--jobs", "--resume", "--json", "--cache", "--no-cache", "--frames", "--seconds", "--video"}, option_name)) continue;
                options->command += " " + option_name;
                if (option->get_expected_max() > 0 && option->get_type_size_max() > 0)
                    for (const std::string& value : option->results()) options->command += " " + shell_quoted(value);
            }
        }
        action = [options] { return render(*options); };
    });
}

}  // namespace tetfront
