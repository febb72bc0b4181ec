#pragma once
// One value per entity, of which many are equal: each is stored once, and entities hold its number. A uniform object of
// a million tets then has one elasticity matrix, not 168 MB of them.
//
//     PooledPerTet<Sym6> c(tree.tet_count(), steel);     // the same everywhere
//     PooledPerTet<Sym6> d(values, numbers);             // d[t] is values[numbers[t]]
//     c[t](0, 0)

#include "engine/base/types.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

namespace tetfront {

template <class IdType, class T>
class Pooled {
 public:
    using Number = std::uint32_t;

    Pooled() = default;
    Pooled(std::size_t size, const T& value) : values_{value}, numbers_(size, 0) {}
    /// numbers: each below values.size().
    Pooled(std::vector<T> values, std::vector<Number> numbers) : values_(std::move(values)), numbers_(std::move(numbers)) {}
    /// Keeps equal neighbours once.
    explicit Pooled(const PerId<IdType, T>& all) {
        numbers_.reserve(all.size());
        for (const T& value : all) {
            if (values_.empty() || !(values_.back() == value)) values_.push_back(value);
            numbers_.push_back(static_cast<Number>(values_.size() - 1));
        }
    }

    const T& operator[](IdType i) const { return values_[numbers_[i.index()]]; }
    [[nodiscard]] std::size_t size() const { return numbers_.size(); }
    [[nodiscard]] bool empty() const { return numbers_.empty(); }
    [[nodiscard]] const std::vector<T>& values() const { return values_; }
    [[nodiscard]] const std::vector<Number>& numbers() const { return numbers_; }
    [[nodiscard]] std::size_t memory_bytes() const {
        return values_.capacity() * sizeof(T) + numbers_.capacity() * sizeof(Number);
    }
    /// The same value for each entity, however stored.
    friend bool operator==(const Pooled& a, const Pooled& b) {
        if (a.size() != b.size()) return false;
        for (std::size_t i = 0; i < a.size(); ++i)
            if (!(a.values_[a.numbers_[i]] == b.values_[b.numbers_[i]])) return false;
        return true;
    }

 private:
    std::vector<T> values_;
    std::vector<Number> numbers_;
};
template <class T>
using PooledPerTet = Pooled<TetId, T>;

}  // namespace tetfront
