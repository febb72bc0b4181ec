#include "server/render/colour_scale.hpp"

#include "engine/base/error.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>

namespace tetfront {

namespace {

std::string digits(double value) {
    char text[64];
    std::snprintf(text, sizeof text, "%.3g", value);
    return text;
}

/// The value in the largest of the units, each a thousand times the one before, that leaves at least 1 of it.
template <std::size_t N>
std::string prefixed(double value, const char* const (&units)[N]) {
    std::size_t unit = 0;
    // 999.5 would print as 1e+03 with three digits.
    for (; std::abs(value) >= 999.5 && unit + 1 < N; ++unit) value /= 1000;
    return digits(value) + units[unit];
}

}  // namespace

std::string pascals(double value) {
    static constexpr const char* units[] = {" Pa", " kPa", " MPa", " GPa", " TPa"};
    return prefixed(value, units);
}

std::string newtons(double value) {
    static constexpr const char* units[] = {" N", " kN", " MN", " GN"};
    return prefixed(value, units);
}

std::string metres(double value) {
    static constexpr const char* units[] = {" nm", " µm", " mm", " m", " km"};
    return value == 0 ? "0 m" : prefixed(value * 1e9, units);
}

std::string percent(double value) { return digits(100 * value) + " %"; }

double ColourScale::position(double value) const {
    const auto [low, high] = range;
    if (single()) return 0.5;
    const double t = logarithmic ? std::log(value / low) / std::log(high / low) : (value - low) / (high - low);
    return std::isfinite(t) ? std::clamp(t, 0.0, 1.0) : 0.0;
}

double ColourScale::value_at(double t) const {
    const auto [low, high] = range;
    return logarithmic ? low * std::pow(high / low, t) : low + t * (high - low);
}

Field field_of(Colouring colouring) {
    switch (colouring) {
        case Colouring::displacement: return Field::displacement;
        case Colouring::strain: return Field::strain;
        case Colouring::stress: return Field::stress;
        case Colouring::error: return Field::error;
        case Colouring::level:
        case Colouring::stiffness: break;
    }
    return Field::none;
}

double readable_ceiling(double x) {
    if (!(x > 0) || !std::isfinite(x)) return 0;
    const double decade = std::pow(10, std::floor(std::log10(x)));
    for (const double step : {1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0})
        if (x <= step * decade * (1 + 1e-9)) return step * decade;
    return 10 * decade;
}

ColourScale colour_scale(const Frame& frame, const View& view) {
    ColourScale scale;
    if (view.colouring == Colouring::stiffness) {
        const auto& range = frame.model->young_range;
        scale = {stiffness_colours, {range[0], range[1]}, is_logarithmic(range), false, "Young’s modulus", pascals};
    } else {
        const Field field = field_of(view.colouring);
        if (frame.field != field || frame.field_values.size() != frame.surface.size())
            throw InputError("view", "colouring", "is \"" + name(view.colouring) + "\", which this frame has no values of",
                             "ask the simulation or the recording for it");
        scale = {field == Field::error ? std::span<const Rgb>(error_colours) : std::span<const Rgb>(field_colours),
                 {0, readable_ceiling(static_cast<double>(field_high(frame.field_values)))},
                 false,
                 false,
                 field == Field::displacement ? "Displacement"
                 : field == Field::strain     ? "Equivalent strain"
                 : field == Field::stress     ? "Von Mises stress"
                                              : "Error, part of each tet",
                 field == Field::displacement ? metres : field == Field::stress ? pascals : percent};
    }
    if (view.range) {
        scale.range = *view.range;
        scale.logarithmic = scale.logarithmic && scale.range[0] > 0;
    }
    const std::vector<float>& values = view.colouring == Colouring::stiffness ? frame.model->young : frame.field_values;
    scale.open = std::ranges::any_of(values, [&](float x) { return static_cast<double>(x) > scale.range[1] * (1 + 1e-6); });
    return scale;
}

}  // namespace tetfront
