#include "server/session/saved_state.hpp"

#include "engine/base/atomic_file.hpp"
#include "engine/base/error.hpp"

#include <fstream>
#include <iterator>
#include <utility>

#include <nlohmann/json.hpp>

namespace tetfront {

namespace {

using Json = nlohmann::json;

constexpr int format_version = 1;

Json array(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
Vec3 vector(const Json& a) { return {a.at(0).get<double>(), a.at(1).get<double>(), a.at(2).get<double>()}; }

Json place(const SurfacePoint& point) { return {{"triangle", point.triangle}, {"barycentric", array(point.barycentric)}}; }
SurfacePoint place(const Json& object) {
    return {object.at("triangle").get<std::uint32_t>(), vector(object.at("barycentric"))};
}

Json head_of(const SavedState& state) {
    const Edits& edits = state.edits;
    Json forces = Json::array(), pins = Json::array(), stiffness = Json::array();
    for (const auto& [number, force] : edits.forces) {
        Json entry = place(force.at);
        entry["force"] = number, entry["value"] = array(force.value);
        forces.push_back(std::move(entry));
    }
    for (const PinEdit& pin : edits.pins) {
        Json entry = place(pin.centre);
        entry["pinned"] = pin.pinned, entry["radius"] = pin.radius;
        pins.push_back(std::move(entry));
    }
    for (const StiffnessEdit& part : edits.stiffness) {
        Json entry = place(part.centre);
        entry["scale"] = part.scale, entry["radius"] = part.radius;
        stiffness.push_back(std::move(entry));
    }
    Json head;
    head["tetfront_state"] = format_version;
    head["scene"] = state.scene;
    head["time"] = state.time;
    head["order"] = state.order;
    if (state.levels) head["levels"] = {state.levels->min, state.levels->max};
    head["stiffness_scale"] = edits.stiffness_scale;
    head["mass_damping"] = edits.mass_damping;
    head["stiffness_damping"] = edits.stiffness_damping;
    head["stiffness"] = std::move(stiffness);
    head["forces"] = std::move(forces);
    head["pins"] = std::move(pins);
    return head;
}

SavedState read_head(std::istream& in, const std::filesystem::path& file) {
    std::string line;
    std::getline(in, line);
    SavedState state;
    try {
        const Json head = Json::parse(line);
        if (head.at("tetfront_state") != format_version) throw InputError(file.string(), "", "is of another version", "save it anew");
        state.scene = head.at("scene").get<std::string>();
        state.time = head.at("time").get<double>();
        state.order = head.at("order").get<int>();
        if (head.contains("levels")) state.levels = {head["levels"].at(0).get<int>(), head["levels"].at(1).get<int>()};
        state.edits.stiffness_scale = head.at("stiffness_scale").get<double>();
        state.edits.mass_damping = head.at("mass_damping").get<double>();
        state.edits.stiffness_damping = head.at("stiffness_damping").get<double>();
        for (const Json& force : head.at("forces"))
            state.edits.forces[force.at("force").get<std::uint32_t>()] = {place(force), vector(force.at("value"))};
        for (const Json& part : head.value("stiffness", Json::array()))  // earlier versions had none
            state.edits.stiffness.push_back({place(part), part.at("radius").get<double>(), part.at("scale").get<double>()});
        for (const Json& pin : head.at("pins"))
            state.edits.pins.push_back({pin.at("pinned").get<bool>(), place(pin), pin.at("radius").get<double>()});
    } catch (const Json::exception&) {
        throw InputError(file.string(), "", "is not a saved state", "use one that was saved here");
    }
    return state;
}

}  // namespace

void write_saved_state(const std::filesystem::path& file, const SavedState& state) {
    write_atomically(file, head_of(state).dump(-1, ' ', false, Json::error_handler_t::replace) + '\n' + state.snapshot);
}

SavedState read_saved_state(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    SavedState state = read_head(in, file);
    state.snapshot.assign(std::istreambuf_iterator<char>(in), {});
    return state;
}

SavedState read_saved_head(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return read_head(in, file);
}

}  // namespace tetfront
