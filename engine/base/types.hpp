#pragma once
// Index types and Eigen aliases that the whole engine shares.
//
// Every entity has its own index type, so that a tet index cannot be used where a vertex index is meant. Arrays that
// hold one value per entity are `PerVertex<T>` and `PerTet<T>`: a std::vector that is subscripted by its own index
// type only.
//
//     PerVertex<Vec3> positions(vertex_count);
//     positions[VertexId{3}] = Vec3(0, 0, 1);
//     for (VertexId v : ids<VertexId>(vertex_count)) positions[v] *= 2;
//
// Units are SI everywhere: metres, kilograms, seconds, newtons, pascals.

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <ranges>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace tetfront {

using Vec3 = Eigen::Vector3d;
using Vec4 = Eigen::Vector4d;
using Mat3 = Eigen::Matrix3d;
using Vec6 = Eigen::Matrix<double, 6, 1>;  // Voigt order xx yy zz yz xz xy, see voigt.hpp
using Mat6 = Eigen::Matrix<double, 6, 6>;

/// Index of one kind of entity. Default-constructed: invalid.
template <class Tag>
struct Id {
    std::int32_t value = -1;

    constexpr Id() = default;
    constexpr explicit Id(std::int64_t i) : value(static_cast<std::int32_t>(i)) {}
    [[nodiscard]] constexpr std::size_t index() const { return static_cast<std::size_t>(value); }
    [[nodiscard]] constexpr bool valid() const { return value >= 0; }
    friend constexpr auto operator<=>(Id, Id) = default;
};

using VertexId = Id<struct VertexTag>;
using TetId = Id<struct TetTag>;

/// One value per entity.
template <class IdType, class T>
class PerId : public std::vector<T> {
 public:
    using std::vector<T>::vector;
    decltype(auto) operator[](IdType i) { return std::vector<T>::operator[](i.index()); }
    decltype(auto) operator[](IdType i) const { return std::vector<T>::operator[](i.index()); }
};
template <class T>
using PerVertex = PerId<VertexId, T>;
template <class T>
using PerTet = PerId<TetId, T>;

/// The ids [begin, end).
template <class IdType>
auto ids(std::int64_t begin, std::int64_t end) {
    return std::views::iota(begin, end) | std::views::transform([](std::int64_t i) { return IdType(i); });
}
template <class IdType>
auto ids(std::size_t count) {
    return ids<IdType>(0, static_cast<std::int64_t>(count));
}

}  // namespace tetfront

template <class Tag>
struct std::hash<tetfront::Id<Tag>> {
    std::size_t operator()(tetfront::Id<Tag> i) const noexcept { return std::hash<std::int32_t>{}(i.value); }
};
