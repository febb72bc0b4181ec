// Speed of sequences of pictures, 1280x720 with 2x2 samples: the parts alone, the pipeline against its slowest part, and
// two processes against one; writes tests/reports/rendering.md.
//
//     build/release/tests/render_report [REPORT]          (from the repository's root, on an idle machine)

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <thread>

#include <sys/resource.h>

#include "engine/simulation/simulation.hpp"
#include "server/render/png.hpp"
#include "server/render/renderer.hpp"
#include "server/render/sequence.hpp"
#include "server/session/recording.hpp"
#include "server/session/stage.hpp"
#include "tests/support/blob_frame.hpp"
#include "tests/support/project.hpp"
#include "tests/support/report.hpp"
#include "tests/support/temporary_folder.hpp"

using namespace tetfront;
using namespace tetfront::testing;

namespace {

constexpr int frames = 60, job_frames = 240, steps_per_frame = 2, width = 1280, height = 720;

double since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

struct Parts {
    std::string what;
    std::size_t triangles = 0;
    double simulate = 0, render = 0, encode = 0, png_bytes = 0;  // [s] a frame, alone; [bytes]
    double pipeline = 0;                                         // [s] a frame
    double recording_bytes = 0;
    struct Job {
        double wall = 0, processor = 0;  // [s] a frame, start of the processes included
    } alone, one, two;                   // one job on one thread, one on all, two
};

double processor_seconds_of_children() {
    rusage used{};
    ::getrusage(RUSAGE_CHILDREN, &used);
    const auto seconds = [](const timeval& t) { return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec); };
    return seconds(used.ru_utime) + seconds(used.ru_stime);
}

/// Runs the program; `before`: what stands in front of it.
Parts::Job run(const std::string& before, const std::string& program, const std::string& arguments) {
    const auto start = std::chrono::steady_clock::now();
    const double used = processor_seconds_of_children();
    if (std::system((before + program + " " + arguments + " > /dev/null 2>&1").c_str()) != 0)
        throw std::runtime_error(program + " " + arguments + " failed");
    return {since(start) / job_frames, (processor_seconds_of_children() - used) / job_frames};
}

/// make(i): frame i, simulated anew when i is 0.
Parts measure(const std::string& what, View view, const std::function<std::shared_ptr<const Frame>(int)>& make,
              const std::string& program) {
    Parts parts;
    parts.what = what;
    const TemporaryFolder folder;
    auto start = std::chrono::steady_clock::now();
    std::vector<std::shared_ptr<const Frame>> all;
    for (int i = 0; i < frames; ++i) all.push_back(make(i));
    parts.simulate = since(start) / frames;
    parts.triangles = all[0]->model->triangles.size();
    std::vector<Image> images;
    {
        Renderer renderer;
        renderer.render(*all[0], view, what);  // compiles the shaders
        start = std::chrono::steady_clock::now();
        for (int i = 0; i < frames; ++i) images.push_back(renderer.render(*all[static_cast<std::size_t>(i)], view, what));
        parts.render = since(start) / frames;
    }
    start = std::chrono::steady_clock::now();
    for (const Image& image : images) parts.png_bytes += static_cast<double>(encode_png(image, {.level = 1, .text = {}}).size());
    parts.encode = since(start) / frames;
    parts.png_bytes /= frames;

    const SequenceReport report = render_sequence({.frames = frames, .numbers = {}, .directory = folder.path() / "a", .view = view, .title = what, .text = {}},
                                                  make, [](int) { return true; });
    parts.pipeline = report.seconds / frames;

    const auto file = folder.path() / "run.tfr";
    RecordingInfo info;
    info.name = what, info.view = view, info.floor = view.floor;
    RecordingWriter writer(file, info, *all[0]->model);
    for (int i = 0; i < job_frames; ++i) {  // there and back, so that nothing jumps
        Frame frame = *all[static_cast<std::size_t>(i / frames % 2 ? frames - 1 - i % frames : i % frames)];
        frame.status.time = i / info.fps;
        writer.add(frame);
    }
    writer.finish();
    parts.recording_bytes = static_cast<double>(writer.bytes()) / job_frames;
    const std::string render = "render " + file.string() + " --out ";
    parts.alone = run("LP_NUM_THREADS=1 ", program, render + (folder.path() / "alone").string() + " --threads 1");
    parts.one = run("", program, render + (folder.path() / "one").string());
    parts.two = run("", program, render + (folder.path() / "two").string() + " --jobs 2");
    return parts;
}

}  // namespace

