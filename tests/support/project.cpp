#include "tests/support/project.hpp"

namespace tetfront {

std::filesystem::path source_folder() { return TETFRONT_SOURCE_DIR; }
std::string program_path() { return TETFRONT_PROGRAM; }

}  // namespace tetfront
