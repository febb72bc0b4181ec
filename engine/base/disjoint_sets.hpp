#pragma once
// A partition of 0..n-1 that only grows coarser: union and find.
//
//     DisjointSets sets(4);
//     sets.join(3, 1);
//     sets.find(3)                // 1: the smallest member stands for its set, in whatever order sets were joined

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace tetfront {

class DisjointSets {
 public:
    explicit DisjointSets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), std::size_t{0}); }
    std::size_t find(std::size_t i) {
        while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    void join(std::size_t i, std::size_t j) {
        i = find(i), j = find(j);
        parent_[std::max(i, j)] = std::min(i, j);
    }

 private:
    std::vector<std::size_t> parent_;
};

}  // namespace tetfront
