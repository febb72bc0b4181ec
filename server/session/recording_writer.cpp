#include "server/session/recording.hpp"

#include "server/base/descriptor.hpp"
#include "server/session/recording_bytes.hpp"

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

namespace tetfront {

namespace {

using namespace recording;

constexpr std::array<const char*, 5> field_names = {"none", "displacement", "strain", "stress", "error"};

std::string info_text(const RecordingInfo& info) {
    nlohmann::ordered_json json = {{"name", info.name},
                                   {"title", info.title},
                                   {"software", info.software},
                                   {"fps", info.fps},
                                   {"time_step", info.time_step},
                                   {"order", info.order},
                                   {"field", field_names[static_cast<std::size_t>(info.field)]},
                                   {"view", nlohmann::ordered_json::parse(view_json(info.view))}};
    if (info.floor) json["floor"] = *info.floor;
    return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

std::string model_payload(const FrameModel& model) {
    PayloadWriter out;
    out.put(static_cast<std::int32_t>(model.up));
    out.put(static_cast<std::int32_t>(model.depth));
    out.put(model.young_range);
    out.put(model.rest_box);
    out.put_array(std::span(model.young));
    out.put_array(std::span(model.triangles));
    return out.bytes();
}

std::string topology_payload(const FrameTopology& topology, std::size_t front_vertices) {
    PayloadWriter out;
    out.put(topology.epoch);
    out.put(static_cast<std::uint32_t>(front_vertices));
    std::vector<PackedEdge> edges;
    edges.reserve(topology.edges.size());
    for (std::size_t e = 0; e < topology.edges.size(); ++e)
        edges.push_back({topology.edges[e][0], topology.edges[e][1], topology.edge_level[e]});
    out.put_array(std::span<const PackedEdge>(edges));
    const std::vector<std::uint32_t> levels(topology.surface_level.begin(), topology.surface_level.end());
    out.put_array(std::span(levels));
    out.put_array(std::span(topology.tets_by_level));
    std::vector<PackedPiece> pieces;
    pieces.reserve(topology.pieces.size());
    for (std::size_t i = 0; i < topology.pieces.size(); ++i)
        pieces.push_back({topology.pieces[i], topology.piece_level[i], topology.piece_young[i]});
    out.put_array(std::span<const PackedPiece>(pieces));
    return out.bytes();
}

std::string frame_payload(const Frame& frame, const Grid& grid) {
    PayloadWriter out;
    float most = 0;
    for (const std::vector<float>* values : {&frame.field_values, &frame.front_values})
        for (const float value : *values)
            if (std::isfinite(value)) most = std::max(most, value);
    const auto packed = [most](const std::vector<float>& values, std::size_t i) -> std::uint32_t {
        if (values.empty() || most <= 0) return 0;
        const float share = values[i] / most * 65535 + 0.5F;
        return share > 0 ? static_cast<std::uint32_t>(std::min(share, 65535.0F)) : 0;  // NaN: 0
    };
    const FrameStatus& status = frame.status;
    out.put(status.time);
    out.put(most);
    out.put(field_high(frame.field_values));
    out.put(status.step);
    out.put(status.estimate);
    out.put(status.tolerance);
    out.put(status.free_vertices);
    out.put(status.solver_iterations);
    out.put(static_cast<std::uint32_t>(status.converged));
    out.put(std::string_view(status.warning).substr(0, 1000));
    static_assert(sizeof(FramePull) == 28);
    out.put_array(std::span(frame.pulls));
    static_assert(sizeof(FrameForce) == 24);
    out.put_array(std::span(frame.forces));
    std::vector<PackedPoint> points;
    points.reserve(std::max(frame.surface.size(), frame.front_positions.size()));
    for (std::size_t i = 0; i < frame.surface.size(); ++i)
        points.push_back({grid.pack(frame.surface[i]), packed(frame.field_values, i)});
    out.put_array(std::span<const PackedPoint>(points));
    points.clear();
    for (std::size_t i = 0; i < frame.front_positions.size(); ++i)
        points.push_back({grid.pack(frame.front_positions[i]), packed(frame.front_values, i)});
    out.put_array(std::span<const PackedPoint>(points));
    return out.bytes();
}

}  // namespace

RecordingWriter::RecordingWriter(const std::filesystem::path& file, const RecordingInfo& info, const FrameModel& model)
    : file_(file), field_(info.field) {
    const Grid grid(model.rest_box);
    origin_ = grid.origin, step_ = grid.step;
    descriptor_ = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (descriptor_ < 0)
        throw OutputError(file.string() + ": cannot be written: " + std::generic_category().message(errno));
    try {
        append(0, {});
        append(Kind::info, info_text(info));
        append(Kind::model, model_payload(model));
    } catch (...) {
        if (descriptor_ >= 0) ::close(descriptor_);  // the destructor does not run
        std::error_code ignored;
        if (std::filesystem::is_regular_file(file, ignored)) std::filesystem::remove(file, ignored);  // without a model it is no recording
        throw;
    }
}

RecordingWriter::~RecordingWriter() {
    if (descriptor_ >= 0) ::close(descriptor_);
}

void RecordingWriter::append(std::uint32_t kind, std::string_view payload) {
    ENSURE(descriptor_ >= 0, "the recording is finished or has failed");
    ENSURE(payload.size() <= largest_payload, payload.size());
    std::string bytes;
    if (kind == 0) {
        const FileHeader header;
        bytes.assign(reinterpret_cast<const char*>(&header), sizeof header);
    } else {
        ChunkHeader header{.kind = kind, .size = payload.size()};
        header.checksum = checksum_of(kind, header.size).add(payload).value();
        bytes.reserve(sizeof header + payload.size());
        bytes.assign(reinterpret_cast<const char*>(&header), sizeof header);
        bytes.append(payload);
    }
    if (const int error = write_all(descriptor_, bytes)) {
        // A part of a chunk would do no harm, but nobody needs it. Not a regular file: it stays.
        static_cast<void>(::ftruncate(descriptor_, static_cast<off_t>(size_)));
        ::close(std::exchange(descriptor_, -1));
        throw OutputError(file_.string() + ": cannot be written: " + std::generic_category().message(error) +
                          "; it is readable up to frame " + std::to_string(frames_) + " (not included)");
    }
    size_ += bytes.size();
}

void RecordingWriter::add(const Frame& frame) {
    ENSURE(frame.field == field_, "the recording holds another field than the frame");
    Grid grid({});
    grid.origin = origin_, grid.step = step_;
    if (frame.topology != topology_) append(Kind::topology, topology_payload(*frame.topology, frame.front_positions.size()));
    topology_ = frame.topology;
    append(Kind::frame, frame_payload(frame, grid));
    ++frames_;
}

void RecordingWriter::add(const RecordedEvent& event) {
    PayloadWriter out;
    out.put(event.time);
    out.put(std::string_view(event.json));
    append(Kind::event, out.bytes());
}

void RecordingWriter::finish() {
    append(Kind::end, {});
    const int descriptor = std::exchange(descriptor_, -1);
    const bool synced = ::fsync(descriptor) == 0 || errno == EINVAL || errno == EROFS;  // a pipe has nothing to wait for
    const int error = errno;
    if (::close(descriptor) != 0 || !synced)
        throw OutputError(file_.string() + ": cannot be written: " + std::generic_category().message(error));
}

}  // namespace tetfront
