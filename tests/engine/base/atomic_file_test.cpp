#include "engine/base/atomic_file.hpp"

#include "tests/support/temporary_folder.hpp"

#include <csignal>
#include <fstream>
#include <iterator>

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/resource.h>

namespace tetfront {
namespace {

std::string read(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
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

TEST(AtomicFile, FailuresAreOutputErrors) {
    const TemporaryFolder folder;
    EXPECT_THROW(check_writable(folder.path() / "none" / "out.json"), OutputError);
    EXPECT_THROW(check_writable(folder.path()), OutputError);
    EXPECT_THROW(write_atomically("/proc/out.json", "x"), OutputError);
}

std::size_t files_in(const std::filesystem::path& folder) {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

TEST(AtomicFile, ReplacesWithoutSyncing) {
    const TemporaryFolder folder;
    write_atomically(folder.path() / "a", "one");
    write_atomically(folder.path() / "a", "two");
    EXPECT_EQ(read(folder.path() / "a"), "two");
    EXPECT_EQ(files_in(folder.path()), 1U);
}

TEST(AtomicFile, NamesTheFileThatCannotBeWritten) {
    const TemporaryFolder folder;
    folder.write("file", "x");
    std::filesystem::create_directory(folder.path() / "directory");
    for (const char* name : {"file/a.png", "missing/a.png", "directory"}) {
        try {
            write_atomically(folder.path() / name, "bytes");
            ADD_FAILURE() << name << " was written";
        } catch (const OutputError& error) {
            EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
        }
    }
    EXPECT_EQ(files_in(folder.path()), 2U);
    EXPECT_THROW(prepare_directory(folder.path() / "file" / "below"), OutputError);
    prepare_directory(folder.path() / "new" / "below");
    EXPECT_EQ(files_in(folder.path() / "new" / "below"), 0U);
}

TEST(AtomicFile, KeepsTheOldFileWhenTheDiskIsFull) {
    const TemporaryFolder folder;
    write_atomically(folder.path() / "a", "old");
    // A limit on the size of files fails in the middle of a write, as a full disk does.
    rlimit before{};
    ::getrlimit(RLIMIT_FSIZE, &before);
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit small{1000, before.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &small);
    EXPECT_THROW(write_atomically(folder.path() / "a", std::string(5000, 'x')), OutputError);
    EXPECT_THROW(write_atomically(folder.path() / "b", std::string(5000, 'x')), OutputError);
    ::setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, handler);
    EXPECT_EQ(read(folder.path() / "a"), "old");
    EXPECT_EQ(files_in(folder.path()), 1U) << "neither a half-written nor a temporary file";
}

}  // namespace
}  // namespace tetfront
