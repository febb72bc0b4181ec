// Writes tests/reports/verification.md: the simulation against theory and published numbers.
#include "tests/support/modes.hpp"
#include "tests/support/project.hpp"
#include "tests/support/report.hpp"
#include "tests/support/verification.hpp"

#include "engine/base/atomic_file.hpp"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <optional>
#include <sstream>

namespace tetfront::testing {
namespace {

class Table {
 public:
    explicit Table(std::ostream& out) : out_(out) {
        out_ << "\n| problem | mesh | reference | ours | deviation | rate | bound | |\n|---|---|---|---|---|---|---|---|\n";
    }
    /// bound: of the relative deviation; none: a coarser mesh, for the rate.
    void row(const std::string& problem, const std::string& mesh, double reference, double ours, std::optional<double> bound,
             std::optional<double> rate = {}) {
        const double deviation = ours / reference - 1;
        out_ << "| " << problem << " | " << mesh << " | " << number(reference, "%.6g") << " | " << number(ours, "%.6g") << " | "
             << number(100 * deviation, "%+.3f") << " % | " << (rate ? number(*rate, "%.2f") : "") << " | "
             << (bound ? number(100 * *bound) + " %" : "") << " | " << (bound ? verdict(std::abs(deviation) <= *bound) : "") << " |\n";
        out_.flush();
    }
    /// For what should be zero. bound: none: measured only.
    void zero(const std::string& problem, const std::string& mesh, double ours, std::optional<double> bound) {
        out_ << "| " << problem << " | " << mesh << " | 0 | " << number(ours) << " | | | " << (bound ? number(*bound) : "") << " | "
             << (bound ? verdict(std::abs(ours) <= *bound) : "") << " |\n";
        out_.flush();
    }
    /// No answer at all.
    void failed(const std::string& problem, const std::string& mesh) {
        out_ << "| " << problem << " | " << mesh << " | | | | | | " << verdict(false) << " |\n";
    }
    [[nodiscard]] int missed() const { return missed_; }

