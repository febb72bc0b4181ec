#include "server/net/command_parser.hpp"

#include "server/session/library.hpp"

#include <cmath>
#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

namespace tetfront {

namespace {

using Json = nlohmann::json;

constexpr int max_depth = 8;  // of containers; commands need 2
constexpr std::int64_t max_id = (std::int64_t{1} << 53) - 1;
constexpr std::int64_t max_pull = (std::int64_t{1} << 31) - 1;
constexpr double max_coordinate = 1e6;  // [m]
constexpr double max_gravity = 1e4;     // [m/s^2]
constexpr int max_tets = 1 << 28;
constexpr int max_level = 99;
constexpr double max_force = 1e9;       // [N]
constexpr std::size_t max_name = 64, max_token = 1024;

constexpr std::pair<std::string_view, Field> colourings[] = {
    {"level", Field::none},    {"stiffness", Field::none}, {"displacement", Field::displacement},
    {"strain", Field::strain}, {"stress", Field::stress},  {"error", Field::error}};

std::string number(double value) {
    std::string text = Json(value).dump();
    if (text.ends_with(".0")) text.resize(text.size() - 2);
    return text;
}

/// One part of a JSON pointer (RFC 6901). Long keys are cut: they come from outside and go back in a message.
std::string pointer(std::string_view key) {
    std::string result = "/";
    for (const char c : key.substr(0, 64)) {
        if (c == '~')
            result += "~0";
        else if (c == '/')
            result += "~1";
        else
            result += c;
    }
    return result;
}

/// The members of one command. Reading throws CommandError; a member that nobody has read is unknown.
class Members {
 public:
    explicit Members(const Json& object) : object_(object) {}

    const Json& get(const char* key) {
        const auto member = object_.find(key);
        if (member == object_.end()) throw CommandError{"missing_key", pointer(key), "is missing"};
        read_.insert(key);
        return *member;
    }
    bool has(const char* key) const { return object_.contains(key); }

    std::int64_t integer(const char* key, std::int64_t low, std::int64_t high) {
        const Json& value = get(key);
        if (!value.is_number_integer()) throw CommandError{"wrong_type", pointer(key), "is not an integer"};
        // Unsigned numbers above int64 would turn negative in get<int64_t>().
        const bool huge = value.is_number_unsigned() && value.get<std::uint64_t>() > static_cast<std::uint64_t>(max_id);
        if (huge || value.get<std::int64_t>() < low || value.get<std::int64_t>() > high)
            throw CommandError{"out_of_range", pointer(key),
                               "is " + value.dump() + "; use " + std::to_string(low) + ".." + std::to_string(high)};
        return value.get<std::int64_t>();
    }
    bool boolean(const char* key) {
        const Json& value = get(key);
        if (!value.is_boolean()) throw CommandError{"wrong_type", pointer(key), "is not true or false"};
        return value.get<bool>();
    }
    double real(const char* key, double low, double high) { return real(get(key), pointer(key), low, high); }
    Vec3 vector(const char* key, double low, double high) {
        const Json& value = get(key);
        if (!value.is_array() || value.size() != 3)
            throw CommandError{"wrong_type", pointer(key), "is not an array of 3 numbers"};
        Vec3 result;
        for (int i = 0; i < 3; ++i)
            result[i] = real(value[static_cast<std::size_t>(i)], pointer(key) + "/" + std::to_string(i), low, high);
        return result;
    }
    const std::string& string(const char* key, std::size_t longest) {
        const Json& value = get(key);
        if (!value.is_string()) throw CommandError{"wrong_type", pointer(key), "is not a string"};
        const auto& text = value.get_ref<const std::string&>();
        if (text.size() > longest)
            throw CommandError{"out_of_range", pointer(key), "is longer than " + std::to_string(longest) + " bytes"};
        return text;
    }
    std::string name(const char* key) {
        const std::string& text = string(key, max_name);
        if (!is_plain_name(text))
            throw CommandError{"out_of_range", pointer(key),
                               "is not a name; use 1..64 of A-Z a-z 0-9 - _ . and no dot in front"};
        return text;
    }
    Field colouring(const char* key) {
        const std::string& text = string(key, max_name);
        for (const auto& [known, field] : colourings)
            if (text == known) return field;
        throw CommandError{"out_of_range", pointer(key),
                           "is not a colouring; use level, stiffness, displacement, strain, stress or error"};
    }
    void refuse_others() const {
        for (const auto& [key, value] : object_.items())
            if (!read_.contains(key)) throw CommandError{"unknown_key", pointer(key), "is not a key of this command"};
    }

