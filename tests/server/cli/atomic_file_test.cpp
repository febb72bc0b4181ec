#include "server/cli/atomic_file.hpp"

#include "server/cli/commands.hpp"
#include "tests/support/temporary_folder.hpp"

#include <fstream>
#include <iterator>

#include <gtest/gtest.h>
#include <sys/stat.h>

namespace tetfront {
namespace {

std::string read(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

TEST(AtomicFile, ReplacesTheOldFileAndLeavesNothingElse) {
    const TemporaryFolder folder;
    const auto file = folder.write("out.json", "old");
    check_writable(file);
    EXPECT_EQ(read(file), "old");
    const std::string bytes("new\0bytes", 9);
    write_atomically(file, bytes);
    EXPECT_EQ(read(file), bytes);
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
}

TEST(AtomicFile, KeepsLinksAndRefusesPipes) {
    const TemporaryFolder folder;
    const auto target = folder.write("target.txt", "old");
    const auto link = folder.path() / "link.txt", pipe = folder.path() / "pipe";
    std::filesystem::create_symlink("target.txt", link);
    write_atomically(link, "new");
    EXPECT_TRUE(std::filesystem::is_symlink(link));
    EXPECT_EQ(read(target), "new");
    ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
    EXPECT_THROW(check_writable(pipe), OutputError);
    EXPECT_THROW(write_atomically(pipe, "x"), OutputError);
    EXPECT_TRUE(std::filesystem::is_fifo(pipe));
}

TEST(AtomicFile, FailuresAreOutputErrors) {
    const TemporaryFolder folder;
    EXPECT_THROW(check_writable(folder.path() / "none" / "out.json"), OutputError);
    EXPECT_THROW(check_writable(folder.path()), OutputError);
    EXPECT_THROW(write_atomically("/proc/out.json", "x"), OutputError);
}

}  // namespace
}  // namespace tetfront
