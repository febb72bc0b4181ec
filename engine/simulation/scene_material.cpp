#include "engine/simulation/scene_material.hpp"

#include "engine/base/error.hpp"
#include "engine/base/overloaded.hpp"

#include <Eigen/Geometry>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <utility>

namespace tetfront {

namespace {

class Maker {
 public:
    Maker(const Scene& scene, const TetMesh& roots) : scene_(scene), roots_(roots) {
        for (const Vec3& p : roots.positions) box_.extend(p);
    }

    StiffnessFunction make() {
        const MaterialSpec& spec = scene_.material;
        std::vector<MaterialFunction> materials;
        for (const ElasticSpec& material : spec.materials) materials.push_back(function(material));
        if (std::holds_alternative<std::monostate>(spec.zones)) return StiffnessFunction(std::move(materials.front()));
        return StiffnessFunction(zones(), std::move(materials));
    }

 private:
    [[noreturn]] void fail(const std::string& pointer, const std::string& problem, const std::string& remedy) const {
        throw InputError(scene_.file.string(), pointer, problem, remedy);
    }

    std::shared_ptr<const VoxelImage> image(const std::filesystem::path& file, double scale) {
        auto& image = images_[{file, scale}];
        if (!image) {
            image = std::make_shared<const VoxelImage>(scaled_image(file, scale));
        }
        return image;
    }

    Scalar scalar(const ScalarSpec& spec) {
        return std::visit(
            Overloaded{[](double value) { return constant(value); },
                       [&](const GradientSpec& g) {
                           const std::array extent = {box_.min()[g.axis], box_.max()[g.axis]};
                           return gradient(g.axis, g.at.value_or(extent), g.values, g.interpolation);
                       },
                       [&](const VoxelsSpec& v) {
                           auto& made = voxels_[{v.file, v.scale, v.factor, v.sampling}];
                           if (!made) made = voxel_scalar(image(v.file, v.scale), v.sampling, v.factor, 0);
                           return made;
                       },
                       [&](const PerTetSpec& list) {
                           if (list.values.size() != roots_.corners.size())
                               fail(list.pointer, "has " + std::to_string(list.values.size()) + " values",
                                    "the coarsest level has " + std::to_string(roots_.corners.size()) +
                                        " tets: give one value for each");
                           return per_root(list.values);
                       }},
            spec);
    }

    MaterialFunction function(const ElasticSpec& spec) {
        MaterialFunction f;
        f.young = scalar(spec.young);
        f.poisson = scalar(spec.poisson);
        f.density = scalar(spec.density);
        f.mass_damping = scalar(spec.mass_damping);
        f.stiffness_damping = scalar(spec.stiffness_damping);
        f.orthotropic = spec.orthotropic;
        if (spec.orthotropic) f.scale = scalar(spec.scale);
        return f;
    }

    Zones zones() {
        return std::visit(
            Overloaded{[](std::monostate) -> Zones { return nullptr; },
                       [](const LayersSpec& l) { return layers(l.axis, l.boundaries); },
                       [](const ShapesSpec& s) { return shapes(s.shapes, 0); },
                       [&](const LabelsSpec& l) { return labels(image(l.file, l.scale), l.zone_of_label, l.otherwise); },
                       [&](const RegionsSpec& r) { return region_zones(r); }},
            scene_.material.zones);
    }

    Zones region_zones(const RegionsSpec& spec) const {
        std::vector<int> zone_of_root;
        for (std::size_t t = 0; t < roots_.corners.size(); ++t) {
            const int region = roots_.region.empty() ? 0 : roots_.region[TetId(static_cast<std::int64_t>(t))];
            const auto found = spec.zone_of_region.find(region);
            if (found == spec.zone_of_region.end() && !spec.otherwise)
                fail("/material/regions/materials", "has none for region " + std::to_string(region) + " of tet " + std::to_string(t),
                     "name that region, or give `otherwise`");
            zone_of_root.push_back(found == spec.zone_of_region.end() ? *spec.otherwise : found->second);
        }
        return root_zones(std::move(zone_of_root));
    }

    const Scene& scene_;
    const TetMesh& roots_;
    Eigen::AlignedBox3d box_;
    std::map<std::pair<std::filesystem::path, double>, std::shared_ptr<const VoxelImage>> images_;
    std::map<std::tuple<std::filesystem::path, double, double, VoxelSampling>, Scalar> voxels_;
};

}  // namespace

VoxelImage scaled_image(const std::filesystem::path& file, double scale) {
    VoxelImage image = read_voxel_image(file);
    image.place(scale * image.origin, scale * image.directions);
    return image;
}

StiffnessFunction make_stiffness(const Scene& scene, const TetMesh& roots) { return Maker(scene, roots).make(); }

EstimationSettings estimation_settings(const EstimationSpec& spec) {
    using Method = EstimationSpec::Method;
    EstimationSettings settings;
    switch (spec.method) {
        case Method::average: settings.problem = CellProblem::average; break;
        case Method::mean_strain: settings.problem = CellProblem::mean_strain; break;
        case Method::isolated: settings.problem = CellProblem::isolated; break;
        case Method::uniform_stress: settings.problem = CellProblem::uniform_stress; break;
    }
    if (spec.sampled)
        settings.sampling = SamplingSettings{.alphas = spec.alphas,
                                             .relative_tolerance = spec.relative_tolerance,
                                             .stress_tolerance = spec.stress_tolerance};
    return settings;
}

}  // namespace tetfront
