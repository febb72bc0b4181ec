// `tetfront paper`: every figure of [Imai] that shows a result, made again, and a page that sets what the paper says
// beside what came out.
#include "server/cli/commands.hpp"
#include "server/cli/paper_figures.hpp"
#include "server/cli/report_head.hpp"

#include "engine/base/error.hpp"
#include "server/render/colour_scale.hpp"
#include "server/render/png.hpp"
#include "server/render/sheet.hpp"
#include "server/session/stage.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <functional>
#include <iterator>
#include <set>
#include <sstream>

#include <spdlog/spdlog.h>

namespace tetfront {

Scene PaperWork::load(const std::string& name, const std::vector<Override>& overrides) const {
    return load_scene(settings_.scenes / (name + ".json"), overrides);
}

std::shared_ptr<const Model> PaperWork::build(Scene scene) {
    return build_model(std::move(scene), [this](const std::string& what, double fraction) { bar_.show(what, fraction); }, settings_.cache);
}

std::string PaperWork::write(const std::string& name, const std::string& bytes) const {
    write_atomically(settings_.out / name, bytes);
    return name;
}

std::string PaperWork::write_sheet(const std::string& name, const std::vector<Image>& images, int columns) const {
    return write(name, encode_png(contact_sheet(images, columns), {.level = 9, .text = {{"Software", "tetfront paper"}}}));
}

Renderer& PaperWork::renderer() {
    if (!renderer_) renderer_ = std::make_unique<Renderer>();
    return *renderer_;
}

Image paper_panel(PaperWork& work, const Model& model, const Frame& frame, int width, int height, Colouring colouring, bool wireframe) {
    View view = make_view(model.scene.view, *model.frame_model, width, height);
    view.colouring = colouring;
    view.wireframe = wireframe;
    view.legend = false;
    view.supersampling = 3;
    view.floor = floor_height(model);
    return work.renderer().render(frame, view, "");
}

Image paper_panel(PaperWork& work, Simulation& simulation, int width, int height, Colouring colouring, bool wireframe) {
    return paper_panel(work, simulation.model(), *simulation.frame(0, field_of(colouring)), width, height, colouring, wireframe);
}

std::string verdict(bool holds, const std::string& otherwise) {
    return holds ? "Holds." : "Does not hold here." + (otherwise.empty() ? "" : " " + otherwise);
}

namespace {

constexpr std::array all_figures = {3, 6, 7, 8, 10, 12, 13};

struct PaperOptions {
    std::vector<int> figures{all_figures.begin(), all_figures.end()};
    std::string out = "paper", scenes = TETFRONT_SCENES_DIR;
    std::string cache_directory = default_cache_directory().string();
};

/// Before the long work: a model that has to be fetched is there.
void check_models(const PaperWork& work, const std::vector<int>& figures) {
    const std::vector<std::pair<int, std::string>> scenes = {{6, "box"}, {7, "box"}, {8, "box"}, {10, "bunny"}, {12, "armadillo"}, {13, "liver"}};
    for (const auto& [figure, name] : scenes) {
        if (std::ranges::find(figures, figure) == figures.end()) continue;
        const Scene scene = work.load(name);
        const auto check = [&](const std::filesystem::path& file) {
            if (!std::filesystem::exists(file))
                throw InputError(file.string(), "", "is missing, and figure " + std::to_string(figure) + " shows it",
                                 "run `assets/fetch " + name + "` (the bunny: `server/setup`), or leave the figure out with --figures");
        };
        if (const auto* surface = std::get_if<SurfaceMeshSpec>(&scene.mesh)) std::ranges::for_each(surface->files, check);
        if (const auto* voxels = std::get_if<VoxelMeshSpec>(&scene.mesh)) check(voxels->file);
    }
}

void write_figure(std::ostream& page, const PaperFigure& figure) {
    page << "\n## " << figure.title << "\n\n" << figure.setting << "\n";
    for (const PaperFigure::Picture& picture : figure.pictures)
        page << "\n![" << picture.caption << "](" << picture.file << ")\n\n" << picture.caption << "\n";
    page << "\n| the paper says | here | what differs, and why |\n|---|---|---|\n";
    for (const Statement& s : figure.statements) page << "| " << s.paper << " | " << s.ours << " | " << s.difference << " |\n";
    if (!figure.tables.empty()) {
        page << "\nNumbers:";
        for (const std::string& table : figure.tables) page << " [" << table << "](" << table << ")";
        page << "\n";
    }
}

int paper(const PaperOptions& options) {
    std::vector<int> figures = options.figures;
    std::ranges::sort(figures);
    figures.erase(std::unique(figures.begin(), figures.end()), figures.end());
    PaperWork work({.scenes = options.scenes, .out = options.out,
                    .cache = {.directory = options.cache_directory, .warn = [](const std::string& line) { spdlog::warn("{}", line); }}});
    check_models(work, figures);
    prepare_directory(options.out);

    const auto wants = [&](int figure) { return std::ranges::find(figures, figure) != figures.end(); };
    std::vector<PaperFigure> done;
    const auto make = [&](bool wanted, const std::function<std::vector<PaperFigure>()>& figure) {
        if (!wanted) return;
        const auto start = std::chrono::steady_clock::now();
        for (PaperFigure& f : figure()) done.push_back(std::move(f));
        done.back().seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    };
    make(wants(3), [&] { return std::vector{paper_matrix(work)}; });
    make(wants(6) || wants(7) || wants(8), [&] {
        std::vector<int> box;
        std::ranges::copy_if(figures, std::back_inserter(box), [](int f) { return f >= 6 && f <= 8; });
        return paper_box(work, box);
    });
    make(wants(10), [&] { return std::vector{paper_bunny(work)}; });
    make(wants(12), [&] { return std::vector{paper_armadillo(work)}; });
    make(wants(13), [&] { return std::vector{paper_liver(work)}; });

    std::string list;
    for (const int f : figures) list += (list.empty() ? "" : ",") + std::to_string(f);
    std::ostringstream page;
    write_head(page, "The paper's figures, made again", "tetfront paper" + (figures.size() < all_figures.size() ? " --figures " + list : "") + " --out " + options.out);
    double seconds = 0;
    for (const PaperFigure& f : done) seconds += f.seconds;
    page << "\n[Imai] is Imai, Yue, Chen, Nishita 2013, \"Adaptively Simulating Inhomogeneous Elastic Deformation\". The paper gives no sizes, moduli, "
            "time steps or tet counts of its scenes, so ours are our own; what can be compared is what it states about them. All of it took "
         << format_number(seconds, "%.0f") << " s.\n";
    for (const PaperFigure& f : done) write_figure(page, f);
    work.write("paper.md", page.str());
    std::printf("wrote %s\n", (std::filesystem::path(options.out) / "paper.md").c_str());
    return exit_ok;
}

}  // namespace

void add_paper(CLI::App& program, Action& action) {
    CLI::App* command = program.add_subcommand("paper", "Makes the figures of Imai et al. 2013 again, with a page that compares");
    const auto options = std::make_shared<PaperOptions>();
    command->add_option("--figures", options->figures, "Which, of those that show a result; the page has only these")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->check(CLI::IsMember(std::set<int>(all_figures.begin(), all_figures.end())))
        ->capture_default_str();
    command->add_option("--out", options->out, "Folder for paper.md, pictures, charts and tables")->type_name("DIR")->capture_default_str();
    command->add_option("--scenes", options->scenes, "Where box.json, bunny.json, armadillo.json and liver.json are")
        ->type_name("DIR")
        ->capture_default_str();
    command->add_option("--cache", options->cache_directory, "Keeps elasticity matrices here for the next start")->type_name("DIR")->capture_default_str();
    command->callback([options, &action] { action = [options] { return paper(*options); }; });
}

}  // namespace tetfront
