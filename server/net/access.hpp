#pragma once
// Which requests this server answers: those that name it in Host, come from its own pages (Origin), and, when there is a
// token, know it.
//
// A page of another site can make a browser send requests here; its Origin betrays it. A name of another site that was
// rebound to 127.0.0.1 shows in Host.
//
//     AccessPolicy policy("127.0.0.1", 8080, {"sim.example.org"}, token);
//     policy.host_allowed("localhost:8080")             // true
//     policy.origin_allowed("http://evil.example")      // false
//     policy.authorized(request["Authorization"], request["Cookie"])

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace tetfront {

class AccessPolicy {
 public:
    /// host: the address that the server listens on; the names of the loopback are always its names as well.
    /// names: further ones, as a Host header has them, such as those of a reverse proxy; pages of theirs may come by https.
    /// token: empty: none is needed.
    AccessPolicy(std::string_view host, std::uint16_t port, const std::vector<std::string>& names = {}, std::string token = {});

    [[nodiscard]] bool host_allowed(std::string_view host_header) const;
    [[nodiscard]] bool origin_allowed(std::string_view origin_header) const;

    [[nodiscard]] bool needs_token() const { return !token_.empty(); }
    /// In time that does not depend on where it differs.
    [[nodiscard]] bool token_matches(std::string_view token) const;
    /// The headers Authorization (Bearer) and Cookie; no token needed: true.
    [[nodiscard]] bool authorized(std::string_view authorization, std::string_view cookies) const;
    /// The value of Set-Cookie that makes a browser authorized.
    [[nodiscard]] std::string cookie() const;

 private:
    std::vector<std::string> hosts_;  // as in a Host header
    std::vector<std::string> names_;
    std::string token_;
};

/// "127.0.0.1:8080", "[::1]:8080"
std::string host_and_port(std::string_view host, std::uint16_t port);
bool is_loopback(std::string_view host);

/// The environment variable TETFRONT_TOKEN, or the first line of `file` when one is given; empty: none. Throws InputError
/// for a file that cannot be read and for a token that is not 16..512 letters, digits or - . _ ~ + / =.
std::string read_token(const std::filesystem::path& file);

}  // namespace tetfront
