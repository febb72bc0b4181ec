// All scenes on one picture, as the README shows them; writes assets/pictures/scenes.png.
//
//     build/release/tests/render_contact_sheet [FILE]

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <vector>

#include "engine/base/atomic_file.hpp"
#include "engine/simulation/simulation.hpp"
#include "server/render/colour_scale.hpp"
#include "server/render/png.hpp"
#include "server/render/renderer.hpp"
#include "server/render/sheet.hpp"
#include "server/session/stage.hpp"
#include "tests/support/project.hpp"

using namespace tetfront;

namespace {

constexpr int width = 640, height = 360;
constexpr double moment = 0.8;  // [s] of the picture

Image picture(Renderer& renderer, const std::filesystem::path& file) {
    const auto model = build_model(load_scene(file));
    Simulation simulation(model);
    for (long i = std::lround(moment / model->scene.time_step); i > 0; --i) simulation.step();
    View view = make_view(model->scene.view, *model->frame_model, width, height);
    view.floor = floor_height(*model);
    view.supersampling = 4;
    const auto frame = simulation.frame(0, field_of(view.colouring));
    // Titles are sentences; here there is room for the scene's name.
    return renderer.render(*frame, at_time(view, moment), model->scene.name);
}

}  // namespace

int main(int argc, char** argv) {
    try {
        const std::filesystem::path assets = source_folder() / "assets";
        const std::filesystem::path file = argc > 1 ? argv[1] : assets / "pictures" / "scenes.png";
        std::vector<std::filesystem::path> scenes;
        for (const auto& entry : std::filesystem::directory_iterator(assets / "scenes"))
            if (entry.path().extension() == ".json") scenes.push_back(entry.path());
        std::ranges::sort(scenes);
        std::vector<Image> pictures;
        Renderer renderer;
        for (const std::filesystem::path& scene : scenes) {
            std::cerr << scene.filename().string() << "\n";
            pictures.push_back(picture(renderer, scene));
        }
        const Image sheet = contact_sheet(pictures, scenes.size() <= 4 ? 2 : 3);
        write_atomically(file, encode_png(sheet, {.level = 9, .text = {{"Software", "tetfront"}}}));
        std::cout << file.string() << "\n";
        return 0;
    } catch (const std::exception& error) {
        std::cerr << error.what() << "\n";
        return 1;
    }
}
