#pragma once
// Questions about a point and a triangle surface, answered by one bounding volume hierarchy: is it inside, and how far
// is the surface?
//
// The generalized winding number (Jacobson et al. 2013) is the solid angle of the surface seen from the point over
// 4 pi. For a closed surface it is 1 inside and 0 outside; with holes, flipped parts or overlaps it stays a smooth
// vote, so that "> 1/2" remains a good definition of inside. Far groups of triangles enter by their dipole and its
// first moment (Barill et al. 2018), which makes it O(log n) a point.
//
//     SurfaceBvh bvh(mesh);
//     bool inside = bvh.winding_number(p) > 0.5;
//     SurfaceBvh::Closest near = bvh.closest(p);       // distance, point, triangle
//
// Immutable once built; all questions are thread-safe and give the same bits in every thread.

#include "engine/mesh/tet_mesh.hpp"

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

namespace tetfront {

class SurfaceBvh {
 public:
    struct Closest {
        double distance = std::numeric_limits<double>::infinity();  // [m]
        Vec3 point = Vec3::Zero();
        std::int32_t triangle = -1;  // index into the mesh's triangles; -1: none within the limit
    };

    /// mesh: valid indices and finite positions, at least one triangle (LogicError). Degenerate triangles are allowed.
    explicit SurfaceBvh(const SurfaceMesh& mesh);

    /// Solid angle of the surface over 4 pi; a few 1e-3 accurate. On the surface itself: somewhere between both sides.
    [[nodiscard]] double winding_number(const Vec3& p) const;
    /// The same without the expansion: every triangle exactly, O(n).
    [[nodiscard]] double exact_winding_number(const Vec3& p) const;

    /// Nearest point of the surface that is closer than `limit` [m].
    [[nodiscard]] Closest closest(const Vec3& p, double limit = std::numeric_limits<double>::infinity()) const;

    [[nodiscard]] const Vec3& low() const { return nodes_[0].low; }  // bounding box
    [[nodiscard]] const Vec3& high() const { return nodes_[0].high; }

 private:
    struct Node {
        Vec3 low, high;                     // bounding box
        Vec3 center;                        // area-weighted mean of the triangles' centroids
        Vec3 dipole;                        // sum of area normals
        Mat3 first_moment;                  // sum of area normal x (centroid - center)
        std::array<Mat3, 3> second_moment;  // [i] half the integral of normal_i (x - center) x (x - center)
        Vec3 second_trace;                  // sum over i of 2 second_moment[i].row(i), plus the traces of second_moment
        double radius;                      // no triangle reaches farther from the center
        std::int32_t first, count;          // triangles [first, first + count)
        std::int32_t right;                 // second child; the first is the next node. -1: leaf
    };
    std::int32_t build(std::int32_t first, std::int32_t count, const std::vector<Vec3>& centroids);

    std::vector<Node> nodes_;
    std::vector<std::array<Vec3, 3>> triangles_;  // in the order of the leaves
    std::vector<std::int32_t> source_;            // [triangles_] index in the mesh
};

/// Nearest point to p of the triangle abc, which may be degenerate.
Vec3 closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace tetfront
