#include "server/session/recording.hpp"

#include "engine/scene/json_reader.hpp"
#include "server/session/recording_bytes.hpp"

#include <algorithm>
#include <fstream>
#include <istream>
#include <utility>

namespace tetfront {

namespace {

using namespace recording;

constexpr std::size_t longest_event = 10'000, most_events = 10'000'000;

RecordingInfo read_info(std::string_view text, const std::string& source) {
    const JsonDocument document = parse_document(text, source, {});
    const JsonObject o = JsonValue(document).object(
        {"name", "title", "software", "fps", "time_step", "order", "field", "view", "floor"});
    RecordingInfo info;
    const auto text_at = [&](const char* key, std::string& target) {
        const std::string& value = document.root.contains(key) && document.root[key].is_string()
                                       ? document.root[key].get_ref<const std::string&>()
                                       : target;
        target = one_line(value, 300);
    };
    text_at("name", info.name), text_at("title", info.title), text_at("software", info.software);
    o.read("fps", info.fps, above(0, 1e9));
    o.read("time_step", info.time_step, above(0, 1e6));
    o.read("order", info.order, 1, 2);
    o.read("field", info.field,
           {{"none", Field::none},
            {"displacement", Field::displacement},
            {"strain", Field::strain},
            {"stress", Field::stress},
            {"error", Field::error}});
    if (auto view = o.find("view")) info.view = read_view(*view);
    if (auto floor = o.find("floor")) info.floor = floor->number(within(-1e9, 1e9));
    return info;
}

std::shared_ptr<const FrameModel> read_model(PayloadReader in) {
    auto model = std::make_shared<FrameModel>();
    model->up = in.get<std::int32_t>();
    model->depth = in.get<std::int32_t>();
    in.check(model->up >= 0 && model->up <= 2 && model->depth >= 0 && model->depth <= 30, "its model is out of range");
    model->young_range = in.get_all<float, 2>();
    model->rest_box = in.get_all<float, 6>();
    const auto sane = [](float x) { return std::isfinite(x) && std::abs(x) < 1e18F; };
    in.check(std::ranges::all_of(model->rest_box, sane) && std::ranges::all_of(model->young_range, sane),
             "its model is out of range");
    model->young = in.get_array<float>();
    in.check(std::ranges::all_of(model->young, sane), "its moduli are out of range");
    model->triangles = in.get_array<std::array<std::uint32_t, 3>>();
    for (const auto& triangle : model->triangles)
        for (const std::uint32_t v : triangle) in.check(v < model->young.size(), "a triangle has no such corner");
    in.finish();
    return model;
}

/// The topology, and how many vertices its front has.
std::pair<std::shared_ptr<const FrameTopology>, std::uint32_t> read_topology(PayloadReader in, const FrameModel& model) {
    auto topology = std::make_shared<FrameTopology>();
    topology->epoch = in.get<std::uint32_t>();
    const auto vertices = in.get<std::uint32_t>();
    const auto edges = in.get_array<PackedEdge>();
    for (const PackedEdge& edge : edges) {
        in.check(edge.a < vertices && edge.b < vertices, "an edge has no such end");
        in.check(edge.level <= static_cast<std::uint32_t>(model.depth), "an edge has no such level");
        topology->edges.push_back({edge.a, edge.b});
        topology->edge_level.push_back(static_cast<std::uint8_t>(edge.level));
    }
    for (const std::uint32_t level : in.get_array<std::uint32_t>()) {
        in.check(level <= static_cast<std::uint32_t>(model.depth), "a vertex has no such level");
        topology->surface_level.push_back(static_cast<std::uint8_t>(level));
    }
    in.check(topology->surface_level.size() == model.young.size(), "its surface has another number of levels");
    topology->tets_by_level = in.get_array<std::uint32_t>();
    in.check(topology->tets_by_level.size() == static_cast<std::size_t>(model.depth) + 1, "its levels are not counted");
    for (const PackedPiece& piece : in.get_array<PackedPiece>()) {
        for (const std::uint32_t corner : piece.corners) in.check(corner < vertices, "a tet has no such corner");
        in.check(piece.level <= static_cast<std::uint32_t>(model.depth), "a tet has no such level");
        in.check(std::isfinite(piece.young), "a tet's modulus is out of range");
        topology->pieces.push_back(piece.corners);
        topology->piece_level.push_back(static_cast<std::uint8_t>(piece.level));
        topology->piece_young.push_back(piece.young);
    }
    in.finish();
    return {topology, vertices};
}

std::shared_ptr<Frame> read_frame(PayloadReader in, const FrameModel& model, std::uint32_t front_vertices, Field field) {
    auto frame = std::make_shared<Frame>();
    FrameStatus& status = frame->status;
    status.time = in.get<double>();
    const float most = in.get<float>();
    in.get<float>();  // its usual largest: for the whole recording, see scan()
    status.step = in.get<std::uint64_t>();
    status.estimate = in.get<double>();
    status.tolerance = in.get<double>();
    status.free_vertices = in.get<std::uint32_t>();
    status.solver_iterations = in.get<std::uint32_t>();
    status.converged = in.get<std::uint32_t>() != 0;
    status.warning = one_line(in.get_text(1000), 1000);
    in.check(std::isfinite(status.time) && std::isfinite(most) && most >= 0 && std::isfinite(status.estimate) &&
                 std::isfinite(status.tolerance),
             "a frame's numbers are out of range");
    frame->pulls = in.get_array<FramePull>();
    frame->forces = in.get_array<FrameForce>();
    const Grid grid(model.rest_box);
    frame->field = field;
    const auto surface = in.get_array<PackedPoint>();
    in.check(surface.size() == model.young.size(), "a frame has another number of surface vertices");
    frame->surface.reserve(surface.size());
    for (const PackedPoint& p : surface) frame->surface.push_back(grid.unpack(p.at));
    const auto unpack_values = [&](const std::vector<PackedPoint>& points, std::vector<float>& values) {
        if (field == Field::none) return;
        values.reserve(points.size());
        for (const PackedPoint& p : points) values.push_back(most * static_cast<float>(std::min(p.value, 65535U)) / 65535);
    };
    unpack_values(surface, frame->field_values);
    const auto front = in.get_array<PackedPoint>();
    in.check(front.size() == front_vertices, "a frame has another number of front vertices");
    frame->front_positions.reserve(front.size());
    for (const PackedPoint& p : front) frame->front_positions.push_back(grid.unpack(p.at));
    unpack_values(front, frame->front_values);
    in.finish();
    return frame;
}

std::unique_ptr<std::istream> open(const std::filesystem::path& file) {
    if (std::filesystem::is_directory(file))
        throw InputError(file.string(), "", "is a directory", "give the file that tetfront record has written");
    auto stream = std::make_unique<std::ifstream>(file, std::ios::binary);
    if (!*stream) throw InputError(file.string(), "", "cannot be read", "check the path");
    return stream;
}

}  // namespace

bool is_recording(const std::filesystem::path& file) {
    const FileHeader expected;
    std::array<char, 8> magic{};
    std::ifstream in(file, std::ios::binary);
    return in.read(magic.data(), magic.size()) && magic == expected.magic;
}

Recording::Recording(const std::filesystem::path& file) : Recording(open(file), file.string()) {}
Recording::Recording(std::unique_ptr<std::istream> bytes, std::string source)
    : bytes_(std::move(bytes)), source_(std::move(source)) {
    scan();
}
Recording::~Recording() = default;
Recording::Recording(Recording&&) noexcept = default;
Recording& Recording::operator=(Recording&&) noexcept = default;

void Recording::scan() {
    FileHeader header;
    const FileHeader expected;
    const bool whole = static_cast<bool>(bytes_->read(reinterpret_cast<char*>(&header), sizeof header));
    if (!whole || header.magic != expected.magic || header.zero != 0)
        throw InputError(source_, "", "is not a recording", "give a file that tetfront record has written");
    if (header.version != recording_version)
        throw InputError(source_, "", "is a recording of version " + std::to_string(header.version),
                         "this program reads version " + std::to_string(recording_version));
    bytes_->seekg(0, std::ios::end);
    const auto file_size = static_cast<std::uint64_t>(bytes_->tellg());
    bool has_info = false;
    for (std::uint64_t at = sizeof header; !complete_;) {
        ChunkHeader chunk;
        if (file_size - at < sizeof chunk) break;
        bytes_->seekg(static_cast<std::streamoff>(at));
        if (!bytes_->read(reinterpret_cast<char*>(&chunk), sizeof chunk)) break;
        const Chunk place{at + sizeof chunk, chunk.size};
        if (chunk.zero != 0 || chunk.size > largest_payload || chunk.size > file_size - place.offset) break;
        const std::string payload = read(place);
        if (checksum_of(chunk.kind, chunk.size).add(std::string_view(payload)).value() != chunk.checksum) break;
        at = place.offset + chunk.size;
        const PayloadReader in(payload, source_);
        if (chunk.kind == Kind::info && !has_info) {
            info_ = read_info(payload, source_);
            has_info = true;
        } else if (chunk.kind == Kind::model && has_info && !model_) {
            model_ = read_model(in);
        } else if (chunk.kind == Kind::topology && model_) {
            topologies_.push_back(place);
        } else if (chunk.kind == Kind::frame && !topologies_.empty()) {
            PayloadReader start = in;
            const auto time = start.get<double>();
            start.get<float>();
            const auto high = start.get<float>();
            in.check(std::isfinite(time) && (frames_.empty() || time >= frames_.back().time), "its frames go back in time");
            if (std::isfinite(high)) field_high_ = std::max(field_high_, static_cast<double>(high));
            frames_.push_back({place, topologies_.size() - 1, time});
        } else if (chunk.kind == Kind::event && model_) {
            PayloadReader event = in;
            const auto time = event.get<double>();
            in.check(std::isfinite(time) && events_.size() < most_events, "an event is out of range");
            events_.push_back({time, one_line(event.get_text(longest_event), longest_event)});
            event.finish();
        } else if (chunk.kind == Kind::end) {
            complete_ = true;
        } else {
            in.check(false, "its chunks are not in order");
        }
    }
    if (frames_.empty()) throw InputError(source_, "", "holds no complete frame", "record it again");
}

std::string Recording::read(const Chunk& chunk) {
    std::string payload(static_cast<std::size_t>(chunk.size), '\0');
    bytes_->clear();
    bytes_->seekg(static_cast<std::streamoff>(chunk.offset));
    if (!bytes_->read(payload.data(), static_cast<std::streamsize>(payload.size())))
        throw InputError(source_, "", "cannot be read any more", "check the disk");
    return payload;
}

std::shared_ptr<const Frame> Recording::frame(std::size_t index) {
    ENSURE(index < frames_.size(), "frame ", index, " of ", frames_.size());
    const FrameEntry& entry = frames_[index];
    if (!cached_ || cached_index_ != entry.topology) {
        const std::string payload = read(topologies_[entry.topology]);
        std::tie(cached_, cached_front_) = read_topology(PayloadReader(payload, source_), *model_);
        cached_index_ = entry.topology;
    }
    const std::string payload = read(entry.chunk);
    const std::shared_ptr<Frame> frame =
        read_frame(PayloadReader(payload, source_), *model_, cached_front_, info_.field);
    frame->model = model_;
    frame->topology = cached_;
    return frame;
}

}  // namespace tetfront
