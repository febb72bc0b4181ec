// Figures 10, 12 and 13: a bunny, an armadillo and a liver whose stiffness varies.
#include "engine/material/voxel_surface.hpp"
#include "engine/simulation/scene_material.hpp"
#include "engine/tree/surface.hpp"
#include "server/cli/paper_figures.hpp"
#include "server/cli/report_head.hpp"
#include "server/render/sheet.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <set>

namespace tetfront {

namespace {

std::string centimetres(double metres) { return format_number(100 * metres, "%.1f") + " cm"; }
std::string percent_of(double fraction) { return format_number(100 * fraction, "%.1f") + " %"; }

void advance(PaperWork& work, Simulation& simulation, int steps, const std::string& what) {
    for (int i = 0; i < steps; ++i) {
        simulation.step();
        work.show(what, static_cast<double>(i + 1) / steps);
    }
}

/// Mean over the surface vertices whose rest position satisfies `where` of their displacement [m].
template <class Where>
Vec3 mean_displacement(Simulation& simulation, const Where& where) {
    const Surface& surface = simulation.model().surface;
    const auto frame = simulation.frame();
    Vec3 sum = Vec3::Zero();
    double count = 0;
    for (std::size_t i = 0; i < surface.mesh.positions.size(); ++i) {
        if (!where(surface.mesh.positions[i])) continue;
        const auto& p = frame->surface[i];
        sum += Vec3(p[0], p[1], p[2]) - surface.mesh.positions[i];
        ++count;
    }
    return count > 0 ? Vec3(sum / count) : sum;
}

/// How far the highest tenth of the object and its lower half have come down, over its height.
std::array<double, 2> drops(Simulation& simulation) {
    const FrameModel& model = *simulation.model().frame_model;
    const auto up = static_cast<std::size_t>(model.up);
    const double low = model.rest_box[up], height = model.rest_box[up + 3] - low;
    const auto drop = [&](double from, double to) {
        return -mean_displacement(simulation, [&](const Vec3& p) {
                    const double h = (p[model.up] - low) / height;
                    return h >= from && h <= to;
                })[model.up] / height;
    };
    return {drop(0.9, 1), drop(0, 0.5)};
}

}  // namespace

PaperFigure paper_bunny(PaperWork& work) {
    constexpr int width = 400, height = 400, steps = 240;
    const Scene scene = work.load("bunny");
    const auto [feet_young, ears_young] = std::get<GradientSpec>(scene.material.materials.front().young).values;
    const auto kilopascal = [](double young) { return format_number(young / 1e3, "%.3g") + " kPa"; };
    Simulation graded(work.build(scene));
    Simulation soft(work.build(work.load("bunny", {{"/material/young", format_number(ears_young, "%.9g")}})));
    std::vector<Image> panels = {paper_panel(work, graded, width, height, Colouring::stiffness)};
    advance(work, graded, steps, "bending the bunny's ears");
    advance(work, soft, steps, "a soft bunny, for comparison");
    panels.push_back(paper_panel(work, graded, width, height, Colouring::stiffness));
    panels.push_back(paper_panel(work, soft, width, height, Colouring::stiffness));
    const auto [ears, body] = drops(graded);
    const auto [soft_ears, soft_body] = drops(soft);

    PaperFigure f;
    f.title = "Figure 10: a jelly bunny";
    f.setting = "`bunny.json`: the Stanford bunny, E " + kilopascal(feet_young) + " at its feet to " + kilopascal(ears_young) + " at its ears, held at its feet, adaptive quadratic tets; 240 steps of 1/60 s under gravity. Beside it the "
                "same bunny with E " + kilopascal(ears_young) + " throughout.";
    f.pictures = {{work.write_sheet("paper_10.png", panels, 3), "At rest, after 4 s, and the soft bunny after 4 s (the floor is drawn but holds nothing). Colours: stiffness, dark is stiff."}};
    f.statements = {{"The bunny stands alone thanks to its stiff feet.",
                     "Its lower half comes down by " + percent_of(body) + " of the height; that of a bunny as soft as the ears throughout by " + percent_of(soft_body) + ".",
                     verdict(body < 0.05 && body < soft_body / 3) + " (Less than 5 %, and than a third of the soft bunny's.) Ours is held at its soles; the paper does not say how its bunny is."},
                    {"Its ears hang down from the head since they are soft.",
                     "The highest tenth, the ears' tips, comes down by " + percent_of(ears) + " of the height, " + format_number(ears / std::max(body, 1e-9), "%.0f") +
                         " times the lower half.",
                     verdict(ears > 0.1) + " (By more than a tenth of the height.) How far depends on the moduli, which the paper does not give. Soft throughout: " +
                         percent_of(soft_ears) + "."}};
    return f;
}

PaperFigure paper_armadillo(PaperWork& work) {
    constexpr int width = 480, height = 400;
    constexpr std::array moments = {400, 800};
    const Box chest{{-0.1, 0, -1}, {0.1, 0.25, 1}};
    const Scene scene = work.load("armadillo", {{"/time_step", format_number(1.0 / 240, "%.9g")}});
    std::vector<Image> panels(4);
    std::array<std::array<double, 2>, 2> longer{};  // [hand][moment] [m]
    for (std::size_t hand = 0; hand < 2; ++hand) {
        Scene one = scene;
        one.forces = {scene.forces.at(hand)};
        one.forces[0].start = 0;
        one.forces[0].end = std::numeric_limits<double>::infinity();
        const ForceSpec force = one.forces[0];
        Simulation simulation(work.build(std::move(one)));
        for (std::size_t moment = 0; moment < 2; ++moment) {
            advance(work, simulation, moments[moment] - (moment == 0 ? 0 : moments[0]), hand == 0 ? "pulling the soft hand" : "pulling the stiff hand");
            panels[2 * moment + hand] = paper_panel(work, simulation, width, height, Colouring::stiffness);
            // From the chest, which both pulls drag along.
            const Vec3 arm = mean_displacement(simulation, [&](const Vec3& p) { return contains(force.region, p); }) -
                             mean_displacement(simulation, [&](const Vec3& p) { return contains(chest, p); });
            longer[hand][moment] = arm.dot(force.force.normalized());
        }
    }
    PaperFigure f;
    f.title = "Figure 12: an armadillo, pulled by one hand or the other";
    f.setting = "`armadillo.json`: E 3 MPa on one side to 300 kPa on the other, no gravity, feet held; " + format_number(scene.forces.at(0).force.norm()) +
                " N outwards on the soft hand or on the stiff one from the start, steps of 1/240 s.";
    f.pictures = {{work.write_sheet("paper_12.png", panels, 2), "Columns: the force is applied on the soft hand, on the stiff hand. Rows: after 400 and 800 steps. Colours: stiffness, dark is stiff."}};
    f.statements = {{"Since the armadillo's right hand is softer, with the same magnitude of force it gets longer than the left hand.",
                     "After 400 steps the soft arm has got longer by " + centimetres(longer[0][0]) + ", from chest to hand along the force, the stiff one by " +
                         centimetres(longer[1][0]) + "; after 800 steps by " + centimetres(longer[0][1]) + " and " + centimetres(longer[1][1]) + ", " +
                         format_number(longer[0][1] / longer[1][1], "%.1f") + " times as much.",
                     verdict(longer[0][0] > longer[1][0] && longer[0][1] > longer[1][1])},
                    {"Results after 400 and 800 steps differ: the pull is still at work.",
                     "From step 400 to 800 the soft arm goes on by " + centimetres(longer[0][1] - longer[0][0]) + ", the stiff one by " + centimetres(longer[1][1] - longer[1][0]) + ".",
                     verdict(std::abs(longer[0][1] - longer[0][0]) > 0.05 * longer[0][0], "The soft arm changes by less than a twentieth.") +
                         " The paper's time step is not given; ours are 1/240 s and damped by 3/s."}};
    return f;
}

namespace {

/// Leaves of the tree that are stiffer than the geometric mean of the stiffest and the softest.
std::vector<TetId> stiff_leaves(const Model& model) {
    const auto stiffness = [&](TetId t) { return model.matrices.elasticity[t].matrix().trace(); };
    double low = std::numeric_limits<double>::infinity(), high = 0;
    for (const TetId t : model.tree.level(model.tree.depth())) low = std::min(low, stiffness(t)), high = std::max(high, stiffness(t));
    std::vector<TetId> stiff;
    for (const TetId t : model.tree.level(model.tree.depth()))
        if (stiffness(t) > std::sqrt(low * high)) stiff.push_back(t);
    return stiff;
}

struct Strains {
    double volume[2] = {0, 0}, strain[2] = {0, 0};  // [tissue, vessels] [m^3], volume-weighted mean
};

/// Mean equivalent Green strain of the stiff leaves and of the others.
Strains strains(const Model& model, const std::vector<TetId>& stiff, const PerVertex<Vec3>& x) {
    PerTet<char> is_stiff(model.tree.tet_count(), 0);
    for (const TetId t : stiff) is_stiff[t] = 1;
    Strains s;
    for (const TetId t : model.tree.level(model.tree.depth())) {
        const auto& c = model.tree.corners(t);
        Mat3 rest, now;
        for (int i = 0; i < 3; ++i) {
            const auto k = static_cast<std::size_t>(i + 1);
            rest.col(i) = model.tree.rest(c[k]) - model.tree.rest(c[0]);
            now.col(i) = x[c[k]] - x[c[0]];
        }
        const Mat3 f = now * rest.inverse();
        const Mat3 e = (f.transpose() * f - Mat3::Identity()) / 2;
        const Mat3 deviator = e - Mat3::Identity() * e.trace() / 3;
        const double volume = model.tree.volume(t);
        s.volume[is_stiff[t] != 0] += volume;
        s.strain[is_stiff[t] != 0] += volume * std::sqrt(2.0 / 3) * deviator.norm();
    }
    for (int k = 0; k < 2; ++k) s.strain[k] /= std::max(s.volume[k], 1e-300);
    return s;
}

/// The boundary of the labels that have the scene's stiffest material, carried by the tree's leaves.
Surface vessel_surface(const Model& model) {
    const auto& labels = std::get<LabelsSpec>(model.scene.material.zones);
    const auto young = [&](int zone) { return std::get<double>(model.scene.material.materials.at(static_cast<std::size_t>(zone)).young); };
    double stiffest = 0;
    for (const auto& [label, zone] : labels.zone_of_label) stiffest = std::max(stiffest, young(zone));
    std::set<long long> vessels;
    for (const auto& [label, zone] : labels.zone_of_label)
        if (young(zone) == stiffest) vessels.insert(label);
    const VoxelImage image = scaled_image(labels.file, labels.scale);
    return embed(voxel_surface(image, vessels, voxel_extent(image, vessels) / 100), model.tree);
}

/// That surface alone as a frame of its own, with the tree's vertices at x; everything else is taken away.
Frame vessel_frame(const Model& model, const Surface& vessels, const PerVertex<Vec3>& x, const Frame& whole) {
    Frame frame = whole;
    auto parts = std::make_shared<FrameModel>(*whole.model);
    parts->triangles.clear();
    for (const auto& t : vessels.mesh.triangles)
        parts->triangles.push_back({static_cast<std::uint32_t>(t[0]), static_cast<std::uint32_t>(t[1]), static_cast<std::uint32_t>(t[2])});
    parts->young.assign(vessels.mesh.positions.size(), parts->young_range[1]);
    frame.model = parts;
    auto topology = std::make_shared<FrameTopology>(*whole.topology);
    topology->surface_level.assign(vessels.mesh.positions.size(), 0);
    frame.topology = topology;
    frame.surface.clear();
    for (const Attachment& a : vessels.attachment) {
        Vec3 p = Vec3::Zero();
        for (std::size_t i = 0; i < 4; ++i) p += a.barycentric[static_cast<int>(i)] * x[model.tree.corners(a.leaf)[i]];
        frame.surface.push_back({static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])});
    }
    frame.field = Field::none;
    frame.field_values.clear();
    return frame;
}

}  // namespace

