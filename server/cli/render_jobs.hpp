#pragma once
// Several processes that render parts of one sequence: OpenGL contexts of one process serialise each other.
//
//     int status = run_jobs({"render", "run.tfr", "--out", "frames"}, numbers, 2, [&](int done) { progress.show(done); });

#include <functional>
#include <string>
#include <vector>

namespace tetfront {

/// Runs this program with `arguments` and a part of `numbers` (ascending) each, as many times as there are jobs. What
/// they print on stderr comes through. `frame` is called with the number of each file that has been written.
/// Returns the first exit status that is not 0; when one job fails the others are told to stop.
int run_jobs(const std::vector<std::string>& arguments, const std::vector<int>& numbers, int jobs,
             const std::function<void(int number)>& frame);

}  // namespace tetfront
