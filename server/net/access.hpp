#pragma once
// Which requests this server answers: those that name it in Host, and come from its own pages (Origin).
//
// A page of another site can make a browser send requests here; its Origin betrays it. A name of another site that was
// rebound to 127.0.0.1 shows in Host.
//
//     AccessPolicy policy("127.0.0.1", 8080);
//     policy.host_allowed("localhost:8080")             // true
//     policy.origin_allowed("http://evil.example")      // false

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace tetfront {

class AccessPolicy {
 public:
    /// host: the address that the server listens on; the names of the loopback are always its names as well.
    AccessPolicy(std::string_view host, std::uint16_t port);

    [[nodiscard]] bool host_allowed(std::string_view host_header) const;
    [[nodiscard]] bool origin_allowed(std::string_view origin_header) const;

 private:
    std::vector<std::string> hosts_;  // lower case, as in a Host header
};

/// "127.0.0.1:8080", "[::1]:8080"
std::string host_and_port(std::string_view host, std::uint16_t port);

}  // namespace tetfront
