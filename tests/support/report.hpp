#pragma once
// What report programs in tests/benchmarks share with `tetfront paper`.

#include "server/cli/report_head.hpp"

namespace tetfront::testing {

using tetfront::write_head;
inline std::string number(double value, const char* format = "%.3g") { return format_number(value, format); }

}  // namespace tetfront::testing
