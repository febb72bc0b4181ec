#pragma once
// One function for each alternative of a variant:
//
//     std::visit(Overloaded{[](double x) { ... }, [](const std::string& s) { ... }}, value);

namespace tetfront {

template <class... Cases>
struct Overloaded : Cases... {
    using Cases::operator()...;
};

}  // namespace tetfront
