#pragma once
// What the `tetfront` program says with its exit status, to shells and to itself where it runs its own commands.

namespace tetfront {

/// The same for all subcommands.
enum ExitStatus : int {
    exit_ok = 0,
    exit_internal_error = 1,
    exit_bad_input = 2,  // InputError, or wrong usage
    exit_port_taken = 3,
    exit_output_failed = 4,  // OutputError
};

}  // namespace tetfront
