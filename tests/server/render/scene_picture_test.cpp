// Pictures of a scene that comes with the program, simulated: what is inside of it, coloured on the cut, and its forces.
// The golden files are in tests/golden/scene_*.png; TETFRONT_UPDATE_GOLDEN=1 writes them anew.

#include "server/render/renderer.hpp"
#include "server/session/stage.hpp"
#include "tests/support/pictures.hpp"
#include "tests/support/project.hpp"

#include <gtest/gtest.h>

namespace tetfront {
namespace {

/// Solved to nearly all digits, so that a picture does not depend on how.
Scene scene(const std::string& name) {
    return load_scene(source_folder() / "assets" / "scenes" / (name + ".json"), {{"/levels", "1"}, {"/solver/cg_tolerance", "1e-10"}});
}

TEST(ScenePicture, ACutIsColouredByWhatIsInside) {
    const auto model = build_model(scene("skeleton"));
    Simulation simulation(model);
    for (int i = 0; i < 24; ++i) simulation.step();
    View view = make_view(model->scene.view, *model->frame_model, 480, 270);
    view.floor = floor_height(*model);
    view.eye = {1.7, -3.4, 0.2}, view.target = {0.75, 0, -0.42};
    view.cut = CutPlane{{0, 0, 0}, {0, -1, 0}};
    Renderer renderer;
    const auto show = [&](Colouring colouring, Field field) {
        view.colouring = colouring;
        return renderer.render(*simulation.frame(0, field), view, "Skeleton");
    };
    const Image stiffness = show(Colouring::stiffness, Field::none), stress = show(Colouring::stress, Field::stress);
    expect_golden_picture("scene_cut_stiffness.png", stiffness);
    expect_golden_picture("scene_cut_stress.png", stress);
    EXPECT_GT(share_different(stiffness, stress, 40), 0.05);
}

TEST(ScenePicture, ForcesHaveArrows) {
    const auto model = build_model(scene("fibres"));
    Simulation simulation(model);
    for (int i = 0; i < 45; ++i) simulation.step();  // it pulls from 0.5 s on
    View view = make_view(model->scene.view, *model->frame_model, 480, 270);
    view.eye = {2.3, -1.25, 0.7}, view.target = {0.95, 0, -0.05};
    Renderer renderer;
    const Image with = renderer.render(*simulation.frame(), view, "Fibres");
    expect_golden_picture("scene_forces.png", with);
    view.arrows = false;
    EXPECT_GT(share_different(with, renderer.render(*simulation.frame(), view, "Fibres"), 40), 0.0012) << "more than a golden picture tolerates";
}

}  // namespace
}  // namespace tetfront
