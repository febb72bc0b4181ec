#include "server/net/web_files.hpp"

#include "engine/base/error.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

namespace tetfront {
namespace {

TEST(WebFiles, AreFoundByExactTargetOnly) {
    const TemporaryFolder folder;
    folder.write("index.html", "<!doctype html>");
    folder.write("assets/main-1a2b.js", "let x");
    folder.write("secret.key", "not for you");
    const WebFiles files = load_web_files(folder.path());
    ASSERT_NE(find(files, "/"), nullptr);
    EXPECT_EQ(find(files, "/")->bytes, "<!doctype html>");
    EXPECT_EQ(find(files, "/")->cache_control, "no-store");
    ASSERT_NE(find(files, "/assets/main-1a2b.js?x=/../y"), nullptr);
    EXPECT_EQ(find(files, "/assets/main-1a2b.js")->content_type, "text/javascript; charset=utf-8");
    EXPECT_NE(find(files, "/assets/main-1a2b.js")->cache_control.find("immutable"), std::string::npos);
    for (const char* target :
         {"", "*", "/secret.key", "/assets", "/assets/", "//", "/index.html/", "/./index.html", "/../index.html",
          "/%69ndex.html", "/..%2f..%2fetc/passwd", "/assets/../index.html", "/INDEX.HTML", "http://localhost/"})
        EXPECT_EQ(find(files, target), nullptr) << target;
}

TEST(WebFiles, EtagFollowsTheBytes) {
    const TemporaryFolder a, b;
    a.write("index.html", "one");
    b.write("index.html", "two");
    const std::string etag = find(load_web_files(a.path()), "/")->etag;
    EXPECT_EQ(etag.size(), 18U);
    EXPECT_EQ(etag, find(load_web_files(a.path()), "/")->etag);
    EXPECT_NE(etag, find(load_web_files(b.path()), "/")->etag);
}

TEST(WebFiles, MissingBuildSaysWhatToDo) {
    const TemporaryFolder folder;
    try {
        load_web_files(folder.path() / "dist");
        FAIL();
    } catch (const InputError& error) {
        EXPECT_NE(error.remedy.find("npm run build"), std::string::npos);
    }
}

}  // namespace
}  // namespace tetfront