PaperFigure paper_liver(PaperWork& work) {
    constexpr int width = 400, height = 400, steps = 240;
    const auto model = work.build(work.load("liver"));
    Simulation simulation(model);
    const std::vector<TetId> stiff = stiff_leaves(*model);
    const Surface vessels = vessel_surface(*model);
    std::vector<Image> panels;
    const auto show = [&] {
        const auto frame = simulation.frame();
        panels.push_back(paper_panel(work, *model, *frame, width, height, Colouring::stiffness));
        panels.push_back(paper_panel(work, *model, vessel_frame(*model, vessels, simulation.all_positions(), *frame), width, height, Colouring::stiffness));
    };
    show();
    advance(work, simulation, steps, "hanging the liver");
    show();
    const Strains s = strains(*model, stiff, simulation.all_positions());
    const auto [top, body] = drops(simulation);

    PaperFigure f;
    f.title = "Figure 13: a liver with vessels";
    f.setting = "`liver.json`: a segmented image, vessels twenty times stiffer than the tissue (160 and 8 kPa), held at its highest part; 240 steps of 1/60 s under gravity.";
    f.pictures = {{work.write_sheet("paper_13.png", panels, 2), "The liver, and the vessels alone; at rest and after 4 s. Colours: stiffness, dark is stiff."}};
    f.statements = {{"The liver deforms under gravity.", "Its lower half comes down by " + percent_of(body) + " of its height.", verdict(body > 0.02) + " (By more than 2 %.) Where it is held, and moduli, are ours."},
                    {"The vessels are stiffer than the other tissue.",
                     "Mean equivalent strain after 4 s: " + percent_of(s.strain[1]) + " in vessels, " + percent_of(s.strain[0]) + " in tissue. Vessels are " +
                         percent_of(s.volume[1] / (s.volume[0] + s.volume[1])) + " of the volume, from " + std::to_string(stiff.size()) + " of " +
                         std::to_string(model->tree.tet_count(model->tree.depth())) + " finest tets.",
                     verdict(s.strain[1] < s.strain[0]) + " The paper says nothing of strains; less of it in the vessels is what stiffer means."}};
    return f;
}

}  // namespace tetfront
