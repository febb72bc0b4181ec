#pragma once
// Which of several materials is where: layers, shapes with priorities, the labels of a voxel image, or the regions of
// the input mesh.
//
//     Zones bands = layers(0, {1, 2, 3});                       // zone 0 below x = 1, 1 from 1 to 2, 2, 3
//     Zones core = shapes({{Sphere{{0, 0, 0}, 0.5}, 1, 0}}, 0);
//     Zones organ = labels(image, {{1, 0}, {2, 1}, {0, 0}}, 0);  // image label -> zone
//     bands->zone(x, root)

#include "engine/base/hash.hpp"
#include "engine/base/region.hpp"
#include "engine/base/types.hpp"
#include "engine/material/voxel_image.hpp"

#include <Eigen/Geometry>
#include <map>
#include <memory>
#include <optional>
#include <vector>

namespace tetfront {

class ZoneFunction {
 public:
    virtual ~ZoneFunction() = default;
    /// Index of the material at rest position x of input tet `root`.
    [[nodiscard]] virtual int zone(const Vec3& x, TetId root) const = 0;
    /// True only when zone() is one and the same in the whole box.
    [[nodiscard]] virtual bool one_zone_within(const Eigen::AlignedBox3d& box, TetId root) const = 0;
    /// Everything that zone() depends on.
    virtual void hash_into(Hash& hash) const = 0;
};
using Zones = std::shared_ptr<const ZoneFunction>;

/// Zone i is where boundaries[i - 1] <= x[axis] < boundaries[i]. Throws InputError unless the boundaries ascend.
Zones layers(int axis, std::vector<double> boundaries);

struct ZoneShape {
    Region region;
    int zone = 0;
    int priority = 0;  // the highest wins; of equals, the one later in the list
};
/// Throws InputError that names the shape when a radius is not positive, a box is empty or a normal is zero.
Zones shapes(std::vector<ZoneShape> shapes, int background_zone);

/// Zone of the image's label at x. otherwise: zone of labels that the map does not name and of positions outside of the
/// image; without it such a position is an InputError that names voxel, label and position.
Zones labels(std::shared_ptr<const VoxelImage> image, std::map<long long, int> zone_of_label,
             std::optional<int> otherwise = {});

/// One zone per input tet. Asking for a root outside of the list is an InputError.
Zones root_zones(std::vector<int> zone_of_root);

}  // namespace tetfront
