#include "server/net/protocol.hpp"

#include "engine/base/error.hpp"
#include "server/render/colour_scale.hpp"
#include "server/render/view.hpp"
#include "server/session/saved_state.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>
#include <utility>

#include <nlohmann/json.hpp>

namespace tetfront {

namespace {

static_assert(std::endian::native == std::endian::little, "messages are written in the machine's byte order");

using Json = nlohmann::ordered_json;

enum class MessageType : std::uint8_t { model = 1, topology = 2, frame = 3, coloured_frame = 4 };

std::uint32_t wire_number(Field field) {
    switch (field) {
        case Field::displacement: return 1;
        case Field::strain: return 2;
        case Field::stress: return 3;
        case Field::error: return 4;
        case Field::none: break;
    }
    return 0;
}

struct Header {
    MessageType type;
    std::uint8_t version = protocol_version;
    std::uint16_t generation = 0;
    std::uint32_t epoch = 0, sequence = 0, count_a = 0;
    double time = 0;
    std::uint32_t count_b = 0, count_c = 0;
};
static_assert(sizeof(Header) == 32 && offsetof(Header, time) == 16 && offsetof(Header, count_c) == 28);

std::uint32_t count(std::size_t n) {
    ENSURE(n <= std::numeric_limits<std::uint32_t>::max(), n);
    return static_cast<std::uint32_t>(n);
}

std::string start(const Header& header, std::size_t payload) {
    std::string bytes;
    bytes.reserve(sizeof header + payload + 16);
    bytes.append(reinterpret_cast<const char*>(&header), sizeof header);
    return bytes;
}

void pad(std::string& bytes) { bytes.resize((bytes.size() + 3) / 4 * 4, '\0'); }

template <class T>
void append(std::string& bytes, std::span<const T> values) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
    pad(bytes);
}

using Point = std::array<float, 3>;

struct Bounds {
    Point low{}, extent{};
};

Bounds bounds_of(std::initializer_list<std::span<const Point>> clouds) {
    constexpr float infinity = std::numeric_limits<float>::infinity();
    Point low = {infinity, infinity, infinity}, high = {-infinity, -infinity, -infinity};
    for (const auto cloud : clouds)
        for (const Point& p : cloud)
            for (std::size_t axis = 0; axis < 3; ++axis) {
                if (!std::isfinite(p[axis])) continue;
                low[axis] = std::min(low[axis], p[axis]);
                high[axis] = std::max(high[axis], p[axis]);
            }
    Bounds box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (!(low[axis] <= high[axis])) continue;
        box.low[axis] = low[axis];
        box.extent[axis] = std::min(high[axis] - low[axis], std::numeric_limits<float>::max());
    }
    return box;
}

void append_quantised(std::string& bytes, std::span<const Point> points, const Bounds& box) {
    Point scale{};
    for (std::size_t axis = 0; axis < 3; ++axis) scale[axis] = box.extent[axis] > 0 ? 65535 / box.extent[axis] : 0;
    const std::size_t begin = bytes.size();
    bytes.resize(begin + points.size() * 6);
    char* out = bytes.data() + begin;
    for (const Point& p : points) {
        std::array<std::uint16_t, 3> code;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const float u = (p[axis] - box.low[axis]) * scale[axis] + 0.5F;
            code[axis] = u > 0 ? static_cast<std::uint16_t>(std::min(u, 65535.0F)) : 0;  // NaN: 0
        }
        std::memcpy(out, code.data(), 6);
        out += 6;
    }
    pad(bytes);
}

void append_values(std::string& bytes, Field field, std::span<const float> values) {
    float high = 0;
    for (const float x : values)
        if (std::isfinite(x)) high = std::max(high, x);
    const std::array<std::uint32_t, 1> number{wire_number(field)};
    const std::array<float, 2> range{high, field_high({values.begin(), values.end()})};
    append(bytes, std::span<const std::uint32_t>(number));
    append(bytes, std::span<const float>(range));
    std::vector<std::uint16_t> codes;
    codes.reserve(values.size());
    for (const float x : values) {
        const float u = high > 0 ? x / high * 65535 + 0.5F : 0;
        codes.push_back(u > 0 ? static_cast<std::uint16_t>(std::min(u, 65535.0F)) : 0);  // NaN: 0
    }
    append(bytes, std::span<const std::uint16_t>(codes));
}

std::string text(const Json& message) { return message.dump(-1, ' ', false, Json::error_handler_t::replace); }

Json array(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

/// The scene's view with a camera, as JSON. A fitted camera suits a square window; the client knows its window's shape
/// and turns the camera from there.
Json view_of(const Scene& scene, const FrameModel& model) {
    return Json::parse(view_json(make_view(scene.view, model, 512, 512)));
}

}  // namespace

std::string encode_model(const FrameModel& model, std::uint16_t generation) {
    std::string bytes = start({.type = MessageType::model,
                               .generation = generation,
                               .count_a = count(model.young.size()),
                               .count_b = count(model.triangles.size())},
                              12 * model.triangles.size() + 4 * model.young.size());
    append(bytes, std::span(model.triangles));
    append(bytes, std::span(model.young));
    return bytes;
}

