#pragma once
// A three-dimensional image: labels or a measured scalar, with its place in space. Read from NRRD (raw or gzip) or
// INRIMAGE-4 (.inr, .inr.gz).
//
//     auto image = std::make_shared<VoxelImage>(read_voxel_image("liver.inr.gz"));
//     image->at({10, 20, 30});                            // value of a voxel
//     image->at(image->nearest(image->continuous_index(x)));   // at a position
//
// Positions are those of voxel centres: voxel (i, j, k) is at origin + directions (i, j, k).

#include "engine/base/hash.hpp"
#include "engine/base/types.hpp"

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace tetfront {

struct VoxelImage {
    enum class Type { int8, uint8, int16, uint16, int32, uint32, int64, uint64, float32, float64 };

    std::string source;         // file name for messages
    std::array<int, 3> size{};  // voxels along i, j, k; each >= 1
    Type type = Type::uint8;
    std::vector<std::byte> data;         // [size product * bytes of type] this machine's byte order, i fastest
    Vec3 origin = Vec3::Zero();          // [m] centre of voxel (0, 0, 0)
    Mat3 directions = Mat3::Identity();  // [m] columns: steps from voxel to voxel along i, j, k; invertible

    /// Value of a voxel, which must exist.
    [[nodiscard]] double at(const std::array<int, 3>& voxel) const;
    /// x: position [m]. Returns (i, j, k) with fractions; not clamped.
    [[nodiscard]] Vec3 continuous_index(const Vec3& x) const { return to_index_ * (x - origin); }
    /// The voxel whose centre is nearest, along each of the image's axes; clamped to the image.
    [[nodiscard]] std::array<int, 3> nearest(const Vec3& continuous_index) const;
    /// True when `continuous_index` lies in some voxel's cell.
    [[nodiscard]] bool contains(const Vec3& continuous_index) const;
    /// True only when all voxels that a position in the box may be nearest to (widened by `margin` voxels) have one
    /// value and are in the image.
    [[nodiscard]] bool one_value_within(const Eigen::AlignedBox3d& box, int margin) const;
    /// "voxel (i, j, k)".
    [[nodiscard]] std::string describe(const std::array<int, 3>& voxel) const;

    /// Puts the image elsewhere. Throws InputError when the directions are not invertible or not finite.
    void place(const Vec3& origin, const Mat3& directions);
    void hash_into(Hash& hash) const;

 private:
    Mat3 to_index_ = Mat3::Identity();
};

/// Bytes of one value.
std::size_t size_of(VoxelImage::Type type);

/// Throws InputError for a file that cannot be read, is no NRRD or INRIMAGE-4, has other than three dimensions or one
/// value per voxel, uses a feature that is not supported, or holds fewer voxels than it promises.
VoxelImage read_voxel_image(const std::filesystem::path& file);

}  // namespace tetfront
