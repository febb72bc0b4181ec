// Refuses to start on a CPU that lacks the instructions that the rest of the program is compiled for. This file alone
// is compiled for the baseline (see server/CMakeLists.txt), and runs before the constructors of any other file's
// globals.

#include <unistd.h>

namespace {

__attribute__((constructor(101))) void check_cpu() {
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2")) return;
    constexpr char message[] =
        "tetfront: this program needs a CPU with AVX2, FMA and BMI2 (x86-64-v3: Intel since 2013, AMD since 2015), "
        "and this one has not all of them\n";
    if (write(STDERR_FILENO, message, sizeof message - 1) < 0) _exit(1);
    _exit(1);
}

}  // namespace
