#include "engine/base/error.hpp"
#include "engine/base/thread_limit.hpp"
#include "server/cli/commands.hpp"
#include "server/cli/render_jobs.hpp"
#include "server/cli/render_stream.hpp"
#include "server/cli/render_work.hpp"
#include "server/cli/video.hpp"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>

namespace tetfront {

namespace {

using Json = nlohmann::ordered_json;

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
    std::optional<ThreadLimit> limit;
    if (options.threads > 0) {
        limit.emplace(options.threads);
        ::setenv("LP_NUM_THREADS", std::to_string(options.threads).c_str(), 1);  // the rasteriser's; it is not loaded yet
    }
    if (!options.stream.empty()) check_stream(options);
    Work work = prepare(options);
    if (!options.stream.empty()) return render_to_stdout(work, options.stream, options.threads);
    const View& size = work.sequence.view;
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
    command->add_option("--view", o.view, "JSON file with an object as in the scene's `view`, or the object itself; replaces its keys")
        ->type_name("FILE|{...}");
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
    command->add_option("--stdout", o.stream, "No directory: all of them on stdout, as a zip file, one after the other, or, with ffmpeg, as a video")
        ->type_name("zip|png|mp4")
        ->check(CLI::IsMember({"zip", "png", "mp4"}));
    // From the process that started this job:
    command->add_option("--command", o.command)->group("");
    command->add_option("--threads", o.threads)->check(CLI::Range(1, 1024))->group("");
    command->callback([options, command, &action] {
        if (options->command.empty()) {
            // What the pictures say about their making must not depend on how the work was split.
            options->command = "tetfront render " + shell_quoted(options->scene.file);
            for (const CLI::Option* option : command->get_options()) {
                const std::string& option_name = option->get_name();
                if (option->count() == 0 || !option_name.starts_with("--")) continue;
                if (std::ranges::count(std::initializer_list<std::string>{"--out", "--jobs", "--resume", "--json", "--cache", "--no-cache", "--frames", "--seconds", "--video", "--stdout", "--threads"}, option_name)) continue;
                options->command += " " + option_name;
                if (option->get_expected_max() > 0 && option->get_type_size_max() > 0)
                    for (const std::string& value : option->results()) options->command += " " + shell_quoted(value);
            }
        }
        action = [options] { return render(*options); };
    });
}

}  // namespace tetfront
