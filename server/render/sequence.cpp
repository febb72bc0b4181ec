#include "server/render/sequence.hpp"

#include "engine/base/atomic_file.hpp"
#include "engine/base/error.hpp"
#include "server/render/bounded_queue.hpp"
#include "server/render/renderer.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <mutex>
#include <thread>

namespace tetfront {

namespace {

class Stopwatch {
 public:
    [[nodiscard]] double seconds() const {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    }

 private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// The stages and what runs between them. A stage that fails closes every queue, so that all others end.
class Pipeline {
 public:
    Pipeline(const SequenceOptions& options, const FrameSource& source) : options_(options), source_(source) {}

    SequenceReport run(const std::function<bool(int)>& progress) {
        const Stopwatch total;
        {
            std::jthread simulate([this] { guarded([this] { simulate_all(); }); });
            std::jthread render([this] { guarded([this] { render_all(); }); });
            std::jthread encode([this] { guarded([this] { encode_all(); }); });
            guarded([&] {
                while (const auto written = written_.pop()) {
                    report_.written = *written;
                    if (!progress(*written)) frames_.close();  // what has been simulated is still written
                }
            });
        }
        if (failure_) std::rethrow_exception(failure_);
        report_.seconds = total.seconds();
        return report_;
    }

 private:
    struct Simulated {
        int index;
        std::shared_ptr<const Frame> frame;
    };
    struct Rendered {
        int index;
        double time;
        Image image;
    };

    template <class Work>
    void guarded(const Work& work) {
        try {
            work();
        } catch (...) {
            {
                const std::lock_guard lock(failure_mutex_);
                if (!failure_) failure_ = std::current_exception();
            }
            frames_.close(), images_.close(), written_.close();
        }
    }

    void simulate_all() {
        const bool all = options_.numbers.empty();
        const int count = all ? options_.frames : static_cast<int>(options_.numbers.size());
        for (int i = 0; i < count; ++i) {
            const int number = all ? i : options_.numbers[static_cast<std::size_t>(i)];
            const Stopwatch watch;
            Simulated next{number, source_(number)};
            report_.simulate += watch.seconds();
            if (!next.frame) break;
            if (!frames_.push(std::move(next))) return;
        }
        frames_.close();
    }

    void render_all() {
        Renderer renderer;
        while (const auto next = frames_.pop()) {
            const Stopwatch watch;
            const double turns = static_cast<double>(next->index) / options_.frames;
            View view = at_time(options_.view, next->frame->status.time);
            if (options_.turntable) view = turntable(view, turns);
            Rendered done{next->index, next->frame->status.time, renderer.render(*next->frame, view, options_.title)};
            report_.render += watch.seconds();
            if (!images_.push(std::move(done))) return;
        }
        images_.close();
    }

    void encode_all() {
        int written = 0;
        while (const auto next = images_.pop()) {
            const Stopwatch watch;
            char time[32];
            std::snprintf(time, sizeof time, "%.6f", next->time);
            PngOptions png{options_.png_level, options_.text};
            png.text.emplace_back("Frame", std::to_string(next->index));
            png.text.emplace_back("Time", time);
            const std::string name = frame_name(next->index), bytes = encode_png(next->image, png);
            if (options_.write)
                options_.write(name, bytes);
            else
                write_atomically(options_.directory / name, bytes, Durable::no);
            report_.encode += watch.seconds();
            if (!written_.push(++written)) return;
        }
        written_.close();
    }

    const SequenceOptions& options_;
    const FrameSource& source_;
    // Two frames ahead hide the stages' different rhythms; more would only cost memory.
    BoundedQueue<Simulated> frames_{2};
    BoundedQueue<Rendered> images_{2};
    BoundedQueue<int> written_{64};
    SequenceReport report_;  // each stage writes its own member
    std::mutex failure_mutex_;
    std::exception_ptr failure_;
};

}  // namespace

SequenceReport render_sequence(const SequenceOptions& options, const FrameSource& source,
                               const std::function<bool(int written)>& progress) {
    ENSURE(options.frames >= 1, options.frames, " frames");
    ENSURE(std::ranges::is_sorted(options.numbers), "numbers of frames are not in order");
    validate(options.view);
    if (!options.write) prepare_directory(options.directory);
    return Pipeline(options, source).run(progress);
}

std::string frame_name(int index) {
    char name[32];
    std::snprintf(name, sizeof name, "%06d.png", index);
    return name;
}

std::int64_t steps_until_frame(int index, double fps, double start, double time_step) {
    return std::llround((start + index / fps) / time_step);
}

}  // namespace tetfront
