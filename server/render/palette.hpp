#pragma once
// Colours that carry meaning. The browser client uses the same numbers; tests/golden/palette.json holds both sides to
// them, because a picture on disk and the page must not contradict each other.
//
//     Rgb c = level_colour(2);
//     Rgb s = map_colour(stiffness_position(2e5f, {1e4f, 1e6f}));
//
// Level colours grow lighter and warmer with each level, so the order shows in grey and to colour-blind eyes as well;
// stiffness runs from pale yellow (soft) to dark red (stiff) as in [Imai]'s figures. Fields grow lighter evenly.

#include <array>
#include <cstdint>
#include <span>

namespace tetfront {

/// sRGB-encoded.
struct Rgb {
    std::uint8_t r = 0, g = 0, b = 0;
    friend bool operator==(const Rgb&, const Rgb&) = default;
};

/// Level of refinement, 0 = coarsest. Levels beyond the last colour repeat it.
inline constexpr std::array<Rgb, 7> level_colours = {{{0x5b, 0x3b, 0xb3},
                                                      {0x23, 0x82, 0xcb},
                                                      {0x10, 0xb9, 0xb5},
                                                      {0x72, 0xd9, 0x7c},
                                                      {0xd3, 0xe0, 0x48},
                                                      {0xfd, 0xe7, 0x7c},
                                                      {0xff, 0xf6, 0xd0}}};

/// Stops of the stiffness map at equal distances, soft to stiff; in between piecewise linear in encoded values.
inline constexpr std::array<Rgb, 9> stiffness_colours = {{{0xf9, 0xea, 0x92},
                                                          {0xfa, 0xdd, 0x6d},
                                                          {0xfb, 0xc9, 0x52},
                                                          {0xf8, 0xad, 0x32},
                                                          {0xf1, 0x8a, 0x19},
                                                          {0xe6, 0x60, 0x03},
                                                          {0xcc, 0x36, 0x1e},
                                                          {0xa5, 0x1e, 0x21},
                                                          {0x75, 0x15, 0x1e}}};

/// Displacement, strain and stress: viridis (Smith & van der Walt 2015), perceptually uniform.
inline constexpr std::array<Rgb, 9> field_colours = {{{0x44, 0x01, 0x54},
                                                      {0x47, 0x2d, 0x7b},
                                                      {0x3b, 0x52, 0x8b},
                                                      {0x2c, 0x72, 0x8e},
                                                      {0x21, 0x91, 0x8c},
                                                      {0x28, 0xae, 0x80},
                                                      {0x5e, 0xc9, 0x62},
                                                      {0xad, 0xdc, 0x30},
                                                      {0xfd, 0xe7, 0x25}}};

/// The error's parts: cividis (Nuñez et al. 2018), the same to eyes that see no red or no green.
inline constexpr std::array<Rgb, 10> error_colours = {{{0x00, 0x22, 0x4e},
                                                       {0x12, 0x35, 0x70},
                                                       {0x3b, 0x49, 0x6c},
                                                       {0x57, 0x5d, 0x6d},
                                                       {0x70, 0x71, 0x73},
                                                       {0x8a, 0x86, 0x78},
                                                       {0xa5, 0x9c, 0x74},
                                                       {0xc3, 0xb3, 0x69},
                                                       {0xe1, 0xcc, 0x55},
                                                       {0xfe, 0xe8, 0x38}}};

/// Arrows of pulls: occurs in none of the maps above.
inline constexpr Rgb pull_colour = {0xc2, 0x18, 0x6b};
inline constexpr Rgb force_colour = {0xd9, 0x77, 0x06};

Rgb level_colour(int level);

/// t is clamped to 0..1.
Rgb map_colour(double t, std::span<const Rgb> stops = stiffness_colours);

/// Whether a range [Pa] is shown on a logarithmic scale: when it spans more than a decade.
bool is_logarithmic(std::array<float, 2> young_range);

/// Where a modulus [Pa] lies in the legend's range, 0..1; the middle when the range has no width.
double stiffness_position(float young, std::array<float, 2> young_range);

}  // namespace tetfront
