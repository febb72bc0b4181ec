#include "engine/base/error.hpp"

#include <utility>

namespace tetfront {

namespace {
std::string one_line(const std::string& file, const std::string& where, const std::string& problem,
                     const std::string& remedy) {
    std::string line;
    for (const std::string* part : {&file, &where}) {
        if (!part->empty()) line += *part + ": ";
    }
    line += problem;
    if (!remedy.empty()) line += "; " + remedy;
    return line;
}
}  // namespace

InputError::InputError(std::string file_, std::string where_, std::string problem_, std::string remedy_)
    : std::runtime_error(one_line(file_, where_, problem_, remedy_)),
      file(std::move(file_)),
      where(std::move(where_)),
      problem(std::move(problem_)),
      remedy(std::move(remedy_)) {}

}  // namespace tetfront
