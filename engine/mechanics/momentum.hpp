#pragma once
// Momentum of a moving body; see ElementSet::momentum.

#include "engine/base/types.hpp"

namespace tetfront {

struct Momentum {
    Vec3 linear;   // sum_ij m_ij v_j [kg m/s]
    Vec3 angular;  // sum_ij x_i x m_ij v_j [kg m^2/s], about the origin
};

}  // namespace tetfront