 private:
    static double real(const Json& value, const std::string& where, double low, double high) {
        if (!value.is_number()) throw CommandError{"wrong_type", where, "is not a number"};
        const double x = value.get<double>();
        if (!(x >= low && x <= high))
            throw CommandError{"out_of_range", where, "is " + number(x) + "; use " + number(low) + ".." + number(high)};
        return x;
    }

    const Json& object_;
    std::set<std::string, std::less<>> read_;
};

std::uint32_t pull_number(Members& m) { return static_cast<std::uint32_t>(m.integer("pull", 0, max_pull)); }
Vec3 target(Members& m) { return m.vector("target", -max_coordinate, max_coordinate); }

SurfacePoint surface_point(Members& m) {
    SurfacePoint point;
    point.triangle = static_cast<std::uint32_t>(m.integer("triangle", 0, 0xFFFFFFFFLL));
    point.barycentric = m.vector("barycentric", 0, 1);
    const double sum = point.barycentric.sum();
    if (std::abs(sum - 1) > 1e-3)
        throw CommandError{"out_of_range", "/barycentric", "sums to " + number(sum) + ", not 1"};
    if (std::abs(sum - 1) > 1e-15) point.barycentric /= sum;  // or a place that clients were told would be another when they say it
    return point;
}

std::uint32_t force_number(Members& m) { return static_cast<std::uint32_t>(m.integer("force", 0, max_pull)); }
Vec3 force_value(Members& m) { return m.vector("value", -max_force, max_force); }

command::Pin pin(Members& m, bool pinned) {
    const SurfacePoint point = surface_point(m);
    return {pinned, point, m.real("radius", 0, max_coordinate)};
}

using Reader = std::function<Command(Members&)>;
const std::vector<std::pair<std::string_view, Reader>>& readers() {
    static const std::vector<std::pair<std::string_view, Reader>> table = {
        {"play", [](Members&) { return command::Play{}; }},
        {"pause", [](Members&) { return command::Pause{}; }},
        {"reset", [](Members&) { return command::Reset{}; }},
        {"step",
         [](Members& m) { return command::Step{m.has("count") ? static_cast<int>(m.integer("count", 1, 1000)) : 1}; }},
        {"speed", [](Members& m) { return command::Speed{m.real("value", 0.01, 10)}; }},
        {"pull_begin",
         [](Members& m) {
             command::PullBegin pull;
             pull.pull = pull_number(m);
             pull.point = surface_point(m);
             pull.target = target(m);
             return pull;
         }},
        {"pull_move",
         [](Members& m) {
             const std::uint32_t pull = pull_number(m);
             return command::PullMove{pull, target(m)};
         }},
        {"pull_end", [](Members& m) { return command::PullEnd{pull_number(m)}; }},
        {"gravity", [](Members& m) { return command::Gravity{m.vector("value", -max_gravity, max_gravity)}; }},
        {"seek", [](Members& m) { return command::Seek{m.real("time", 0, 1e9)}; }},
        {"tolerance", [](Members& m) { return command::Tolerance{m.real("value", 1e-6, 1)}; }},
        {"budget",
         [](Members& m) {
             command::Budget budget;
             if (m.has("tets")) budget.tets = static_cast<int>(m.integer("tets", 1, max_tets));
             if (m.has("milliseconds")) budget.milliseconds = m.real("milliseconds", 0, 1e6);
             return budget;
         }},
        {"force_add",
         [](Members& m) {
             command::ForceAdd force;
             force.force = force_number(m);
             force.point = surface_point(m);
             force.value = force_value(m);
             return force;
         }},
        {"force_move",
         [](Members& m) {
             command::ForceMove force;
             force.force = force_number(m);
             if (m.has("triangle") || m.has("barycentric")) force.point = surface_point(m);
             force.value = force_value(m);
             return force;
         }},
        {"force_remove", [](Members& m) { return command::ForceRemove{force_number(m)}; }},
        {"pin", [](Members& m) { return pin(m, true); }},
        {"unpin", [](Members& m) { return pin(m, false); }},
        {"stiffness_scale",
         [](Members& m) {
             command::StiffnessScale scale{m.real("value", 0.01, 100), std::nullopt};
             if (m.has("triangle") || m.has("barycentric") || m.has("radius")) {
                 const SurfacePoint point = surface_point(m);
                 scale.part = {point, m.real("radius", 0, max_coordinate)};
             }
             return scale;
         }},
        {"damping",
         [](Members& m) {
             const double mass = m.real("mass", 0, 1000);
             return command::Damping{mass, m.real("stiffness", 0, 10)};
         }},
        {"order", [](Members& m) { return command::Order{static_cast<int>(m.integer("value", 1, 2))}; }},
        {"levels",
         [](Members& m) {
             const int min = static_cast<int>(m.integer("min", 0, max_level));
             return command::Levels{min, static_cast<int>(m.integer("max", min, max_level))};
         }},
        {"load", [](Members& m) { return command::Load{m.name("scene")}; }},
        {"save", [](Members& m) { return command::Save{m.name("name")}; }},
        {"restore", [](Members& m) { return command::Restore{m.name("name")}; }},
        {"record_start",
         [](Members& m) {
             command::RecordStart record;
             if (m.has("name")) record.name = m.name("name");
             if (m.has("fps")) record.fps = m.real("fps", 1, 240);
             if (m.has("colouring")) record.field = m.colouring("colouring");
             return record;
         }},
        {"record_stop", [](Members&) { return command::RecordStop{}; }},
        {"colouring", [](Members& m) { return command::Colouring{m.colouring("value")}; }},
        {"compression", [](Members& m) { return command::Compression{m.boolean("value")}; }},
        {"token", [](Members& m) { return command::Token{m.string("value", max_token)}; }},
        {"scenes", [](Members&) { return command::Scenes{}; }},
        {"states", [](Members&) { return command::States{}; }},
        {"recordings", [](Members&) { return command::Recordings{}; }},
    };
    return table;
}

/// Throws CommandError for text that is not JSON, nests too deeply or repeats a key.
Json parse_json(std::string_view text) {
    std::vector<std::set<std::string>> keys;  // of the objects that are open
    const Json::parser_callback_t watch = [&keys](int depth, Json::parse_event_t event, Json& parsed) {
        if (depth >= max_depth) throw CommandError{"malformed", "", "nests more than 8 levels deep"};
        if (event == Json::parse_event_t::object_start) keys.emplace_back();
        if (event == Json::parse_event_t::object_end) keys.pop_back();
        if (event == Json::parse_event_t::key && !keys.back().insert(parsed.get<std::string>()).second)
            throw CommandError{"malformed", pointer(parsed.get_ref<const std::string&>()), "is there twice"};
        return true;
    };
    try {
        return Json::parse(text, watch);
    } catch (const Json::out_of_range&) {
        throw CommandError{"out_of_range", "", "has a number too large for double precision"};
    } catch (const Json::parse_error& e) {
        throw CommandError{"malformed", "", "is not JSON: error at byte " + std::to_string(e.byte)};
    }
}

command::Acknowledge acknowledgement(Members& members) {
    members.get("command");
    const command::Acknowledge result{static_cast<std::uint32_t>(members.integer("frame", 0, 0xFFFFFFFFLL))};
    members.refuse_others();
    return result;
}

Command read_command(Members& members) {
    const Json& name = members.get("command");
    if (!name.is_string()) throw CommandError{"wrong_type", "/command", "is not a string"};
    for (const auto& [known, read] : readers()) {
        if (name.get_ref<const std::string&>() != known) continue;
        Command command = read(members);
        members.refuse_others();
        return command;
    }
    std::string names;
    for (const auto& [known, read] : readers()) names += (names.empty() ? "" : ", ") + std::string(known);
    throw CommandError{"unknown_command", "/command", "is not a command; use one of " + names};
}

}  // namespace

ParsedCommand parse_command(std::string_view text) {
    std::optional<std::int64_t> id;
    try {
        const Json object = parse_json(text);
        if (!object.is_object()) throw CommandError{"malformed", "", "is not a JSON object"};
        Members members(object);
        if (!members.has("id") && object.value("command", Json()) == "ack") return {std::nullopt, acknowledgement(members)};
        id = members.integer("id", 0, max_id);
        Command command = read_command(members);
        return {id, std::move(command)};
    } catch (CommandError& error) {
        return {id, std::move(error)};
    }
}

}  // namespace tetfront
