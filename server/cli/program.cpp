#include "server/cli/program.hpp"

#include "engine/base/error.hpp"
#include "server/cli/commands.hpp"
#include "server/net/server.hpp"

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <memory>

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

namespace tetfront {

namespace {

constexpr const char* exit_statuses =
    "Exit status: 0 success, 1 internal error, 2 bad input or usage, 3 the port is taken, 4 output cannot be written.";

int fail(int status, const std::string& message) {
    std::cerr << "tetfront: " << message << std::endl;
    return status;
}

int run_checked(int argc, const char* const* argv) {
    // stdout belongs to results; everything else goes to stderr.
    spdlog::set_default_logger(spdlog::stderr_color_mt("tetfront"));
    spdlog::set_pattern("%H:%M:%S %^%l%$ %v");

    CLI::App program(
        "Elastic deformation with an adaptive front of tetrahedra: live in a browser, as pictures, as numbers.",
        "tetfront");
    program.footer(exit_statuses);
    program.set_version_flag("--version", std::string("tetfront ") + TETFRONT_VERSION);
    program.require_subcommand(1);
    Action action;
    add_serve(program, action);
    add_render(program, action);
    add_record(program, action);
    add_run(program, action);
    add_study(program, action);
    add_info(program, action);
    add_import(program, action);
    add_paper(program, action);
    add_bench(program, action);
    for (CLI::App* command : program.get_subcommands({})) command->footer(exit_statuses);
    // CLI11 would only say that a command is missing.
    const auto is_named = [&](const CLI::App* command) { return command->check_name(argv[1]); };
    if (argc > 1 && argv[1][0] != '-' && std::ranges::none_of(program.get_subcommands({}), is_named)) {
        return fail(exit_bad_input, "there is no command '" + std::string(argv[1]) +
                                        "'; use serve, render, record, run, study, info, import, paper or bench, see tetfront --help");
    }
    try {
        program.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() == 0) return program.exit(error);  // --help, --version
        return fail(exit_bad_input, std::string(error.what()) + "; see tetfront --help");
    }
    return action();
}

}  // namespace

int run_program(int argc, const char* const* argv) {
    try {
        const int status = run_checked(argc, argv);
        std::cout.flush();  // goes through stdout, which printf uses as well
        const bool written = std::fflush(stdout) == 0 && !std::ferror(stdout);
        return status == exit_ok && !written ? fail(exit_output_failed, "cannot write to standard output") : status;
    } catch (const InputError& error) {
        return fail(exit_bad_input, error.what());
    } catch (const PortTaken& error) {
        return fail(exit_port_taken, error.what());
    } catch (const OutputError& error) {
        return fail(exit_output_failed, error.what());
    } catch (const std::bad_alloc&) {
        return fail(exit_internal_error, "out of memory; fewer levels or target_tets need less");
    } catch (const std::exception& error) {
        return fail(exit_internal_error, std::string("internal error: ") + error.what());
    } catch (...) {
        return fail(exit_internal_error, "internal error of unknown type");
    }
}

}  // namespace tetfront
