#include "server/net/access.hpp"

#include "engine/base/error.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

namespace tetfront {
namespace {

TEST(AccessPolicy, AllowsLoopbackNamesWithThePortOnly) {
    const AccessPolicy policy("127.0.0.1", 8080);
    for (const char* host : {"127.0.0.1:8080", "localhost:8080", "LocalHost:8080", "[::1]:8080"}) {
        EXPECT_TRUE(policy.host_allowed(host)) << host;
        EXPECT_TRUE(policy.origin_allowed(std::string("http://") + host)) << host;
    }
    for (const char* host : {"", "localhost", "localhost:80", "localhost:80800", "evil.example:8080",
                             "127.0.0.1.evil.example:8080", "localhost:8080.evil.example", "127.0.0.2:8080",
                             "localhost:8080/", "user@localhost:8080", "localhost:8080 "}) {
        EXPECT_FALSE(policy.host_allowed(host)) << host;
        EXPECT_FALSE(policy.origin_allowed(std::string("http://") + host)) << host;
    }
    for (const char* origin :
         {"", "null", "http://", "https://localhost:8080", "localhost:8080", "http://localhost:8080/x", "file://"})
        EXPECT_FALSE(policy.origin_allowed(origin)) << origin;
}

TEST(AccessPolicy, LeavesOutPort80AsBrowsersDo) {
    const AccessPolicy policy("::1", 80);
    EXPECT_TRUE(policy.host_allowed("localhost"));
    EXPECT_TRUE(policy.host_allowed("[::1]"));
    EXPECT_TRUE(policy.host_allowed("[::1]:80"));
    EXPECT_FALSE(policy.host_allowed("localhost:8080"));
}

TEST(AccessPolicy, KnowsTheAddressItListensOn) {
    const AccessPolicy policy("192.168.1.5", 9000);
    EXPECT_TRUE(policy.host_allowed("192.168.1.5:9000"));
    EXPECT_TRUE(policy.host_allowed("localhost:9000"));
    EXPECT_FALSE(policy.host_allowed("192.168.1.6:9000"));
}

TEST(AccessPolicy, FurtherNamesMayComeByHttps) {
    const AccessPolicy policy("0.0.0.0", 8080, {"sim.example.org", "other.example:8443"});
    EXPECT_TRUE(policy.host_allowed("SIM.example.org"));
    EXPECT_TRUE(policy.origin_allowed("https://sim.example.org"));
    EXPECT_TRUE(policy.origin_allowed("http://sim.example.org"));
    EXPECT_TRUE(policy.origin_allowed("https://other.example:8443"));
    EXPECT_FALSE(policy.host_allowed("example.org"));
    EXPECT_FALSE(policy.host_allowed("xsim.example.org"));
    EXPECT_FALSE(policy.origin_allowed("https://127.0.0.1:8080"));
    EXPECT_FALSE(policy.origin_allowed("https://other.example"));
    EXPECT_FALSE(policy.origin_allowed("https://"));
}

TEST(AccessPolicy, TokenByHeaderOrCookie) {
    const std::string token = "0123456789abcdef-secret";
    const AccessPolicy policy("127.0.0.1", 8080, {}, token);
    EXPECT_TRUE(policy.needs_token());
    EXPECT_TRUE(policy.authorized("Bearer " + token, ""));
    EXPECT_TRUE(policy.authorized("bearer " + token, ""));
    EXPECT_TRUE(policy.authorized("", "a=b; tetfront_token=" + token));
    EXPECT_TRUE(policy.authorized("Bearer wrong", "tetfront_token=" + token + "; c=d"));
    for (const std::string& wrong : {std::string(), std::string("Bearer "), "Bearer " + token + "x", "Bearer " + token.substr(1),
                                     "Bearer " + token + token, "Basic " + token, token})
        EXPECT_FALSE(policy.authorized(wrong, "")) << wrong;
    for (const std::string& wrong : {"tetfront_token=", "xtetfront_token=0123456789abcdef-secret", "tetfront_token=0123456789abcdef-secreT", ";;;", "tetfront_token"})
        EXPECT_FALSE(policy.authorized("", wrong)) << wrong;
    EXPECT_NE(policy.cookie().find("HttpOnly"), std::string::npos);
    EXPECT_NE(policy.cookie().find("SameSite=Strict"), std::string::npos);
    const AccessPolicy open("127.0.0.1", 8080);
    EXPECT_TRUE(open.authorized("", ""));
    EXPECT_FALSE(open.token_matches("")) << "no token is no password";
}

TEST(AccessPolicy, ReadsATokenFromItsFile) {
    const TemporaryFolder folder;
    folder.write("token", "0123456789abcdef\r\nsecond line");
    EXPECT_EQ(read_token(folder.path() / "token"), "0123456789abcdef");
    folder.write("short", "secret\n");
    EXPECT_THROW(read_token(folder.path() / "short"), InputError);
    folder.write("spaces", "0123456789 abcdef\n");
    EXPECT_THROW(read_token(folder.path() / "spaces"), InputError);
    folder.write("empty", "");
    EXPECT_THROW(read_token(folder.path() / "empty"), InputError);
    folder.write("blank", "\n0123456789abcdef\n");
    EXPECT_THROW(read_token(folder.path() / "blank"), InputError) << "or all would be let in";
    EXPECT_THROW(read_token(folder.path() / "missing"), InputError);
}

}  // namespace
}  // namespace tetfront
