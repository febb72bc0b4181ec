#pragma once
// Records a session while it runs: every so many steps a frame, and what clients do in between, up to a limit of bytes. A full
// disk ends the recording, never the session.
//
//     LiveRecording recording(file, model, {.fps = 30, .field = Field::stress, .most_bytes = 1 << 30});
//     if (recording.due()) recording.add(*frame);           // after each step
//     recording.finish();                                   // and see recording.status()

#include "server/session/recording.hpp"
#include "server/session/stage.hpp"

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

namespace tetfront {

struct RecordingStatus {
    bool active = false;
    std::string name;  // of the file, without its folder
    std::size_t frames = 0;
    double seconds = 0;  // simulated
    std::uint64_t bytes = 0;
    std::string problem;  // one line: why it ended by itself
};

class LiveRecording {
 public:
    struct Settings {
        double fps = 30;  // per simulated second; at most one frame a step
        Field field = Field::none;
        std::uint64_t most_bytes = 0;
        int order = 2;
    };
    /// Throws OutputError.
    LiveRecording(const std::filesystem::path& file, const SessionModel& model, const Settings& settings);

    [[nodiscard]] Field field() const { return settings_.field; }
    /// Whether the step that was just made is one of those that are recorded.
    [[nodiscard]] bool due() { return count_++ % stride_ == 0; }
    /// False: it has ended, status() says why.
    bool add(const Frame& frame);
    bool add(const RecordedEvent& event);
    /// Completes the file.
    void finish();
    [[nodiscard]] const RecordingStatus& status() const { return status_; }

 private:
    bool write(const std::function<void(RecordingWriter&)>& what);
    void end(const std::string& problem);

    Settings settings_;
    std::uint64_t stride_ = 1, count_ = 0;
    double start_ = 0;
    RecordingStatus status_;
    std::unique_ptr<RecordingWriter> writer_;
};

}  // namespace tetfront