 private:
    std::string verdict(bool passed) {
        missed_ += !passed;
        return passed ? "passed" : "missed";
    }
    std::ostream& out_;
    int missed_ = 0;
};

std::string tets(int order, std::size_t count) { return std::to_string(count) + (order == 1 ? " linear" : " quadratic"); }

void cantilever(Table& table) {
    const double theory = timoshenko_tip_of_end_load(verification_beam, 1);
    for (const int order : {1, 2}) {
        std::vector<double> tips;
        const int levels = order == 1 ? 4 : 3;
        for (int level = 0; level < levels; ++level) {
            tips.push_back(cantilever_tip(order, level));
            const std::size_t n = tips.size();
            const bool last = level + 1 == levels;
            table.row("cantilever 8x1x1, nu 0, force at the end: tip [m], Timoshenko", tets(order, std::size_t{48} << (3 * level)), theory,
                      tips.back(), last ? std::optional(order == 1 ? 0.03 : 0.003) : std::nullopt,
                      n > 2 ? std::optional(convergence_rate(tips[n - 3], tips[n - 2], tips[n - 1])) : std::nullopt);
        }
    }
}

void twisted_beam(Table& table) {
    using B = TwistedBeam;
    for (const int order : {1, 2}) {
        const int finest = order == 1 ? 4 : 3;
        for (int n = 1; n <= finest; ++n) {
            const auto tip = twisted_beam_tip(order, n);
            const std::string mesh = tets(order, static_cast<std::size_t>(6 * 12 * 2 * n * n * n));
            const auto bound = order == 2 && n == finest ? std::optional(0.01) : std::nullopt;
            table.row("twisted beam, force along the width: tip [m], MacNeal & Harder 1985", mesh, B::in_plane, tip[0], bound);
            table.row("twisted beam, force along the thickness", mesh, B::out_of_plane, tip[1], bound);
        }
    }
}

void elastica(Table& table) {
    const std::vector<double> loads = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10};
    for (const int cells : {25, 50}) {
        std::vector<double> tips;
        try {
            tips = elastica_tips(loads, cells, 0);
        } catch (const LogicError& error) {
            table.failed("elastica, Bisshopp & Drucker 1945: " + std::string(error.what()), tets(2, static_cast<std::size_t>(6 * cells)));
            continue;
        }
        for (std::size_t i = 0; i < loads.size(); ++i)
            table.row("elastica, P L^2 / (E I) = " + number(loads[i]) + ": tip over length, Bisshopp & Drucker 1945",
                      tets(2, static_cast<std::size_t>(6 * cells)), elastica_deflection(loads[i]), tips[i],
                      cells == 50 ? std::optional(0.005) : std::nullopt);
    }
}

void frequencies(Table& table) {
    const SquareBeam b{10, 1, 1e6};
    const double density = 1000;
    const auto theory = free_beam_frequencies(b, density, 2);
    // Saint-Venant torsion of a square: J = 0.140577 a^4.
    const double torsion = std::sqrt(b.young / 2 * 0.140577 / (density / 6)) / (2 * b.length);
    std::vector<std::array<double, 3>> found;
    for (int level = 0; level < 2; ++level) {
        const TetTree tree(box_mesh({0, 0, 0}, {b.length, b.side, b.side}, {10, 1, 1}), level + 1);
        for (const Mass mass : {Mass::consistent, Mass::children}) {
            const auto f = natural_frequencies(tree, level, mass, false, 5, b.young, 0, density);
            const std::string mesh = tets(2, std::size_t{60} << (3 * level)) + (mass == Mass::children ? ", lumped as in explicit steps" : "");
            const auto bound = level == 1 ? std::optional(0.01) : std::nullopt;
            table.row("free beam 10x1x1, nu 0: first bending frequency [Hz], Timoshenko", mesh, theory[0], f[0], bound);
            table.row("free beam: second bending frequency [Hz]", mesh, theory[1], f[2], bound);
            table.row("free beam: first torsional frequency [Hz], Saint-Venant", mesh, torsion, f[4], bound);
        }
    }
}

void motion(Table& table) {
    for (const int order : {1, 2}) {
        const Rotated worst = rotated_box(order);
        table.zero("box turned by any angle: largest nodal force over E L^2", order == 1 ? "linear" : "quadratic", worst.force, 1e-12);
    }
    for (const std::string scheme : {"backward_euler", "midpoint", "bdf2", "explicit"}) {
        const bool conserves = scheme == "midpoint";
        const bool symplectic = scheme == "explicit";  // of first order: its energy sways, and does not drift
        table.zero("free fall for 1 s, g 10: error [m], " + scheme, "96 quadratic", free_fall_error(scheme), conserves ? std::optional(1e-6) : std::nullopt);
        const Spin spin = spinning_box(scheme, 180);
        table.zero("spinning free box, 1 turn: angular momentum lost, " + scheme, "96 quadratic", spin.angular_momentum,
                   conserves ? std::optional(1e-6) : std::nullopt);
        for (const int rate : {60, 240}) {
            const auto energy = swinging_energy(scheme, 1.0 / rate, 10 * rate);
            double worst = 0;
            for (const double e : energy) worst = std::max(worst, std::abs(e - 1));
            const std::string at = ", 1/" + std::to_string(rate) + " s, " + scheme;
            table.zero("clamped beam swings undamped for 10 s: energy at the end over the start, less 1" + at, "96 quadratic", energy.back() - 1,
                       conserves || symplectic ? std::optional(0.01) : std::nullopt);
            table.zero("the same, largest deviation" + at, "96 quadratic", worst, conserves ? std::optional(0.02) : symplectic ? std::optional(0.05) : std::nullopt);
        }
    }
}

int run() {
    std::ostringstream out;
    write_head(out, "Verification: against theory and published numbers", "build/release/tests/verification_report");
    out << "\nDeviation: ours over the reference, less one. Rate: exponent of the mesh width, from three successive meshes. Rows without a bound are the "
           "coarser meshes of a series, or measured only (integrators that are meant to damp). Beams have nu 0, where beam theory holds best; "
           "tets are six per cell.\n\n"
           "Linear statics and frequencies are solved by a sparse factorisation of textbook element matrices (tests/support/static_level.hpp, modes.hpp); the "
           "elastica by Newton's method on the simulation's own elements (tests/support/equilibrium.hpp); motion by the simulation itself.\n";
    Table table(out);
    for (const auto& part : {cantilever, twisted_beam, elastica, frequencies, motion}) {
        part(table);
        std::cerr << '.' << std::flush;
    }
    std::cerr << '\n';
    out << "\n" << (table.missed() == 0 ? "All bounds hold." : std::to_string(table.missed()) + " bounds are missed.") << "\n";
    write_atomically(source_folder() / "tests/reports/verification.md", out.str());
    std::cout << out.str();
    return 0;
}

}  // namespace
}  // namespace tetfront::testing

int main() { return tetfront::testing::run(); }
