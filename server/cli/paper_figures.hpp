#pragma once
// The figures of [Imai] that show a result, made again: what `tetfront paper` writes. Each function runs what its figure
// needs, writes pictures, charts and tables into the folder, and returns what the page says about it.
//
//     PaperWork work({.scenes = "assets/scenes", .out = "tests/reports"});
//     PaperFigure bunny = paper_bunny(work);        // bunny.pictures, bunny.statements

#include "engine/mechanics/elasticity_cache.hpp"
#include "engine/simulation/simulation.hpp"
#include "server/cli/chart.hpp"
#include "server/cli/progress_bar.hpp"
#include "server/render/image.hpp"
#include "server/render/renderer.hpp"

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace tetfront {

/// One statement of the paper beside what came out here, and what that says of the statement: worked out from the numbers,
/// never written before them. All three are text of a Markdown table's cell.
struct Statement {
    std::string paper, ours, difference;
};
/// "Holds." or "Does not hold here.", and what follows when it does not.
std::string verdict(bool holds, const std::string& otherwise = "");

struct PaperFigure {
    std::string title;  // "Figure 10: ..."
    std::string setting;  // one paragraph: what was run
    struct Picture {
        std::string file, caption;  // name in the folder
    };
    std::vector<Picture> pictures;
    std::vector<std::string> tables;  // names of CSV files in the folder
    std::vector<Statement> statements;
    double seconds = 0;  // wall clock of the whole figure
};

/// Where figures take scenes from and put files.
class PaperWork {
 public:
    struct Settings {
        std::filesystem::path scenes, out;
        CacheSettings cache;
    };
    explicit PaperWork(Settings settings) : settings_(std::move(settings)) {}

    /// name: "bunny". overrides: as in load_scene.
    [[nodiscard]] Scene load(const std::string& name, const std::vector<Override>& overrides = {}) const;
    [[nodiscard]] std::shared_ptr<const Model> build(Scene scene);
    /// Writes NAME and returns it. Throws OutputError.
    std::string write(const std::string& name, const std::string& bytes) const;
    std::string write_sheet(const std::string& name, const std::vector<Image>& images, int columns) const;
    void show(const std::string& what, double fraction) { bar_.show(what, fraction); }
    [[nodiscard]] Renderer& renderer();

 private:
    Settings settings_;
    ProgressBar bar_{""};
    std::unique_ptr<Renderer> renderer_;
};

/// The scene's view of the simulation's present moment, without legend, on the floor that it stands on.
/// colouring: in place of the scene's.
Image paper_panel(PaperWork& work, Simulation& simulation, int width, int height, Colouring colouring, bool wireframe = false);
/// The same of any frame of the model.
Image paper_panel(PaperWork& work, const Model& model, const Frame& frame, int width, int height, Colouring colouring, bool wireframe = false);

PaperFigure paper_matrix(PaperWork& work);  // figure 3
/// Figures 6, 7 and 8, which share one run; those of `wanted`, in this order.
std::vector<PaperFigure> paper_box(PaperWork& work, const std::vector<int>& wanted);
PaperFigure paper_bunny(PaperWork& work);      // 10
PaperFigure paper_armadillo(PaperWork& work);  // 12
PaperFigure paper_liver(PaperWork& work);      // 13

}  // namespace tetfront
