#include "server/net/access.hpp"

#include <algorithm>

namespace tetfront {

namespace {
bool equal_ignoring_case(std::string_view a, std::string_view b) {
    const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
    return std::ranges::equal(a, b, {}, lower, lower);
}
}  // namespace

std::string host_and_port(std::string_view host, std::uint16_t port) {
    const bool ipv6 = host.find(':') != std::string_view::npos;
    return (ipv6 ? "[" + std::string(host) + "]" : std::string(host)) + ":" + std::to_string(port);
}

AccessPolicy::AccessPolicy(std::string_view host, std::uint16_t port) {
    for (const std::string_view name :
         {std::string_view("localhost"), std::string_view("127.0.0.1"), std::string_view("::1"), host}) {
        hosts_.push_back(host_and_port(name, port));
        // Browsers leave out the scheme's own port.
        if (port == 80) hosts_.push_back(hosts_.back().substr(0, hosts_.back().rfind(':')));
    }
}

bool AccessPolicy::host_allowed(std::string_view host_header) const {
    return std::ranges::any_of(hosts_, [&](const std::string& host) { return equal_ignoring_case(host, host_header); });
}

bool AccessPolicy::origin_allowed(std::string_view origin_header) const {
    constexpr std::string_view scheme = "http://";
    return origin_header.size() > scheme.size() &&
           equal_ignoring_case(origin_header.substr(0, scheme.size()), scheme) &&
           host_allowed(origin_header.substr(scheme.size()));
}

}  // namespace tetfront
