#include "server/net/access.hpp"

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

}  // namespace
}  // namespace tetfront