std::string encode_topology(const FrameTopology& topology, std::size_t front_count, std::uint16_t generation) {
    ENSURE(topology.edge_level.size() == topology.edges.size(), topology.edge_level.size(), topology.edges.size());
    const FrontTets tets = front_tets(topology);
    std::string bytes = start({.type = MessageType::topology,
                               .generation = generation,
                               .epoch = topology.epoch,
                               .count_a = count(topology.surface_level.size()),
                               .count_b = count(topology.edges.size()),
                               .count_c = count(front_count)},
                              9 * topology.edges.size() + topology.surface_level.size() + 17 * tets.level.size());
    append(bytes, std::span(topology.edges));
    append(bytes, std::span(topology.surface_level));
    append(bytes, std::span(topology.edge_level));
    const std::array<std::uint32_t, 1> tet_count{count(tets.level.size())};
    append(bytes, std::span<const std::uint32_t>(tet_count));
    append(bytes, std::span(tets.corners));
    append(bytes, std::span(tets.level));
    return bytes;
}

std::string encode_frame(const Frame& frame, std::uint16_t generation, std::uint32_t sequence) {
    const bool coloured = !frame.field_values.empty();
    ENSURE(!coloured || frame.field_values.size() == frame.surface.size(), frame.field_values.size(), frame.surface.size());
    std::string bytes = start({.type = coloured ? MessageType::coloured_frame : MessageType::frame,
                               .generation = generation,
                               .epoch = frame.topology->epoch,
                               .sequence = sequence,
                               .count_a = count(frame.surface.size()),
                               .time = frame.status.time,
                               .count_b = count(frame.front_positions.size()),
                               .count_c = count(frame.pulls.size())},
                              24 + 6 * (frame.surface.size() + frame.front_positions.size()) + 28 * frame.pulls.size() + (coloured ? 12 + 2 * frame.surface.size() : 0));
    const Bounds box = bounds_of({frame.surface, frame.front_positions});
    append(bytes, std::span<const float>(box.low));
    append(bytes, std::span<const float>(box.extent));
    append_quantised(bytes, frame.surface, box);
    append_quantised(bytes, frame.front_positions, box);
    static_assert(sizeof(FramePull) == 7 * sizeof(float));
    append(bytes, std::span(frame.pulls));
    if (coloured) append_values(bytes, frame.field, frame.field_values);
    return bytes;
}

/// Without limits null.
Json budget_of(const command::Budget& budget) {
    return {{"tets", budget.tets < command::Budget{}.tets ? Json(budget.tets) : Json(nullptr)},
            {"milliseconds", budget.milliseconds > 0 ? Json(budget.milliseconds) : Json(nullptr)}};
}

/// As the colouring that shows it; none: "level".
std::string_view field_name(Field field) {
    std::size_t i = 0;
    while (field_of(static_cast<Colouring>(i)) != field) ++i;
    return colouring_names[i];
}

std::string hello_event(const SessionModel& session, const SessionState& state, std::uint16_t generation, const HelloLimits& limits,
                        const std::vector<std::string_view>& capabilities) {
    const Scene& scene = session.scene;
    const FrameModel& model = *session.frame_model;
    Json recorded;  // null
    if (session.recorded) {
        recorded = {{"frames", session.recorded->frames},
                    {"start", session.recorded->start},
                    {"end", session.recorded->end},
                    {"colouring", field_name(session.recorded->field)}};
    }
    const FrontSpec& front = scene.front;
    const int finest = std::min(front.max_level, model.depth);
    return text({{"type", "hello"},
                 {"protocol", protocol_version},
                 {"version", TETFRONT_VERSION},
                 {"scene", {{"name", scene.name}, {"title", scene.title}}},
                 {"up", model.up},
                 {"depth", model.depth},
                 {"young_range", model.young_range},
                 {"rest_box", model.rest_box},
                 {"view", view_of(scene, model)},
                 {"recording", recorded},
                 {"gravity", array(scene.gravity)},
                 {"tolerance", session.recorded ? state.status.tolerance : front.tolerance},
                 {"time_step", scene.time_step},
                 {"order", front.order},
                 {"levels", {{"min", std::min(front.min_level, finest)}, {"max", finest}}},
                 {"budget", budget_of({front.budget_tets, front.budget_milliseconds})},
                 {"playing", state.playing},
                 {"speed", state.speed},
                 {"generation", generation},
                 {"limits",
                  {{"message_bytes", limits.message_bytes},
                   {"messages_per_second", limits.messages_per_second},
                   {"recording_bytes", limits.recording_bytes}}},
                 {"capabilities", capabilities}});
}

