#pragma once
// Loops over the tets of one level, shared by the files of elasticity.hpp.

#include "engine/base/parallel.hpp"
#include "engine/tree/tet_tree.hpp"

#include <algorithm>
#include <array>

namespace tetfront {

inline std::size_t level_begin(const TetTree& tree, int level) { return (*tree.level(level).begin()).index(); }

/// body(t) for every tet of a level, in parallel; report(done) in between, on the calling thread.
template <class Body, class Report>
void for_level(const TetTree& tree, int level, const Body& body, const Report& report) {
    constexpr std::size_t grain = 64, batch = 16384;  // tets per task, tets between two reports
    const std::size_t first = level_begin(tree, level), count = tree.tet_count(level);
    for (std::size_t done = 0; done < count; done += batch) {
        parallel_for(std::min(batch, count - done), grain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) body(TetId(static_cast<std::int64_t>(first + done + i)));
        });
        report(std::min(done + batch, count));
    }
}

inline std::array<Vec3, 4> corner_positions(const TetTree& tree, TetId t) {
    std::array<Vec3, 4> x;
    for (std::size_t i = 0; i < 4; ++i) x[i] = tree.rest(tree.corners(t)[i]);
    return x;
}

}  // namespace tetfront
