#pragma once
// Random fronts for tests.

#include "engine/tree/front.hpp"

#include <random>

namespace tetfront::testing {

/// Splits and merges at random, `rounds` times; commits after each round.
inline void shuffle(Front& front, std::mt19937& random, int rounds, double split_chance = 0.15,
                    double merge_chance = 0.15) {
    std::uniform_real_distribution<double> chance(0, 1);
    for (int round = 0; round < rounds; ++round) {
        const std::vector<TetId> active = front.active();
        for (TetId t : active)
            if (chance(random) < split_chance) front.split(t);
        for (TetId t : active) {
            if (front.tree().is_root(t) || chance(random) > merge_chance) continue;
            const TetId p = front.tree().parent(t);
            if (front.can_merge(p)) front.merge(p);
        }
        front.commit();
    }
}

inline Vec3 random_vector(std::mt19937& random) {
    std::normal_distribution<double> normal;
    return {normal(random), normal(random), normal(random)};
}

}  // namespace tetfront::testing
