#pragma once
// What a viewer or a renderer needs of one moment, immutable once made: shared between threads as
// std::shared_ptr<const Frame>.
//
// The topology (surface triangles, what the front is) is apart from the positions: it changes only when the front does,
// and is shared by all frames of the same epoch.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "engine/base/types.hpp"

namespace tetfront {

/// Constant while the simulated object is the same (until another scene is loaded).
struct FrameModel {
    std::vector<std::array<std::uint32_t, 3>> triangles;   // [F] of the surface
    std::vector<float> young;                              // [S] Young's modulus at each surface vertex [Pa]
    std::array<float, 2> young_range{};                    // [Pa] smallest and largest
    int depth = 0;                                         // levels are 0..depth
    int up = 2;                                            // axis
    std::array<float, 6> rest_box{};                       // [m] low x y z, high x y z of the rest surface
};

/// Constant within one epoch.
struct FrameTopology {
    std::uint32_t epoch = 0;                               // grows by one with each change of the front
    std::vector<std::array<std::uint32_t, 2>> edges;       // [E] unique edges of the front, into Frame::front_positions
    std::vector<std::uint8_t> edge_level;                  // [E] level of the finest tet at the edge
    std::vector<std::uint8_t> surface_level;               // [S] level of the active tet that carries the vertex
    std::vector<std::uint32_t> tets_by_level;              // [depth+1] active tets
    /// Straight tets that fill the front, for cuts through it: a linear tet is one, a quadratic one is eight, one after
    /// the other, the first four of which have its corners, each at its place. Corners into Frame::front_positions. May
    /// be empty.
    std::vector<std::array<std::uint32_t, 4>> pieces;      // [P]
    std::vector<std::uint8_t> piece_level;                 // [P]
    std::vector<float> piece_young;                        // [P] Young's modulus that the tet is simulated with [Pa]
};

/// The front's tets by their corners, without the midpoints of quadratic ones.
struct FrontTets {
    std::vector<std::array<std::uint32_t, 4>> corners;     // [T] into Frame::front_positions
    std::vector<std::uint8_t> level;                       // [T]
};
FrontTets front_tets(const FrameTopology& topology);

struct FramePull {                                         // a pull in progress
    std::array<float, 3> from, to;                         // [m] grabbed point now, cursor
    float force = 0;                                       // [N]
};

struct FrameForce {                        // the scene's, one arrow for each region, or one that a client has set
    std::array<float, 3> at;               // [m] where it acts, now; of a region: the mean
    std::array<float, 3> value;            // [N] in all
};

/// [ms] wall clock of a step: adapt (indicator, split, merge), setup (pattern after a change), assemble, solve, other.
struct StepMilliseconds {
    double adapt = 0, setup = 0, assemble = 0, solve = 0, other = 0;
    [[nodiscard]] double total() const { return adapt + setup + assemble + solve + other; }
};

struct FrameStatus {
    double time = 0;                                       // [s] simulated
    std::uint64_t step = 0;
    double estimate = 0;                                   // relative displacement error, estimated
    double tolerance = 0;
    double step_milliseconds = 0;                          // last step, all phases
    StepMilliseconds phases;                               // of the last step; a recording has none
    double kinetic_energy = 0, elastic_energy = 0;         // [J] now; a recording has none
    double steps_per_second = 0;                           // measured by the session; 0: unknown
    std::uint32_t free_vertices = 0;
    std::uint32_t solver_iterations = 0;
    bool converged = true;
    std::string warning;                                   // one line; empty: all is well
};

/// A number per surface vertex, in a frame only when it was asked for.
enum class Field : std::uint8_t {
    none,
    displacement,  // [m] distance from the place at rest
    strain,        // equivalent strain sqrt(2/3 e':e') of the corotated strain, e' its deviator
    stress,        // [Pa] von Mises stress
    error,         // the tet's part of the error estimate; the estimate is the sum over all tets
};

/// The value that all but 2 % of the values do not exceed: colours that end here show more than colours that end at the
/// few highest, which sit at corners and pins. 0 when there is none.
float field_high(std::vector<float> values);

struct Frame {
    std::shared_ptr<const FrameModel> model;
    std::shared_ptr<const FrameTopology> topology;
    std::vector<std::array<float, 3>> surface;             // [S] positions [m]
    std::vector<std::array<float, 3>> front_positions;     // [N] positions of the front's vertices [m]
    std::vector<FramePull> pulls;
    std::vector<FrameForce> forces;                        // that act now
    Field field = Field::none;
    std::vector<float> field_values;                       // [S] >= 0, or empty
    std::vector<float> front_values;                       // [N] >= 0, or empty
    FrameStatus status;
};

}  // namespace tetfront