int main(int argc, char** argv) {
    try {
        const std::filesystem::path root = source_folder();
        const std::string program = (std::filesystem::canonical("/proc/self/exe").parent_path().parent_path() / "server" / "tetfront").string();
        const std::filesystem::path file = argc > 1 ? argv[1] : root / "tests" / "reports" / "rendering.md";
        const auto model = build_model(load_scene(root / "assets" / "scenes" / "bunny.json"));
        View view = make_view(model->scene.view, *model->frame_model, width, height);
        view.floor = floor_height(*model);
        std::unique_ptr<Simulation> simulation;
        std::vector<Parts> all;
        all.push_back(measure("bunny", view, [&](int i) {
            if (i == 0) simulation = std::make_unique<Simulation>(model);
            for (int k = 0; i > 0 && k < steps_per_frame; ++k) simulation->step();
            return simulation->frame();
        }, program));
        const auto large = blob_frame(224);
        const View large_view = make_view({}, *large->model, width, height);
        all.push_back(measure("200k", large_view, [&](int i) {
            auto frame = std::make_shared<Frame>(*large);
            for (auto& p : frame->surface) p[0] += 0.05F * std::sin(0.1F * static_cast<float>(i) + 3 * p[2]);
            frame->status.time = i / 30.0;
            return frame;
        }, program));

        std::ofstream out(file);
        write_head(out, "Sequences of pictures", "build/release/tests/render_report");
        out << "\n" << frames << " frames of " << width << "x" << height << ", 2x2 samples, PNG level 1; the bunny takes "
            << steps_per_frame << " steps a frame, the lump of 200k triangles is moved and not simulated. Milliseconds a frame, each part\n"
            << "alone; together: the pipeline, in which they overlap, against its slowest part.\n\n"
            << "| scene | triangles | simulate | render | encode | sum | together | together / slowest | frames a second |\n"
            << "|---|---|---|---|---|---|---|---|---|\n";
        for (const Parts& p : all) {
            const double slowest = std::max({p.simulate, p.render, p.encode});
            out << "| " << p.what << " | " << p.triangles << " | " << number(1e3 * p.simulate) << " | " << number(1e3 * p.render) << " | "
                << number(1e3 * p.encode) << " | " << number(1e3 * (p.simulate + p.render + p.encode)) << " | " << number(1e3 * p.pipeline)
                << " | " << number(p.pipeline / slowest) << " | " << number(1 / p.pipeline) << " |\n";
        }
        out << "\nThe rasteriser uses every processor, so what overlaps with it takes from it: on " << std::thread::hardware_concurrency()
            << " processors the slowest part alone is not a bound that the whole can reach.\n\n"
            << job_frames << " frames from a recording, by processes of `tetfront render --jobs` (their start included). One job uses all processors, too,\n"
            << "as its rasteriser does; beside it the same on one thread. Processor time a frame says what is lost: where two jobs need more of it\n"
            << "than one on one thread, they are in each other's way.\n\n"
            << "| scene | recording [kB a frame] | PNG [kB] | 1 job on 1 thread [frames a second] | 1 job | 2 jobs | 2 jobs / 1 job | 2 jobs / 1 job on 1 thread | "
               "processor [ms a frame]: 1 job on 1 thread | 1 job | 2 jobs |\n|---|---|---|---|---|---|---|---|---|---|---|\n";
        for (const Parts& p : all)
            out << "| " << p.what << " | " << number(p.recording_bytes / 1e3) << " | " << number(p.png_bytes / 1e3) << " | " << number(1 / p.alone.wall)
                << " | " << number(1 / p.one.wall) << " | " << number(1 / p.two.wall) << " | " << number(p.one.wall / p.two.wall) << " | "
                << number(p.alone.wall / p.two.wall) << " | " << number(1e3 * p.alone.processor) << " | " << number(1e3 * p.one.processor) << " | "
                << number(1e3 * p.two.processor) << " |\n";
        out.close();
        if (!out) throw std::runtime_error(file.string() + ": cannot be written");
        std::cout << file.string() << "\n";
        return 0;
    } catch (const std::exception& error) {
        std::cerr << error.what() << "\n";
        return 1;
    }
}
