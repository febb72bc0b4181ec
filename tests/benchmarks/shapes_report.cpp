// Ugly and fine surfaces and the fetched models: what loads, how well it is meshed, and whether it can be moved; writes
// tests/reports/shapes.md. Each shape has a process of its own, so that its memory can be told, and a crash or a hang is a
// row of the table.
//
//     build/release/tests/shapes_report [STEPS [NAME...]]        300 steps, all shapes; with names it only prints

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <sstream>
#include <vector>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "engine/base/atomic_file.hpp"
#include "engine/material/voxel_image.hpp"
#include "engine/material/voxel_surface.hpp"
#include "tests/support/project.hpp"
#include "tests/support/report.hpp"
#include "tests/support/ugly_shapes.hpp"

using namespace tetfront;
using namespace tetfront::testing;
using Json = nlohmann::json;

namespace {

constexpr unsigned most_seconds = 600;  // a shape that takes longer hangs

struct Row {
    std::string name, ugliness;
    bool refusable = false;
    std::string died;  // how the process ended, when not well
    Json trial;
    double mebibytes = 0;  // peak of the process
};

Json to_json(const ShapeTrial& t) {
    return {{"refused", t.refused}, {"mended", t.mended}, {"triangles", t.triangles}, {"tets", t.tets}, {"volume_error", t.volume_error},
            {"outside", t.outside}, {"thickened", t.thickened}, {"angles", t.angles}, {"load", t.load_seconds}, {"run", t.run_seconds},
            {"tets_mean", t.tets_mean}, {"troubled", t.troubled}, {"inverted", t.inverted}, {"finite", t.finite}, {"moved", t.moved}};
}

/// In a process of its own. The parent must not have started threads.
Row run(const std::string& name, const std::string& ugliness, const std::filesystem::path& file, const TrialOptions& options, double volume) {
    Row row{.name = name, .ugliness = ugliness, .refusable = false, .died = "", .trial = {}, .mebibytes = 0};
    const std::filesystem::path result = file.parent_path() / "result.json";
    std::filesystem::remove(result);
    const pid_t child = fork();
    if (child < 0) throw std::runtime_error("cannot fork");
    if (child == 0) {
        alarm(most_seconds);
        try {
            std::ofstream(result) << to_json(try_shape(file, options, volume)).dump(-1, ' ', false, Json::error_handler_t::replace);
            _exit(0);
        } catch (const std::exception& error) {
            std::cerr << name << ": " << error.what() << "\n";
            _exit(1);
        }
    }
    int status = 0;
    rusage usage{};
    if (wait4(child, &status, 0, &usage) != child) throw std::runtime_error("lost a process");
    row.mebibytes = static_cast<double>(usage.ru_maxrss) / 1024;
    if (WIFSIGNALED(status)) row.died = WTERMSIG(status) == SIGALRM ? "no end after " + std::to_string(most_seconds) + " s" : "signal " + std::to_string(WTERMSIG(status));
    if (WIFEXITED(status) && WEXITSTATUS(status) != 0) row.died = "internal error";
    if (row.died.empty()) row.trial = Json::parse(std::ifstream(result));
    return row;
}

std::string one_cell(std::string text) {
    while (text.ends_with('\n')) text.pop_back();
    for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos;) text.replace(at, 1, ", ");
    std::ranges::replace(text, '|', '/');
    return text;
}

void write(std::ostream& out, const std::vector<Row>& rows, int steps) {
    int loaded = 0, refused = 0, bad = 0;
    for (const Row& r : rows) {
        if (!r.died.empty() || (!r.trial["refused"].get<std::string>().empty() && !r.refusable)) ++bad;
        else if (!r.trial["refused"].get<std::string>().empty()) ++refused;
        else loaded += 1, bad += !r.trial["finite"].get<bool>();
    }
    out << "\n" << rows.size() << " shapes: " << loaded << " loaded and ran " << steps << " steps, " << refused << " that are no surface were refused, " << bad
        << " failed.\n\n"
           "Each is read from an OFF file, meshed with about 400 root tets (bunny, armadillo, liver: 1,500) and one level, held by its lowest twentieth, sags under gravity for half of the steps, and is then "
           "pulled at its highest point by half of its size. Volume: of the tets against the volume that a person sees, or else against what the surface encloses "
           "(\"-\": that is next to nothing); tets cover a surface, so they hold a little more. Outside: largest distance of a surface vertex to the tets, over the size. Thickened: "
           "part of the surface that is thinner than tets of this size can be. Trouble: steps that did not converge or were rejected / that left an inverted tet. Moved: farthest, over the size (parts that nothing holds fall, and what stands on a small foot topples over). Memory: peak of the process.\n\n"
           "| shape | what is ugly | mended, or left as it was | tets | volume | outside | thickened | angles | load [s] | ms a step | trouble | moved | NaN | memory [MiB] |\n"
           "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
    for (const Row& r : rows) {
        out << "| " << r.name << " | " << r.ugliness << " | ";
        if (!r.died.empty()) {
            out << "FAILED: " << r.died << " |\n";
            continue;
        }
        const Json& t = r.trial;
        if (const auto why = t["refused"].get<std::string>(); !why.empty()) {
            out << (r.refusable ? "refused: " : "FAILED, refused: ") << one_cell(why.substr(why.find(": ") + 2)) << " | | | | | | | | | | | " << number(r.mebibytes, "%.0f") << " |\n";
            continue;
        }
        // A sheet's volume would be a percentage of nothing.
        const bool volume = t["volume_error"].is_number() && t["volume_error"].get<double>() < 3;
        out << one_cell(t["mended"].get<std::string>()) << " | " << t["tets"] << " | " << (volume ? number(100 * t["volume_error"].get<double>(), "%+.1f") + " %" : "-") << " | "
            << number(100 * t["outside"].get<double>(), "%.1f") << " % | " << number(100 * t["thickened"].get<double>(), "%.0f") << " % | "
            << number(t["angles"][0].get<double>(), "%.0f") << " to " << number(t["angles"][1].get<double>(), "%.0f") << " | " << number(t["load"].get<double>(), "%.2f") << " | "
            << number(1e3 * t["run"].get<double>() / steps, "%.1f") << " | " << t["troubled"] << " / " << t["inverted"] << " | " << number(100 * t["moved"].get<double>(), "%.0f") << " % | "
            << (t["finite"].get<bool>() ? "none" : "FOUND") << " | " << number(r.mebibytes, "%.0f") << " |\n";
    }
}

}  // namespace

