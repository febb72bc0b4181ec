#pragma once
// The three error channels.
//
// - A bug asserts with its values: `ENSURE(a == b, "sizes ", a, ' ', b)` (always on) or `CHECK_DEBUG(...)` (dev preset).
// - Bad input throws InputError, which says where, what, and what to do:
//       throw InputError{"scene.json", "/material/poisson", "is 0.7", "use a number in [0, 0.5)"};
// - Numerical trouble is data: see StepReport in simulation/simulation.hpp. It never throws.

#include <sstream>
#include <stdexcept>
#include <string>

namespace tetfront {

/// Input from outside (file, command, environment) that cannot be used.
/// what(): "FILE: WHERE: PROBLEM; REMEDY", one line, without the empty parts.
class InputError : public std::runtime_error {
 public:
    /// file: name of the file or other source, may be empty. where: line or JSON pointer, may be empty.
    /// problem: what is wrong. remedy: what is allowed or what to do, may be empty.
    InputError(std::string file, std::string where, std::string problem, std::string remedy);

    std::string file, where, problem, remedy;
};

/// A broken invariant: a bug of ours.
class LogicError : public std::logic_error {
    using std::logic_error::logic_error;
};

namespace detail {
template <class... Parts>
[[noreturn]] void fail(const char* file, int line, const char* condition, const Parts&... parts) {
    std::ostringstream message;
    message << file << ':' << line << ": (" << condition << ") does not hold: ";
    (message << ... << parts);
    throw LogicError(message.str());
}
}  // namespace detail

}  // namespace tetfront

#define ENSURE(condition, ...)                                                                              \
    do {                                                                                                    \
        if (!(condition)) ::tetfront::detail::fail(__FILE__, __LINE__, #condition __VA_OPT__(, ) __VA_ARGS__); \
    } while (false)

#ifdef TETFRONT_CHECKS
#define CHECK_DEBUG(...) ENSURE(__VA_ARGS__)
#else
#define CHECK_DEBUG(...) static_cast<void>(0)
#endif
