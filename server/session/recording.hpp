#pragma once
// A run on disk: what frames hold, compressed, one complete chunk after another. What was written before a crash or a
// full disk stays readable, up to the last complete frame.
//
//     RecordingWriter writer("run.tfr", info, *model);          // tetfront record
//     writer.add(*frame);                                       // ... in the order of time
//     writer.finish();
//
//     Recording run("run.tfr");                                 // tetfront render, tetfront serve
//     std::shared_ptr<const Frame> frame = run.frame(120);      // any, in any order
//
// The file: 8 bytes "tetfront", u32 version, u32 zero; then chunks of u32 kind, u32 zero, u64 size, u64 checksum of all
// that and the payload, payload. Kinds: 1 info (JSON), 2 model, 3 topology, 4 frame (of the last topology before it),
// 5 end, 6 event (what somebody or the scene's timeline did before the next frame). Little-endian. Arrays go through meshoptimizer's vertex codec. Positions are whole multiples of 2^-20 of the
// object's longest edge, a micrometre for an object of one metre; fields have 16 bits.

#include "engine/base/atomic_file.hpp"
#include "engine/scene/view_spec.hpp"
#include "engine/simulation/frame.hpp"

#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace tetfront {

inline constexpr std::uint32_t recording_version = 3;

/// What a recording says about itself.
struct RecordingInfo {
    std::string name, title, software;
    ViewSpec view;                // as the scene has it
    std::optional<double> floor;  // [m] height of the floor in pictures
    double fps = 30;              // frames per simulated second, > 0
    double time_step = 1.0 / 60;  // [s] of the simulation
    int order = 2;                // of its tets
    Field field = Field::none;    // that every frame holds
};

/// A command: {"command": "gravity", "value": [0, 0, -1.62]}, as on the wire but without an id.
struct RecordedEvent {
    double time = 0;   // [s] simulated
    std::string json;  // one line
};

class RecordingWriter {
 public:
    /// Replaces a file of this name. Throws OutputError.
    RecordingWriter(const std::filesystem::path& file, const RecordingInfo& info, const FrameModel& model);
    ~RecordingWriter();  // without finish(): readable, but not complete
    RecordingWriter(const RecordingWriter&) = delete;
    RecordingWriter& operator=(const RecordingWriter&) = delete;

    /// Throws OutputError; then the file ends with the last frame that fitted.
    void add(const Frame& frame);
    /// What happened between the frames before and after. Throws OutputError.
    void add(const RecordedEvent& event);
    /// Marks the recording as complete and waits for the disk. Throws OutputError.
    void finish();

    [[nodiscard]] std::uint64_t bytes() const { return size_; }
    [[nodiscard]] std::size_t frames() const { return frames_; }

 private:
    void append(std::uint32_t kind, std::string_view payload);

    std::filesystem::path file_;
    int descriptor_ = -1;
    std::uint64_t size_ = 0;
    std::size_t frames_ = 0;
    Field field_;
    std::array<double, 3> origin_{};
    double step_ = 1;
    std::shared_ptr<const FrameTopology> topology_;
};

/// Whether the file begins as a recording does.
bool is_recording(const std::filesystem::path& file);

class Recording {
 public:
    /// Reads all of the file once and checks it. Throws InputError when it is no recording of a known version, or has no
    /// complete frame; what follows the first damage is left out, see complete().
    explicit Recording(const std::filesystem::path& file);
    /// The same from any bytes; `source` is for errors.
    Recording(std::unique_ptr<std::istream> bytes, std::string source);
    ~Recording();
    Recording(Recording&&) noexcept;
    Recording& operator=(Recording&&) noexcept;

    [[nodiscard]] const RecordingInfo& info() const { return info_; }
    [[nodiscard]] const std::shared_ptr<const FrameModel>& model() const { return model_; }
    [[nodiscard]] std::size_t frame_count() const { return frames_.size(); }
    [[nodiscard]] double time(std::size_t index) const { return frames_[index].time; }
    /// In the order they happened.
    [[nodiscard]] const std::vector<RecordedEvent>& events() const { return events_; }
    /// Largest field_high() of all frames.
    [[nodiscard]] double field_high() const { return field_high_; }
    /// False: it was cut short or damaged after the last frame.
    [[nodiscard]] bool complete() const { return complete_; }
    /// Throws InputError for contents that do not fit each other.
    [[nodiscard]] std::shared_ptr<const Frame> frame(std::size_t index);

 private:
    struct Chunk {
        std::uint64_t offset, size;  // of the payload
    };
    struct FrameEntry {
        Chunk chunk;
        std::size_t topology;  // index into topologies_
        double time;           // [s]
    };
    void scan();
    std::string read(const Chunk& chunk);

    std::unique_ptr<std::istream> bytes_;
    std::string source_;
    RecordingInfo info_;
    std::shared_ptr<const FrameModel> model_;
    std::vector<Chunk> topologies_;
    std::vector<FrameEntry> frames_;
    std::vector<RecordedEvent> events_;
    double field_high_ = 0;
    bool complete_ = false;
    std::size_t cached_index_ = 0;  // into topologies_
    std::shared_ptr<const FrameTopology> cached_;
    std::uint32_t cached_front_ = 0;  // vertices of the cached topology's front
};

}  // namespace tetfront
