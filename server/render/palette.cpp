#include "server/render/palette.hpp"

#include <algorithm>
#include <cmath>

namespace tetfront {

Rgb level_colour(int level) {
    return level_colours[static_cast<std::size_t>(std::clamp(level, 0, static_cast<int>(level_colours.size()) - 1))];
}

Rgb map_colour(double t, std::span<const Rgb> stops) {
    const int last = static_cast<int>(stops.size()) - 1;
    const double at = std::clamp(t, 0.0, 1.0) * last;
    const int i = std::min(last - 1, static_cast<int>(at));
    const Rgb &a = stops[static_cast<std::size_t>(i)], &b = stops[static_cast<std::size_t>(i + 1)];
    const auto mix = [f = at - i](std::uint8_t x, std::uint8_t y) {
        return static_cast<std::uint8_t>(std::lround(x + f * (y - x)));
    };
    return {mix(a.r, b.r), mix(a.g, b.g), mix(a.b, b.b)};
}

bool is_logarithmic(std::array<float, 2> range) { return range[0] > 0 && range[1] > 10 * range[0]; }

double stiffness_position(float young, std::array<float, 2> range) {
    const double low = range[0], high = range[1];
    if (!(high > low)) return 0.5;
    const double t =
        is_logarithmic(range) ? std::log(young / low) / std::log(high / low) : (young - low) / (high - low);
    return std::clamp(t, 0.0, 1.0);
}

}  // namespace tetfront
