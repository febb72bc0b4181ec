#pragma once
// A value given on the command line in place of the scene file's.

#include <string>
#include <utility>

namespace tetfront {

/// JSON pointer and JSON text of a value that replaces the file's, or is added to it: {"/front/tolerance", "0.01"}. Text
/// that is not JSON is taken as a string.
using Override = std::pair<std::string, std::string>;

}  // namespace tetfront
