#pragma once
// Holds the engine to fewer threads than there are processors, for as long as it lives. Results do not depend on it.
//
//     const ThreadLimit one(1);
//     simulation.step();

#include <cstddef>

#include <tbb/global_control.h>

namespace tetfront {

class ThreadLimit {
 public:
    /// threads >= 1. Of several limits the lowest holds.
    explicit ThreadLimit(int threads) : control_(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads)) {}

 private:
    tbb::global_control control_;
};

}  // namespace tetfront
