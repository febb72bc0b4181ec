#include "server/session/command_json.hpp"


#include <nlohmann/json.hpp>

namespace tetfront {

namespace {

using Json = nlohmann::ordered_json;

Json array(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

Json pull(const char* name, ClientId client, std::uint32_t number) {
    return {{"command", name}, {"client", client}, {"pull", number}};
}

void put(Json& object, const SurfacePoint& point) {
    object["triangle"] = point.triangle;
    object["barycentric"] = array(point.barycentric);
}

struct Writer {
    ClientId client;

    std::optional<Json> operator()(const command::PullBegin& c) const {
        Json json = pull("pull_begin", client, c.pull);
        put(json, c.point);
        json["target"] = array(c.target);
        return json;
    }
    std::optional<Json> operator()(const command::PullMove& c) const {
        Json json = pull("pull_move", client, c.pull);
        json["target"] = array(c.target);
        return json;
    }
    std::optional<Json> operator()(const command::PullEnd& c) const { return pull("pull_end", client, c.pull); }
    std::optional<Json> operator()(const command::Gravity& c) const {
        return Json{{"command", "gravity"}, {"value", array(c.value)}};
    }
    std::optional<Json> operator()(const command::Tolerance& c) const {
        return Json{{"command", "tolerance"}, {"value", c.value}};
    }
    std::optional<Json> operator()(const command::Budget& c) const {
        return Json{{"command", "budget"}, {"tets", c.tets}, {"milliseconds", c.milliseconds}};
    }
    std::optional<Json> operator()(const command::ForceAdd& c) const {
        Json json{{"command", "force_add"}, {"force", c.force}};
        put(json, c.point);
        json["value"] = array(c.value);
        return json;
    }
    std::optional<Json> operator()(const command::ForceMove& c) const {
        Json json{{"command", "force_move"}, {"force", c.force}};
        if (c.point) put(json, *c.point);
        json["value"] = array(c.value);
        return json;
    }
    std::optional<Json> operator()(const command::ForceRemove& c) const {
        return Json{{"command", "force_remove"}, {"force", c.force}};
    }
    std::optional<Json> operator()(const command::Pin& c) const {
        Json json{{"command", c.pinned ? "pin" : "unpin"}};
        put(json, c.point);
        json["radius"] = c.radius;
        return json;
    }
    std::optional<Json> operator()(const command::StiffnessScale& c) const {
        Json json{{"command", "stiffness_scale"}, {"value", c.value}};
        if (c.part) put(json, c.part->point), json["radius"] = c.part->radius;
        return json;
    }
    std::optional<Json> operator()(const command::Damping& c) const {
        return Json{{"command", "damping"}, {"mass", c.mass}, {"stiffness", c.stiffness}};
    }
    std::optional<Json> operator()(const command::Order& c) const { return Json{{"command", "order"}, {"value", c.value}}; }
    std::optional<Json> operator()(const command::Levels& c) const {
        return Json{{"command", "levels"}, {"min", c.min}, {"max", c.max}};
    }
    template <class Other>
    std::optional<Json> operator()(const Other&) const {
        return std::nullopt;
    }
};

}  // namespace

std::optional<std::string> recorded_json(ClientId client, const Command& command) {
    const std::optional<Json> json = std::visit(Writer{client}, command);
    return json ? std::optional(json->dump()) : std::nullopt;
}

}  // namespace tetfront
