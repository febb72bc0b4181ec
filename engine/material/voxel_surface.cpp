#include "engine/material/voxel_surface.hpp"

#include "engine/base/error.hpp"
#include "engine/mesh/surface_nets.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace tetfront {

namespace {

/// Which voxels are inside, and the box around their centres.
class Mask {
 public:
    Mask(const VoxelImage& image, const std::set<long long>& labels) : image_(image) {
        const auto wanted = [&](double value) {
            if (labels.empty()) return value != 0 && !std::isnan(value);
            return value == std::floor(value) && std::abs(value) < 9e15 && labels.contains(static_cast<long long>(value));
        };
        const auto [nx, ny, nz] = image.size;
        inside_.reserve(static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny) * static_cast<std::size_t>(nz));
        double last = 0;
        bool last_wanted = wanted(0);
        for (int k = 0; k < nz; ++k)
            for (int j = 0; j < ny; ++j)
                for (int i = 0; i < nx; ++i) {
                    const double value = image.at({i, j, k});
                    if (value != last) last_wanted = wanted(value);
                    last = value;
                    inside_.push_back(last_wanted);
                    if (last_wanted) box_.extend(image.origin + image.directions * Vec3(i, j, k));
                }
        if (box_.isEmpty()) {
            throw InputError(image.source, labels.empty() ? "" : "label " + std::to_string(*labels.begin()),
                             labels.empty() ? "is 0 everywhere" : "occurs nowhere, nor do the others",
                             "name labels that the image has");
        }
        // Whole voxels, not their centres.
        const Vec3 half = image.directions.cwiseAbs().rowwise().sum() / 2;
        box_ = Eigen::AlignedBox3d(box_.min() - half, box_.max() + half);
    }

    [[nodiscard]] const Eigen::AlignedBox3d& box() const { return box_; }
    /// Share of wanted voxels in a cube around x, from n^3 samples.
    [[nodiscard]] double share(const Vec3& x, double edge, int n) const {
        int hits = 0;
        for (int c = 0; c < n; ++c)
            for (int b = 0; b < n; ++b)
                for (int a = 0; a < n; ++a) {
                    const Vec3 offset = (Vec3(a, b, c).array() + 0.5) / n - 0.5;
                    hits += inside(x + edge * offset);
                }
        return static_cast<double>(hits) / (n * n * n);
    }

 private:
    [[nodiscard]] bool inside(const Vec3& x) const {
        const Vec3 p = image_.continuous_index(x);
        if (!image_.contains(p)) return false;
        const auto v = image_.nearest(p);
        const auto nx = static_cast<std::size_t>(image_.size[0]), ny = static_cast<std::size_t>(image_.size[1]);
        return inside_[(static_cast<std::size_t>(v[2]) * ny + static_cast<std::size_t>(v[1])) * nx +
                       static_cast<std::size_t>(v[0])] != 0;
    }

    const VoxelImage& image_;
    std::vector<char> inside_;
    Eigen::AlignedBox3d box_;
};

}  // namespace

double voxel_extent(const VoxelImage& image, const std::set<long long>& labels) {
    return Mask(image, labels).box().sizes().maxCoeff();
}

SurfaceMesh voxel_surface(const VoxelImage& image, const std::set<long long>& labels, double cell) {
    const Mask mask(image, labels);
    const double voxel = image.directions.colwise().norm().minCoeff();
    const int n = std::clamp(static_cast<int>(std::ceil(2 * cell / voxel)), 2, 5);
    const Vec3 margin = Vec3::Constant(cell);
    SurfaceMesh surface = surface_nets(mask.box().min() - margin, mask.box().max() + margin, cell,
                                       [&](const Vec3& x) { return mask.share(x, 2 * cell, n); });
    if (surface.triangles.empty())
        throw InputError(image.source, "", "has no part that is as thick as " + std::to_string(cell) + " m",
                         "use a smaller surface_cell");
    return surface;
}

}  // namespace tetfront
