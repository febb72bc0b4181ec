#pragma once
// Operations of the element kernels, counted by running them on a scalar that counts: additions, multiplications, divisions
// and roots are one each; selections and signs are none.
//
//     double flops = strain_flops<2, GreenPoint>();

#include "engine/mechanics/strain.hpp"

namespace tetfront {

struct Counting {
    double value = 0;
    static inline long operations = 0;

    Counting() = default;
    Counting(double v) : value(v) {}
    static Counting counted(double v) {
        ++operations;
        return {v};
    }
    friend Counting operator+(Counting a, Counting b) { return counted(a.value + b.value); }
    friend Counting operator-(Counting a, Counting b) { return counted(a.value - b.value); }
    friend Counting operator*(Counting a, Counting b) { return counted(a.value * b.value); }
    friend Counting operator/(Counting a, Counting b) { return counted(a.value / b.value); }
    Counting operator-() const { return {-value}; }
    Counting& operator+=(Counting b) { return *this = *this + b; }
    Counting& operator-=(Counting b) { return *this = *this - b; }
    Counting& operator*=(Counting b) { return *this = *this * b; }
    friend bool operator<(Counting a, Counting b) { return a.value < b.value; }
};
inline Counting select(bool condition, Counting yes, Counting no) { return condition ? yes : no; }
inline Counting sqrt(Counting x) { return Counting::counted(std::sqrt(x.value)); }

namespace detail {

/// Operations of work(x, gradients) on a slightly deformed reference tet.
template <int Order, class Work>
double operations_of(const Work& work) {
    std::array<V3<Counting>, ElementOrder<Order>::nodes> x;
    for (std::size_t i = 0; i < x.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c) x[i][c] = Counting(0.1 * static_cast<double>((i * 7 + c * 3) % 5));
    Gradients<Counting> g = M3<Counting>::identity();
    Counting::operations = 0;
    work(x, g);
    return static_cast<double>(Counting::operations);
}

}  // namespace detail

template <int Order, template <class> class Strain>
double strain_flops() {
    return detail::operations_of<Order>([](const auto& x, const auto& g) {
        for (int q = 0; q < ElementOrder<Order>::points; ++q) (void)Strain<Counting>(deformation_gradient<Order>(x, q, g)).strain();
    });
}

/// Strain, stress, energy and nodal forces.
template <int Order, template <class> class Strain>
double force_flops() {
    return detail::operations_of<Order>([](const auto& x, const auto& g) {
        const std::array<Counting, 21> c{};
        for (int q = 0; q < ElementOrder<Order>::points; ++q) {
            const Strain<Counting> point(deformation_gradient<Order>(x, q, g));
            const V6<Counting> strain = point.strain(), stress = hooke(c, strain);
            (void)dot(strain, stress);
            (void)mul_bt(point.piola(stress), g);
            Counting::operations += 3 + 9 + 6;  // energy, scale, first corner
            for (int i = 0; i < ElementOrder<Order>::nodes; ++i)
                for (int k = 0; k < 4; ++k) Counting::operations += shape_derivative<Order>(q, k, i) != 0 ? 6 : 0;
        }
    });
}

/// What the tangent needs on top of the force (the geometric part of Green strain is not counted).
template <int Order>
double tangent_flops() {
    const double per_tet = detail::operations_of<Order>([](const auto&, const auto& g) {
        const std::array<Counting, 21> c{};
        const auto core = material_blocks(c, g);
        for (int q = 0; q < ElementOrder<Order>::points; ++q) {
            for (std::size_t k = 0; k < 3; ++k)
                for (std::size_t l = k; l < 3; ++l) (void)mul_bt(mul(g, core[k][l]), g);
            Counting::operations += 6 * 9 + 4 * 2 * 9;  // scale, and the blocks of the first corner
        }
    });
    // Node blocks of order 2: NodeBlocks<2>::prepare, then 7 additions for each of 21 + 24 blocks and 8 for the 10 of the corners.
    return Order == 1 ? per_tet : per_tet + 9 * (16 * 12 + 45 * 7 + 10 * 8);
}

}  // namespace tetfront
