#include "engine/material/zones.hpp"

#include "engine/base/error.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>

namespace tetfront {

namespace {

class Layers : public ZoneFunction {
 public:
    Layers(int axis, std::vector<double> boundaries) : axis_(axis), boundaries_(std::move(boundaries)) {}

    int zone(const Vec3& x, TetId) const override { return index(x[axis_]); }
    bool one_zone_within(const Eigen::AlignedBox3d& box, TetId) const override {
        return index(box.min()[axis_]) == index(box.max()[axis_]);
    }
    void hash_into(Hash& hash) const override { hash.add("layers").add(axis_).add_range(boundaries_); }

 private:
    [[nodiscard]] int index(double x) const {
        return static_cast<int>(std::upper_bound(boundaries_.begin(), boundaries_.end(), x) - boundaries_.begin());
    }
    int axis_;
    std::vector<double> boundaries_;
};

enum class Side { inside, outside, cut };
Side side_of(bool all_inside, bool all_outside) {
    return all_inside ? Side::inside : all_outside ? Side::outside : Side::cut;
}

Side relation(const Sphere& s, const Eigen::AlignedBox3d& box) {
    const Vec3 farthest = (s.centre - box.min()).cwiseAbs().cwiseMax((s.centre - box.max()).cwiseAbs());
    return side_of(farthest.norm() <= s.radius, box.exteriorDistance(s.centre) > s.radius);
}
Side relation(const Box& s, const Eigen::AlignedBox3d& box) {
    const Eigen::AlignedBox3d shape(s.low, s.high);
    return side_of(shape.contains(box), !shape.intersects(box));
}
Side relation(const HalfSpace& s, const Eigen::AlignedBox3d& box) {
    const double centre = (box.center() - s.point).dot(s.normal);
    const double reach = 0.5 * box.sizes().dot(s.normal.cwiseAbs());
    return side_of(centre + reach <= 0, centre - reach > 0);
}

void validate(const Sphere& s, const std::string& name) {
    if (!(s.radius > 0) || !std::isfinite(s.radius) || !s.centre.allFinite())
        throw InputError("", name, "has radius " + std::to_string(s.radius), "use a finite radius above 0");
}
void validate(const Box& s, const std::string& name) {
    if (!(s.low.array() < s.high.array()).all() || s.low.hasNaN() || s.high.hasNaN())
        throw InputError("", name, "is an empty box", "low must be below high along each axis");
}
void validate(const HalfSpace& s, const std::string& name) {
    if (!(s.normal.norm() > 0) || !s.normal.allFinite() || !s.point.allFinite())
        throw InputError("", name, "has no direction", "use a finite normal that is not zero");
}

void hash_shape(Hash& hash, const Sphere& s) { hash.add("sphere").add_bytes(s.centre.data(), 24).add(s.radius); }
void hash_shape(Hash& hash, const Box& s) {
    hash.add("box").add_bytes(s.low.data(), 24).add_bytes(s.high.data(), 24);
}
void hash_shape(Hash& hash, const HalfSpace& s) {
    hash.add("half-space").add_bytes(s.point.data(), 24).add_bytes(s.normal.data(), 24);
}

class Shapes : public ZoneFunction {
 public:
    Shapes(std::vector<ZoneShape> shapes, int background) : shapes_(std::move(shapes)), background_(background) {
        // The one that wins first.
        std::reverse(shapes_.begin(), shapes_.end());
        std::stable_sort(shapes_.begin(), shapes_.end(),
                         [](const ZoneShape& a, const ZoneShape& b) { return a.priority > b.priority; });
    }
    int zone(const Vec3& x, TetId) const override {
        for (const ZoneShape& s : shapes_) {
            if (contains(s.region, x)) return s.zone;
        }
        return background_;
    }
    bool one_zone_within(const Eigen::AlignedBox3d& box, TetId) const override {
        for (const ZoneShape& s : shapes_) {
            const Side side = std::visit([&](const auto& shape) { return relation(shape, box); }, s.region);
            if (side != Side::outside) return side == Side::inside;
        }
        return true;
    }
    void hash_into(Hash& hash) const override {
        hash.add("shapes").add(background_);
        for (const ZoneShape& s : shapes_) {
            hash.add(s.zone);
            std::visit([&](const auto& shape) { hash_shape(hash, shape); }, s.region);
        }
    }

