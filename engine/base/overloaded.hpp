#pragma once
// One function for each alternative of a variant:
//
//     std::visit(Overloaded{[](double x) { ... }, [](const std::string& s) { ... }}, value);

namespace tetfront {

template <class... Cases>
struct Overloaded : Cases... {
    using Cases::operator()...;
};
template <class... Cases>
Overloaded(Cases...) -> Overloaded<Cases...>;  // clang 16 does not deduce aggregates

}  // namespace tetfront
