#include "engine/base/error.hpp"
#include "engine/simulation/simulation.hpp"
#include "server/cli/commands.hpp"
#include "server/cli/progress_bar.hpp"
#include "server/render/sequence.hpp"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include <unistd.h>

namespace tetfront {

namespace {

constexpr int exit_interrupted = 130;  // what shells expect after Ctrl-C

struct RenderOptions {
    SceneArguments scene;
    int frames = 0;
    double fps = 30, start_at = 0;
    std::string size = "1280x720", directory = "frames", colour, camera = "fixed", background = "light";
    bool wireframe = false, no_surface = false, no_legend = false;
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

/// While it lives, the first Ctrl-C asks for an end after the frames on their way; the second one kills.
class Interruption {
 public:
    Interruption() {
        struct sigaction action {};
        action.sa_handler = [](int) { asked_ = 1; };
        action.sa_flags = static_cast<int>(SA_RESETHAND);
        asked_ = 0;
        ::sigaction(SIGINT, &action, &before_);
    }
    ~Interruption() { ::sigaction(SIGINT, &before_, nullptr); }
    Interruption(const Interruption&) = delete;
    Interruption& operator=(const Interruption&) = delete;

    [[nodiscard]] bool asked() const { return asked_ != 0; }

 private:
    static inline volatile std::sig_atomic_t asked_ = 0;
    struct sigaction before_ {};
};

/// How far the work is: a bar on a terminal, a line every tenth elsewhere.
class FrameProgress {
 public:
    explicit FrameProgress(int total) : total_(total) {}

    void show(int done) {
        const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
        const double rate = done / std::max(seconds, 1e-9);
        char text[160];
        std::snprintf(text, sizeof text, "frame %d/%d  %.1f a second  %s left", done, total_, rate,
                      duration((total_ - done) / rate).c_str());
        if (::isatty(STDERR_FILENO)) return bar_.show(text, static_cast<double>(done) / total_);
        if (done * 10LL / total_ > (done - 1) * 10LL / total_) std::fprintf(stderr, "%s\n", text);
    }

 private:
    static std::string duration(double seconds) {
        char text[64];
        if (seconds < 90)
            std::snprintf(text, sizeof text, "%.0f s", seconds);
        else if (seconds < 5400)
            std::snprintf(text, sizeof text, "%.0f min", seconds / 60);
        else
            std::snprintf(text, sizeof text, "%.1f h", seconds / 3600);
        return text;
    }

    int total_;
    ProgressBar bar_{""};
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

std::string shell_quoted(const std::string& word) {
    if (word.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-/%+=:,@") ==
        std::string::npos)
        return word;
    std::string quoted = "'";
    for (const char c : word) c == '\'' ? quoted += "'\\''" : quoted += c;
    return quoted + "'";
}

std::string ffmpeg_line(const RenderOptions& options, const View& view, int frames) {
    std::filesystem::path directory = std::filesystem::path(options.directory).lexically_normal();
    if (!directory.has_filename()) directory = directory.parent_path();
    std::string pattern;
    for (const char c : directory.string()) pattern += c == '%' ? "%%" : std::string(1, c);
    pattern += "/%06d.png";
    const std::string name = directory.filename().string();
    const std::string video = (name.empty() || name == "." || name == ".." ? "frames" : name) + ".mp4";
    char fps[32];
    std::snprintf(fps, sizeof fps, "%.10g", options.fps);
    // yuv420p, which all players show, needs even sides.
    const bool odd = view.width % 2 || view.height % 2;
    return "ffmpeg -framerate " + std::string(fps) + " -i " + shell_quoted(pattern) + " -frames:v " +
           std::to_string(frames) + (odd ? " -vf 'pad=ceil(iw/2)*2:ceil(ih/2)*2'" : "") +
           " -c:v libx264 -crf 18 -pix_fmt yuv420p " + shell_quoted(video);
}

View view_of(const RenderOptions& options, const Model& model, View size) {
    View view = make_view(model.scene.view, *model.frame_model, size.width, size.height);
    view.floor = floor_height(model);
    view.supersampling = options.supersampling;
    if (!options.colour.empty()) view.colouring = parse_colouring(options.colour);
    view.wireframe = view.wireframe || options.wireframe;
    view.surface = !options.no_surface;
    view.legend = !options.no_legend;
    view.background = options.background == "dark"          ? Background::dark
                      : options.background == "transparent" ? Background::transparent
                                                            : Background::light;
    return view;
}

/// Steps to each frame's moment; keeps what the steps complained about for the frame to show.
class SimulatedFrames {
 public:
    SimulatedFrames(const std::shared_ptr<const Model>& model, const RenderOptions& options)
        : simulation_(model), options_(options), time_step_(model->scene.time_step) {}

    std::shared_ptr<const Frame> operator()(int index) {
        const std::int64_t until = steps_until_frame(index, options_.fps, options_.start_at, time_step_);
        for (; steps_ < until && !interruption_.asked(); ++steps_) troubled_steps_ += trouble(simulation_.step());
        return simulation_.frame();
    }
    [[nodiscard]] std::int64_t steps() const { return steps_; }
    [[nodiscard]] std::int64_t troubled_steps() const { return troubled_steps_; }
    [[nodiscard]] bool interrupted() const { return interruption_.asked(); }