std::string state_event(const SessionState& state, std::size_t viewers) {
    const FrameStatus& status = state.status;
    Json forces = Json::array();
    for (const FrameForce& force : state.scene_forces) forces.push_back({{"at", force.at}, {"value", force.value}});
    return text({{"type", "state"},
                 {"playing", state.playing},
                 {"speed", state.speed},
                 {"time", status.time},
                 {"step", status.step},
                 {"steps_per_second", state.steps_per_second},
                 {"tets_by_level", state.tets_by_level},
                 {"free_vertices", status.free_vertices},
                 {"estimate", status.estimate},
                 {"tolerance", status.tolerance},
                 {"gravity", array(state.gravity)},
                 {"milliseconds", status.step_milliseconds},
                 {"phases",
                  {{"adapt", status.phases.adapt},
                   {"setup", status.phases.setup},
                   {"assemble", status.phases.assemble},
                   {"solve", status.phases.solve},
                   {"other", status.phases.other}}},
                 {"energy", {{"kinetic", status.kinetic_energy}, {"elastic", status.elastic_energy}}},
                 {"iterations", status.solver_iterations},
                 {"converged", status.converged},
                 {"viewers", viewers},
                 {"warning", status.warning},
                 {"failed", state.failed},
                 {"forces", std::move(forces)}});
}

std::string progress_event(std::string_view what, double fraction, const std::optional<double>& remaining) {
    return text({{"type", "progress"},
                 {"what", what},
                 {"fraction", std::clamp(fraction, 0.0, 1.0)},
                 {"remaining", remaining ? Json(*remaining) : Json(nullptr)}});
}

std::string settings_event(const SessionState& state) {
    const auto place = [](Json& object, const SurfacePoint& point) {
        object["triangle"] = point.triangle;
        object["barycentric"] = array(point.barycentric);
    };
    Json forces = Json::array(), pins = Json::array(), parts = Json::array();
    for (const auto& [number, force] : state.edits.forces) {
        Json& entry = forces.emplace_back(Json{{"force", number}});
        place(entry, force.at);
        entry["value"] = array(force.value);
    }
    for (const PinEdit& pin : state.edits.pins) {
        Json& entry = pins.emplace_back(Json{{"pinned", pin.pinned}});
        place(entry, pin.centre);
        entry["radius"] = pin.radius;
    }
    for (const StiffnessEdit& part : state.edits.stiffness) {
        Json& entry = parts.emplace_back(Json{{"value", part.scale}});
        place(entry, part.centre);
        entry["radius"] = part.radius;
    }
    return text({{"type", "settings"},
                 {"order", state.order},
                 {"levels", {{"min", state.levels.min}, {"max", state.levels.max}}},
                 {"stiffness_scale", state.edits.stiffness_scale},
                 {"stiffness_parts", std::move(parts)},
                 {"damping", {{"mass", state.edits.mass_damping}, {"stiffness", state.edits.stiffness_damping}}},
                 {"budget", budget_of(state.budget)},
                 {"forces", std::move(forces)},
                 {"pins", std::move(pins)}});
}

std::string recording_event(const RecordingStatus& recording) {
    return text({{"type", "recording"},
                 {"active", recording.active},
                 {"name", recording.name},
                 {"frames", recording.frames},
                 {"seconds", recording.seconds},
                 {"bytes", recording.bytes},
                 {"problem", recording.problem}});
}

std::string link_event(const Outbox::Statistics& link) {
    return text({{"type", "link"},
                 {"sent", link.sent},
                 {"dropped", link.dropped},
                 {"unacknowledged", link.in_flight},
                 {"round_trip", link.round_trip ? Json(*link.round_trip) : Json(nullptr)}});
}

std::string log_event(std::string_view level, std::string_view message) {
    return text({{"type", "log"}, {"level", level}, {"message", message}});
}

std::string scenes_reply(std::int64_t id, const std::vector<Library::SceneEntry>& scenes) {
    Json list = Json::array();
    for (const auto& scene : scenes) list.push_back({{"name", scene.name}, {"title", scene.title}});
    return text({{"type", "ok"}, {"id", id}, {"scenes", std::move(list)}});
}

std::string states_reply(std::int64_t id, const std::vector<Library::FileEntry>& states) {
    Json list = Json::array();
    for (const auto& file : states) {
        try {
            const SavedState state = read_saved_head(file.path);
            list.push_back({{"name", file.path.stem().string()}, {"scene", state.scene}, {"time", state.time}});
        } catch (const InputError&) {
            // Not one of ours: it cannot be restored, so it is not offered.
        }
    }
    return text({{"type", "ok"}, {"id", id}, {"states", std::move(list)}});
}

std::string recordings_reply(std::int64_t id, const std::vector<Library::FileEntry>& recordings, bool video) {
    Json list = Json::array();
    for (const auto& file : recordings) list.push_back({{"name", file.name}, {"bytes", file.bytes}});
    return text({{"type", "ok"}, {"id", id}, {"recordings", std::move(list)}, {"video", video}});
}

std::string ok_reply(std::int64_t id) { return text({{"type", "ok"}, {"id", id}}); }

std::string error_reply(std::optional<std::int64_t> id, const CommandError& error) {
    return text({{"type", "error"},
                 {"id", id ? Json(*id) : Json(nullptr)},
                 {"code", error.code},
                 {"pointer", error.pointer},
                 {"message", error.message}});
}

}  // namespace tetfront
