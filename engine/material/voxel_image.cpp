#include "engine/material/voxel_image.hpp"

#include "engine/base/error.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <sstream>

namespace tetfront {

namespace {

template <class T>
double value_at(const std::byte* p) {
    T value;
    std::memcpy(&value, p, sizeof value);
    return static_cast<double>(value);
}

}  // namespace

std::size_t size_of(VoxelImage::Type type) {
    switch (type) {
        case VoxelImage::Type::int8:
        case VoxelImage::Type::uint8:
            return 1;
        case VoxelImage::Type::int16:
        case VoxelImage::Type::uint16:
            return 2;
        case VoxelImage::Type::int32:
        case VoxelImage::Type::uint32:
        case VoxelImage::Type::float32:
            return 4;
        case VoxelImage::Type::int64:
        case VoxelImage::Type::uint64:
        case VoxelImage::Type::float64:
            return 8;
    }
    return 0;
}

double VoxelImage::at(const std::array<int, 3>& voxel) const {
    const auto i = static_cast<std::size_t>(voxel[0]), j = static_cast<std::size_t>(voxel[1]),
               k = static_cast<std::size_t>(voxel[2]);
    const std::size_t index = i + static_cast<std::size_t>(size[0]) * (j + static_cast<std::size_t>(size[1]) * k);
    const std::byte* p = data.data() + index * size_of(type);
    switch (type) {
        case Type::int8:
            return value_at<std::int8_t>(p);
        case Type::uint8:
            return value_at<std::uint8_t>(p);
        case Type::int16:
            return value_at<std::int16_t>(p);
        case Type::uint16:
            return value_at<std::uint16_t>(p);
        case Type::int32:
            return value_at<std::int32_t>(p);
        case Type::uint32:
            return value_at<std::uint32_t>(p);
        case Type::int64:
            return value_at<std::int64_t>(p);
        case Type::uint64:
            return value_at<std::uint64_t>(p);
        case Type::float32:
            return value_at<float>(p);
        case Type::float64:
            return value_at<double>(p);
    }
    return 0;
}

std::array<int, 3> VoxelImage::nearest(const Vec3& p) const {
    std::array<int, 3> voxel{};
    for (int axis = 0; axis < 3; ++axis) {
        const int last = size[static_cast<std::size_t>(axis)] - 1;
        voxel[static_cast<std::size_t>(axis)] =
            static_cast<int>(std::clamp(std::floor(p[axis] + 0.5), 0.0, static_cast<double>(last)));
    }
    return voxel;
}

bool VoxelImage::contains(const Vec3& p) const {
    constexpr double rounding = 1e-9;  // an image that just covers an object covers its surface, too
    for (int axis = 0; axis < 3; ++axis)
        if (!(p[axis] >= -0.5 - rounding && p[axis] <= size[static_cast<std::size_t>(axis)] - 0.5 + rounding)) return false;
    return true;
}

bool VoxelImage::one_value_within(const Eigen::AlignedBox3d& box, int margin) const {
    Eigen::AlignedBox3d index_box;
    for (int corner = 0; corner < 8; ++corner) {
        index_box.extend(continuous_index(box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner))));
    }
    if (!contains(index_box.min()) || !contains(index_box.max())) return false;
    const std::array<int, 3> low = nearest(index_box.min() - Vec3::Constant(margin)),
                             high = nearest(index_box.max() + Vec3::Constant(margin));
    const double first = at(low);
    for (int k = low[2]; k <= high[2]; ++k)
        for (int j = low[1]; j <= high[1]; ++j)
            for (int i = low[0]; i <= high[0]; ++i)
                if (at({i, j, k}) != first) return false;
    return true;
}

std::string VoxelImage::describe(const std::array<int, 3>& voxel) const {
    std::ostringstream out;
    out << "voxel (" << voxel[0] << ", " << voxel[1] << ", " << voxel[2] << ')';
    return out.str();
}

void VoxelImage::place(const Vec3& new_origin, const Mat3& new_directions) {
    const double determinant = new_directions.determinant();
    const double scale = new_directions.colwise().norm().prod();
    if (!std::isfinite(determinant) || !(std::abs(determinant) > 1e-9 * scale) || !new_origin.allFinite()) {
        throw InputError(source, "voxel directions", "do not span space", "use three independent, finite directions");
    }
    if (const auto steps = new_directions.colwise().norm(); !(steps.minCoeff() >= 1e-12 && steps.maxCoeff() <= 1e12))
        throw InputError(source, "voxel directions", "are out of proportion", "use voxels of 1e-12 to 1e12 units");
    if (!(new_origin.cwiseAbs().maxCoeff() <= 1e9 * new_directions.colwise().norm().maxCoeff()))
        throw InputError(source, "origin", "is more than 1e9 voxels away", "move the image");
    origin = new_origin;
    directions = new_directions;
    to_index_ = new_directions.inverse();
}

void VoxelImage::hash_into(Hash& hash) const {
    hash.add_range(size).add(type).add_range(data);
    hash.add_bytes(origin.data(), sizeof(double) * 3).add_bytes(directions.data(), sizeof(double) * 9);
}

}  // namespace tetfront