 private:
    static int trouble(const StepReport& r) { return !r.converged || r.rejected || r.inverted_tets > 0; }

    Simulation simulation_;
    const RenderOptions& options_;
    double time_step_;
    std::int64_t steps_ = 0, troubled_steps_ = 0;
    Interruption interruption_;
};

int render(const RenderOptions& options) {
    // CLI::Range lets nan pass.
    if (!std::isfinite(options.fps)) throw InputError("--fps", "", "is not a number", "use 0.01 to 10000");
    if (!std::isfinite(options.start_at)) throw InputError("--start-at", "", "is not a number", "use 0 to 86400");
    View size;
    parse_size(options.size, size);
    const Scene scene = options.scene.load();
    SequenceReport report;
    SequenceOptions sequence;
    try {
        prepare_directory(options.directory);  // before the long work
        std::shared_ptr<const Model> model;
        {
            ProgressBar bar("");
            model = build_model(
                scene, [&bar](const std::string& what, double done) { bar.show(what, done); }, options.scene.cache());
        }
        sequence = {.frames = options.frames,
                    .directory = options.directory,
                    .view = view_of(options, *model, size),
                    .title = scene.title.empty() ? scene.name : scene.title,
                    .turntable = options.camera == "turntable",
                    .png_level = options.png_level,
                    .text = {{"Software", std::string("tetfront ") + TETFRONT_VERSION}, {"Scene", scene.name}}};
        if (!scene.title.empty()) sequence.text.emplace_back("Title", scene.title);
        SimulatedFrames frames(model, options);
        {
            FrameProgress progress(options.frames);
            report = render_sequence(sequence, std::ref(frames), [&](int written) {
                progress.show(written);
                return !frames.interrupted();
            });
        }
        if (frames.troubled_steps() > 0)
            std::fprintf(stderr, "tetfront: %lld of %lld steps did not converge, were rejected or left inverted tets\n",
                         static_cast<long long>(frames.troubled_steps()), static_cast<long long>(frames.steps()));
    } catch (const WriteError& error) {
        throw OutputError(error.what());
    }
    if (report.written < options.frames)
        std::fprintf(stderr, "tetfront: stopped after %d of %d frames\n", report.written, options.frames);
    const double each = 1000.0 / std::max(report.written, 1);
    std::printf("%d frames in %s, %.3g s: %.3g a second (simulate %.3g, render %.3g, encode %.3g ms a frame)\n",
                report.written, options.directory.c_str(), report.seconds, report.written / report.seconds,
                each * report.simulate, each * report.render, each * report.encode);
    if (report.written > 0)
        std::printf("To make a video of them:\n%s\n", ffmpeg_line(options, sequence.view, report.written).c_str());
    return report.written < options.frames ? exit_interrupted : exit_ok;
}

}  // namespace

void add_render(CLI::App& program, Action& action) {
    CLI::App* command =
        program.add_subcommand("render", "Simulates and writes a sequence of PNG files, without a display");
    const auto options = std::make_shared<RenderOptions>();
    RenderOptions& o = *options;
    o.scene.add_to(*command);
    command->add_option("--frames", o.frames, "How many")->required()->check(CLI::Range(1, 1'000'000));
    command->add_option("--fps", o.fps, "Frames per simulated second")
        ->check(CLI::Range(0.01, 10'000.0))
        ->capture_default_str();
    command->add_option("--start-at", o.start_at, "Simulated time of frame 0 [s]")
        ->check(CLI::Range(0.0, 86'400.0))
        ->capture_default_str();
    command->add_option("--size", o.size, "Pixels, each side 16 to 8192")
        ->type_name("WIDTHxHEIGHT")
        ->capture_default_str();
    command->add_option("--out", o.directory, "Directory for 000000.png ...; files of the same names are replaced")
        ->type_name("DIR")
        ->capture_default_str();
    command->add_option("--colour", o.colour, "What colours show: level, stiffness; default: as the scene says")
        ->check(CLI::IsMember({"level", "stiffness"}));
    command->add_flag("--wireframe", o.wireframe, "Shows the edges of the tetrahedra, too");
    command->add_flag("--no-surface", o.no_surface, "Shows nothing but the edges of the tetrahedra");
    command->add_flag("--no-legend", o.no_legend, "No title, numbers and legend");
    command->add_option("--camera", o.camera, "fixed, or turntable: once around")
        ->check(CLI::IsMember({"fixed", "turntable"}))
        ->capture_default_str();
    command->add_option("--background", o.background, "light, dark or transparent")
        ->check(CLI::IsMember({"light", "dark", "transparent"}))
        ->capture_default_str();
    command->add_option("--supersampling", o.supersampling, "Samples along each side of a pixel")
        ->check(CLI::Range(1, 4))
        ->capture_default_str();
    command->add_option("--png-level", o.png_level, "Compression, 0 fast to 9 small")
        ->check(CLI::Range(0, 9))
        ->capture_default_str();
    command->callback([options, &action] { action = [options] { return render(*options); }; });
}

}  // namespace tetfront
