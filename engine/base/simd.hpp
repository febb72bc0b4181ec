#pragma once
// Packs of numbers that one instruction works on, so that element kernels handle several tets at a time.
//
// Kernels are templates over the scalar: `double` in tests and for single points, `Pack` of doubles in batches, `SinglePack` of
// twice as many floats where that is exact enough. `select` and the functions below are what all have in common; kernels use
// them instead of branches.
//
//     template <class T> T kernel(const T& x) { return select(x < T(0), constant<T>(-0.1) * x, x); }

#include <cmath>
#include <cstddef>
#include <experimental/simd>

namespace tetfront {

using Pack = std::experimental::native_simd<double>;
inline constexpr std::size_t pack_size = Pack::size();
using SinglePack = std::experimental::native_simd<float>;
static_assert(SinglePack::size() == 2 * pack_size);

/// A number that is no integer, in every lane.
template <class T>
T constant(double value) {
    return T(value);
}
template <>
inline SinglePack constant<SinglePack>(double value) {
    return static_cast<float>(value);
}
/// What a denominator that may be zero is kept away from it by: the square is still a number.
template <class T>
inline constexpr double nearly_zero = 1e-150;
template <>
inline constexpr double nearly_zero<SinglePack> = 1e-18;

inline double select(bool condition, double yes, double no) { return condition ? yes : no; }
inline Pack select(const Pack::mask_type& condition, const Pack& yes, const Pack& no) {
    Pack result = no;
    std::experimental::where(condition, result) = yes;
    return result;
}
inline SinglePack select(const SinglePack::mask_type& condition, const SinglePack& yes, const SinglePack& no) {
    SinglePack result = no;
    std::experimental::where(condition, result) = yes;
    return result;
}
inline SinglePack sqrt(const SinglePack& x) { return std::experimental::sqrt(x); }
inline double sqrt(double x) { return std::sqrt(x); }
inline Pack sqrt(const Pack& x) { return std::experimental::sqrt(x); }

template <class T>
T max(const T& a, const T& b) {
    return select(a < b, b, a);
}
template <class T>
T abs_of(const T& a) {
    return select(a < T(0), -a, a);
}

inline Pack load(const double* p) { return Pack(p, std::experimental::element_aligned); }
inline SinglePack load(const float* p) { return SinglePack(p, std::experimental::element_aligned); }
inline void store(const Pack& x, double* p) { x.copy_to(p, std::experimental::element_aligned); }

}  // namespace tetfront
