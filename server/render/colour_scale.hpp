#pragma once
// How a frame's numbers become colours, and what the legend says about them. Everything but levels, which are counts.
//
//     const ColourScale scale = colour_scale(frame, view);     // view.colouring: stress, say
//     Rgb c = scale.colour(2.5e5);
//     scale.title, scale.label(2.5e5)                          // "Von Mises stress", "250 kPa"

#include "engine/simulation/frame.hpp"
#include "server/render/palette.hpp"
#include "server/render/view.hpp"

#include <array>
#include <span>
#include <string>

namespace tetfront {

struct ColourScale {
    std::span<const Rgb> stops;
    std::array<double, 2> range;  // low <= high
    bool logarithmic = false;
    bool open = false;  // there are values above the range
    std::string title;
    std::string (*label)(double value);

    /// Where a value lies between the ends, 0..1; the middle when there is nothing between them.
    [[nodiscard]] double position(double value) const;
    [[nodiscard]] double value_at(double position) const;
    [[nodiscard]] bool single() const { return !(range[1] > range[0]); }
    [[nodiscard]] Rgb colour(double value) const { return map_colour(position(value), stops); }
};

/// Throws InputError when the frame does not hold the values that the view's colouring shows. The range is the view's,
/// or the model's moduli, or from 0 to readable_ceiling() of the frame's field_high().
ColourScale colour_scale(const Frame& frame, const View& view);

/// What a frame must hold for a colouring.
Field field_of(Colouring colouring);

/// The smallest of 1, 1.5, 2, 3, 4, 5, 6 and 8 times a power of ten that is not below x; 0 for x <= 0.
double readable_ceiling(double x);

/// A value with three significant digits and a prefix: 2.5e5 Pa -> "250 kPa".
std::string pascals(double value);
/// "12.5 N", "4 kN"
std::string newtons(double value);
/// "12 mm", "1.5 m"
std::string metres(double value);
/// 0.0123 -> "1.23 %"
std::string percent(double value);

}  // namespace tetfront