 private:
    std::vector<ZoneShape> shapes_;
    int background_;
};

class Labels : public ZoneFunction {
 public:
    Labels(std::shared_ptr<const VoxelImage> image, std::map<long long, int> zones, std::optional<int> otherwise)
        : image_(std::move(image)), zones_(std::move(zones)), otherwise_(otherwise) {}

    int zone(const Vec3& x, TetId) const override {
        const Vec3 p = image_->continuous_index(x);
        const bool inside = image_->contains(p);
        if (!inside && otherwise_) return *otherwise_;
        const std::array<int, 3> voxel = image_->nearest(p);
        const double label = image_->at(voxel);
        if (inside && label == std::floor(label) && std::abs(label) < 9e15) {
            const auto found = zones_.find(static_cast<long long>(label));
            if (found != zones_.end()) return found->second;
        }
        if (otherwise_) return *otherwise_;
        std::ostringstream where, problem;
        where << image_->describe(voxel) << " at position (" << x.transpose() << ')';
        if (inside) {
            problem << "has label " << label << ", which no material is given for";
        } else {
            problem << "is the nearest to a part of the object outside of the image";
        }
        throw InputError(image_->source, where.str(), problem.str(),
                         "give a material for that label, or one for everything else (otherwise)");
    }
    bool one_zone_within(const Eigen::AlignedBox3d& box, TetId) const override {
        return image_->one_value_within(box, 0);
    }
    void hash_into(Hash& hash) const override {
        hash.add("labels").add(otherwise_.value_or(-1)).add(zones_.size());
        for (const auto& [label, zone] : zones_) hash.add(label).add(zone);
        image_->hash_into(hash);
    }

 private:
    std::shared_ptr<const VoxelImage> image_;
    std::map<long long, int> zones_;
    std::optional<int> otherwise_;
};

class RootZones : public ZoneFunction {
 public:
    explicit RootZones(std::vector<int> zones) : zones_(std::move(zones)) {}
    int zone(const Vec3&, TetId root) const override {
        if (!root.valid() || root.index() >= zones_.size()) {
            throw InputError("", "tet " + std::to_string(root.value),
                             "has no material among the " + std::to_string(zones_.size()) + " given",
                             "give one for each tet of the input mesh");
        }
        return zones_[root.index()];
    }
    bool one_zone_within(const Eigen::AlignedBox3d&, TetId) const override { return true; }
    void hash_into(Hash& hash) const override { hash.add("root zones").add_range(zones_); }

 private:
    std::vector<int> zones_;
};

}  // namespace

Zones layers(int axis, std::vector<double> boundaries) {
    ENSURE(axis >= 0 && axis < 3, "axis ", axis);
    for (std::size_t i = 0; i < boundaries.size(); ++i) {
        if (!std::isfinite(boundaries[i]) || (i > 0 && !(boundaries[i - 1] < boundaries[i]))) {
            throw InputError("", "boundaries/" + std::to_string(i), "is " + std::to_string(boundaries[i]),
                             "use finite numbers in ascending order");
        }
    }
    return std::make_shared<Layers>(axis, std::move(boundaries));
}

Zones shapes(std::vector<ZoneShape> list, int background_zone) {
    for (std::size_t i = 0; i < list.size(); ++i) {
        std::visit([&](const auto& shape) { validate(shape, "shapes/" + std::to_string(i)); }, list[i].region);
    }
    return std::make_shared<Shapes>(std::move(list), background_zone);
}

Zones labels(std::shared_ptr<const VoxelImage> image, std::map<long long, int> zone_of_label,
             std::optional<int> otherwise) {
    return std::make_shared<Labels>(std::move(image), std::move(zone_of_label), otherwise);
}

Zones root_zones(std::vector<int> zone_of_root) { return std::make_shared<RootZones>(std::move(zone_of_root)); }

}  // namespace tetfront
