#include "server/net/access.hpp"

#include "engine/base/error.hpp"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <utility>

namespace tetfront {

namespace {

constexpr std::string_view cookie_name = "tetfront_token=";

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

bool equal_ignoring_case(std::string_view a, std::string_view b) { return std::ranges::equal(a, b, {}, lower, lower); }

bool any_equal(const std::vector<std::string>& known, std::string_view text) {
    return std::ranges::any_of(known, [&](const std::string& one) { return equal_ignoring_case(one, text); });
}

/// The rest of `text` after a prefix; nullopt without it.
std::string_view after(std::string_view text, std::string_view prefix) {
    return text.size() > prefix.size() && equal_ignoring_case(text.substr(0, prefix.size()), prefix) ? text.substr(prefix.size())
                                                                                                    : std::string_view();
}

}  // namespace

std::string host_and_port(std::string_view host, std::uint16_t port) {
    const bool ipv6 = host.find(':') != std::string_view::npos;
    return (ipv6 ? "[" + std::string(host) + "]" : std::string(host)) + ":" + std::to_string(port);
}

bool is_loopback(std::string_view host) { return host == "localhost" || host == "::1" || host.starts_with("127."); }

AccessPolicy::AccessPolicy(std::string_view host, std::uint16_t port, const std::vector<std::string>& names, std::string token)
    : names_(names), token_(std::move(token)) {
    for (const std::string_view name :
         {std::string_view("localhost"), std::string_view("127.0.0.1"), std::string_view("::1"), host}) {
        hosts_.push_back(host_and_port(name, port));
        // Browsers leave out the scheme's own port.
        if (port == 80) hosts_.push_back(hosts_.back().substr(0, hosts_.back().rfind(':')));
    }
}

bool AccessPolicy::host_allowed(std::string_view host_header) const {
    return any_equal(hosts_, host_header) || any_equal(names_, host_header);
}

bool AccessPolicy::origin_allowed(std::string_view origin_header) const {
    const std::string_view plain = after(origin_header, "http://"), secure = after(origin_header, "https://");
    return (!plain.empty() && host_allowed(plain)) || (!secure.empty() && any_equal(names_, secure));
}

bool AccessPolicy::token_matches(std::string_view token) const {
    // Every byte of the given one is looked at, whatever the others were.
    unsigned difference = token.size() == token_.size() ? 0 : 1;
    for (std::size_t i = 0; i < token.size(); ++i)
        difference |= static_cast<unsigned char>(token[i]) ^ static_cast<unsigned char>(token_.empty() ? 0 : token_[i % token_.size()]);
    return difference == 0 && !token_.empty();
}

bool AccessPolicy::authorized(std::string_view authorization, std::string_view cookies) const {
    if (!needs_token()) return true;
    if (token_matches(after(authorization, "Bearer "))) return true;
    while (!cookies.empty()) {
        std::string_view one = cookies.substr(0, cookies.find(';'));
        cookies.remove_prefix(std::min(cookies.size(), one.size() + 1));
        while (one.starts_with(' ')) one.remove_prefix(1);
        if (one.starts_with(cookie_name) && token_matches(one.substr(cookie_name.size()))) return true;
    }
    return false;
}

std::string AccessPolicy::cookie() const { return std::string(cookie_name) + token_ + "; Path=/; HttpOnly; SameSite=Strict"; }

std::string read_token(const std::filesystem::path& file) {
    std::string token, source = "TETFRONT_TOKEN";
    if (!file.empty()) {
        source = file.string();
        std::ifstream in(file);
        std::getline(in, token);
        if (token.ends_with('\r')) token.pop_back();
        if (token.empty()) throw InputError(source, "", "holds no token", "write one of 16 or more characters into its first line");
    } else if (const char* value = std::getenv("TETFRONT_TOKEN")) {
        token = value;
    }
    const auto plain = [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
               std::string_view("-._~+/=").find(c) != std::string_view::npos;
    };
    if (!token.empty() && (token.size() < 16 || token.size() > 512 || !std::ranges::all_of(token, plain)))
        throw InputError(source, "", "is no token", "use 16 to 512 letters, digits or -._~+/=, for example from: openssl rand -hex 24");
    return token;
}

}  // namespace tetfront