int main(int argc, char** argv) {
    try {
        TrialOptions options;
        if (argc > 1) options.steps = std::max(2, std::atoi(argv[1]));
        const std::vector<std::string> names(argv + std::min(argc, 2), argv + argc);
        const auto wanted = [&](const std::string& name) { return names.empty() || std::ranges::find(names, name) != names.end(); };
        std::string folder = (std::filesystem::temp_directory_path() / "tetfront_shapes.XXXXXX").string();
        if (!mkdtemp(folder.data())) throw std::runtime_error(folder + ": cannot be made");
        std::vector<Row> rows;
        std::vector<UglyShape> shapes = ugly_shapes();
        shapes.push_back({"fine", "500,000 vertices", test_surfaces::torus(0.5, 0.2, 1000, 500), 2 * std::numbers::pi * std::numbers::pi * 0.5 * 0.04});
        for (const UglyShape& shape : shapes) {
            if (!wanted(shape.name)) continue;
            std::cerr << shape.name << "\n";
            const auto file = std::filesystem::path(folder) / (shape.name + ".off");
            write_off(file, shape.surface);
            rows.push_back(run(shape.name, shape.ugliness, file, options, shape.volume));
            rows.back().refusable = shape.refusable;
        }
        TrialOptions finer = options;  // real shapes have fingers and vessels
        finer.target_tets = 1500;
        std::string missing;
        const std::vector<std::array<std::string, 3>> models = {{"bunny", "bunny.obj", "a real scan"}, {"armadillo", "armadillo.off", "a real scan with fingers and ears"}};
        for (const auto& [name, model, what] : models) {
            if (!wanted(name)) continue;
            const auto source = source_folder() / "assets/models" / model;
            if (!std::filesystem::exists(source)) {
                missing += name + " ";
                continue;
            }
            std::cerr << name << "\n";
            const auto file = std::filesystem::path(folder) / model;
            std::filesystem::copy_file(source, file);
            rows.push_back(run(name, what, file, finer, 0));
        }
        if (const auto image = source_folder() / "assets/models/liver.inr.gz"; wanted("liver") && std::filesystem::exists(image)) {
            // The smoothed boundary of its labels, as a scene's `voxels` would have it.
            std::cerr << "liver\n";
            const auto file = std::filesystem::path(folder) / "liver.off";
            const pid_t child = fork();  // it starts threads
            if (child == 0) {
                const VoxelImage voxels = read_voxel_image(image);
                write_off(file, scaled(voxel_surface(voxels, {}, voxel_extent(voxels, {}) / 100), 1e-3));
                _exit(0);
            }
            int status = 0;
            waitpid(child, &status, 0);
            rows.push_back(run("liver", "boundary of the labels of an image", file, finer, 0));
        } else if (wanted("liver")) {
            missing += "liver ";
        }
        std::filesystem::remove_all(folder);
        if (names.empty()) {
            std::ostringstream page;
            write_head(page, "Ugly shapes", "build/release/tests/shapes_report" + (argc > 1 ? " " + std::to_string(options.steps) : ""));
            write(page, rows, options.steps);
            if (!missing.empty()) page << "\nNot fetched: " << missing << "\n";
            write_atomically(source_folder() / "tests/reports/shapes.md", page.str());
        }
        write(std::cout, rows, options.steps);
        return 0;
    } catch (const std::exception& error) {
        std::cerr << "shapes_report: " << error.what() << "\n";
        return 1;
    }
}
