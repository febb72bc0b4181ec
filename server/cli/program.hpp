#pragma once
// The command line as a function, so that tests can call it.

namespace tetfront {

/// Parses the arguments, runs the subcommand and returns the exit status. Never throws: every failure is one line on
/// stderr.
int run_program(int argc, const char* const* argv);

}  // namespace tetfront
