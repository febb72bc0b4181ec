#pragma once
// A pack of doubles that one instruction works on, so that element kernels handle several tets at a time.
//
// Kernels are templates over the scalar: `double` in tests and for single points, `Pack` in batches. `select` and the
// functions below are what both have in common; kernels use them instead of branches.
//
//     template <class T> T kernel(const T& x) { return select(x < T(0), -x, x); }

#include <cmath>
#include <cstddef>
#include <experimental/simd>

namespace tetfront {

using Pack = std::experimental::native_simd<double>;
inline constexpr std::size_t pack_size = Pack::size();

inline double select(bool condition, double yes, double no) { return condition ? yes : no; }
inline Pack select(const Pack::mask_type& condition, const Pack& yes, const Pack& no) {
    Pack result = no;
    std::experimental::where(condition, result) = yes;
    return result;
}
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
inline void store(const Pack& x, double* p) { x.copy_to(p, std::experimental::element_aligned); }

}  // namespace tetfront
