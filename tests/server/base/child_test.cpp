// Processes of our own, and descriptors.

#include "server/base/child.hpp"

#include <array>
#include <cerrno>
#include <csignal>

#include <gtest/gtest.h>
#include <unistd.h>

namespace tetfront {
namespace {

Ending run(const std::string& script, const Streams& streams = {}) { return Child("sh", {"sh", "-c", script}, streams).wait(); }

TEST(Child, SaysHowItEnded) {
    EXPECT_TRUE(run("exit 0").good());
    const Ending exited = run("exit 3"), killed = run("kill -9 $$");
    EXPECT_FALSE(exited.good());
    EXPECT_EQ(exited.status, 3);
    EXPECT_EQ(exited.text(), "exit status 3");
    EXPECT_FALSE(killed.good());
    EXPECT_EQ(killed.signal, SIGKILL);
    EXPECT_EQ(killed.text(), "signal 9");
}

TEST(Child, AProgramThatIsNotThereIsSaidToBe) {
    try {
        Child("no-such-program", {"no-such-program"});
        FAIL() << "it was started";
    } catch (const StartError& error) {
        EXPECT_EQ(error.error, ENOENT);
        EXPECT_NE(std::string(error.what()).find("no-such-program"), std::string::npos);
    }
}

TEST(Child, FailuresAreSeenWhereWhoeverStartedUsIgnoresChildren) {
    std::signal(SIGCHLD, SIG_IGN);
    EXPECT_EQ(run("exit 3").status, 3);
}

TEST(Child, HasItsStreamsAndNothingElse) {
    Pipe out = make_pipe();
    std::array<int, 2> open{};  // as a library opens it
    ASSERT_EQ(::pipe(open.data()), 0);
    EXPECT_TRUE(run("[ ! -e /proc/$$/fd/" + std::to_string(open[1]) + " ]").good());
    EXPECT_TRUE(run("cat; echo said", {.in = open_null().get(), .out = out.write.get()}).good());
    std::array<char, 5> said{};
    EXPECT_EQ(::read(out.read.get(), said.data(), said.size()), 5);
    EXPECT_EQ(std::string(said.data(), said.size()), "said\n");
    ::close(open[0]), ::close(open[1]);
}

TEST(Child, EndsWithItsObject) {
    int process = 0;
    {
        const Child child("sleep", {"sleep", "1000"});
        process = child.process();
        EXPECT_EQ(::kill(process, 0), 0);
    }
    EXPECT_EQ(::kill(process, 0), -1);
    EXPECT_EQ(errno, ESRCH);
}

TEST(Descriptor, AFileInMemoryKeepsWhatAChildSays) {
    const Descriptor said = make_buffer();
    ASSERT_TRUE(run("head -c 300000 /dev/zero | tr '\\0' x >&2; echo last >&2", {.err = said.get()}).good()) << "more than a pipe takes";
    EXPECT_EQ(read_end(said.get(), 7), "xxlast\n");
    EXPECT_EQ(read_end(said.get(), 1 << 20).size(), 300'005U);
}

TEST(Descriptor, WritingSaysWhatWentWrong) {
    EXPECT_EQ(write_all(make_buffer().get(), std::string(1 << 20, 'x')), 0);
    EXPECT_EQ(write_all(-1, "x"), EBADF);
}

}  // namespace
}  // namespace tetfront
