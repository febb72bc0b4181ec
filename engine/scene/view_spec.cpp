#include "engine/scene/view_spec.hpp"

#include "engine/scene/json_reader.hpp"

namespace tetfront {

namespace {

constexpr Range coordinate = within(-1e6, 1e6);  // [m]
constexpr double smallest_distance = 1e-6;       // [m]

void check_camera(const JsonObject& o, const Vec3& eye, const Vec3& target) {
    if ((eye - target).norm() < smallest_distance)
        o.required("eye").fail("is where `target` is", "use two different points");
}

CutPlane read_cut(const JsonValue& value) {
    const JsonObject o = value.object({"point", "normal"});
    CutPlane cut{o.required("point").vector(coordinate), o.required("normal").vector(coordinate)};
    if (cut.normal.norm() < 1e-6) o.required("normal").fail("has no direction", "use a vector of length 1e-6 or more");
    return cut;
}

std::vector<CameraKey> read_keyframes(const JsonValue& value) {
    std::vector<CameraKey> keys;
    for (const JsonValue& item : value.array()) {
        const JsonObject o = item.object({"time", "eye", "target"});
        const CameraKey key{o.required("time").number(within(0, 1e9)), o.required("eye").vector(coordinate),
                            o.required("target").vector(coordinate)};
        check_camera(o, key.eye, key.target);
        if (!keys.empty() && key.time <= keys.back().time)
            o.required("time").fail("is not after the keyframe before", "put the keyframes in the order of their times");
        keys.push_back(key);
    }
    return keys;
}

ViewSpec read_over(ViewSpec view, const JsonValue& value) {
    const JsonObject o = value.object({"eye", "target", "field_of_view", "colouring", "range", "surface", "wireframe",
                                       "arrows", "legend", "cut", "background", "keyframes"});
    if (o.find("eye") || o.find("target")) {
        view.fitted = false;
        view.eye = o.required("eye").vector(coordinate);
        view.target = o.required("target").vector(coordinate);
        check_camera(o, view.eye, view.target);
    }
    o.read("field_of_view", view.field_of_view, within(5, 120));
    o.read("colouring", view.colouring,
           {{"level", Colouring::level},
            {"stiffness", Colouring::stiffness},
            {"displacement", Colouring::displacement},
            {"strain", Colouring::strain},
            {"stress", Colouring::stress},
            {"error", Colouring::error}});
    if (auto range = o.find("range")) {
        const std::vector<JsonValue> ends = range->array(2);
        view.range = {ends[0].number(within(0, 1e15)), ends[1].number(within(0, 1e15))};
        if (!((*view.range)[1] > (*view.range)[0])) range->fail("is not ascending", "use [low, high] with high > low");
    }
    o.read("surface", view.surface);
    o.read("wireframe", view.wireframe);
    o.read("arrows", view.arrows);
    o.read("legend", view.legend);
    if (auto cut = o.find("cut")) view.cut = read_cut(*cut);
    o.read("background", view.background,
           {{"light", Background::light}, {"dark", Background::dark}, {"transparent", Background::transparent}});
    if (auto keys = o.find("keyframes")) view.keyframes = read_keyframes(*keys);
    return view;
}

nlohmann::ordered_json array(const Vec3& v) { return {v[0], v[1], v[2]}; }

}  // namespace

ViewSpec read_view(const JsonValue& value) { return read_over({}, value); }

ViewSpec parse_view(std::string_view text, const std::string& source, const ViewSpec& base) {
    const JsonDocument document = parse_document(text, source, {});
    return read_over(base, JsonValue(document));
}

std::string view_json(const ViewSpec& view) {
    nlohmann::ordered_json json;
    if (!view.fitted) json["eye"] = array(view.eye), json["target"] = array(view.target);
    json["field_of_view"] = view.field_of_view;
    json["colouring"] = name(view.colouring);
    if (view.range) json["range"] = *view.range;
    json["surface"] = view.surface;
    json["wireframe"] = view.wireframe;
    json["arrows"] = view.arrows;
    json["legend"] = view.legend;
    if (view.cut) json["cut"] = {{"point", array(view.cut->point)}, {"normal", array(view.cut->normal)}};
    json["background"] = name(view.background);
    for (const CameraKey& key : view.keyframes)
        json["keyframes"].push_back({{"time", key.time}, {"eye", array(key.eye)}, {"target", array(key.target)}});
    return json.dump();
}

}  // namespace tetfront
