#pragma once
// What to see of an object, and from where: the one description that scenes (`view`), pictures, snapshots and the wire
// share. As JSON every key may be absent; assets/schema/scene.schema.json documents them.
//
//     ViewSpec view = parse_view(R"({"colouring": "stress", "cut": {"point": [0, 0, 0], "normal": [0, 1, 0]}})", "view");
//     std::string text = view_json(view);        // and parse_view(text) gives the same view again

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/types.hpp"

namespace tetfront {

class JsonValue;

/// What colours show. displacement: distance from the place at rest [m]; strain: equivalent strain; stress: von Mises
/// stress [Pa]; error: a tet's part of the error estimate.
enum class Colouring { level, stiffness, displacement, strain, stress, error };
enum class Background { light, dark, transparent };

inline constexpr std::array<std::string_view, 6> colouring_names = {"level",  "stiffness", "displacement",
                                                                    "strain", "stress",    "error"};
inline constexpr std::array<std::string_view, 3> background_names = {"light", "dark", "transparent"};
inline std::string name(Colouring c) { return std::string(colouring_names[static_cast<std::size_t>(c)]); }
inline std::string name(Background b) { return std::string(background_names[static_cast<std::size_t>(b)]); }

/// Hides the points p with (p - point) . normal > 0.
struct CutPlane {
    Vec3 point, normal;  // [m]; normal: any length above 1e-6
    friend bool operator==(const CutPlane&, const CutPlane&) = default;
};
/// Where a moving camera is at a moment; in between it follows a smooth curve.
struct CameraKey {
    double time = 0;   // [s] simulated
    Vec3 eye, target;  // [m]
    friend bool operator==(const CameraKey&, const CameraKey&) = default;
};

struct ViewSpec {
    Vec3 eye = {2, -4, 2}, target = {0, 0, 0};  // [m]
    bool fitted = true;                         // eye and target were not given: fit them to the object
    double field_of_view = 35;                  // [degrees] vertical, 5..120
    Colouring colouring = Colouring::level;
    std::optional<std::array<double, 2>> range;  // of the colours, in the colouring's unit; none: fitted to the values
    bool surface = true;                         // false: wireframe only
    bool wireframe = false;                      // edges of the front
    bool arrows = true;                          // of pulls
    bool legend = true;                          // title, numbers and the colours' meaning
    std::optional<CutPlane> cut;
    Background background = Background::light;
    std::vector<CameraKey> keyframes;  // ascending in time; empty: the camera stands still
    friend bool operator==(const ViewSpec&, const ViewSpec&) = default;
};

/// Throws InputError with the place of what does not fit.
ViewSpec read_view(const JsonValue& value);
/// The same from text; keys that are absent stay as in `base`.
ViewSpec parse_view(std::string_view text, const std::string& source, const ViewSpec& base = {});
/// One line of JSON that parse_view() reads back to the same view.
std::string view_json(const ViewSpec& view);

}  // namespace tetfront
