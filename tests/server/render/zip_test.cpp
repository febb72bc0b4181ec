#include "server/render/zip.hpp"

#include "engine/base/atomic_file.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/temporary_folder.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>

#include <gtest/gtest.h>

namespace tetfront {
namespace {

std::string archive(const std::vector<std::pair<std::string, std::string>>& files) {
    std::string bytes;
    ZipWriter zip([&](std::string_view part) { bytes += part; });
    for (const auto& [name, content] : files) zip.add(name, content);
    zip.finish();
    return bytes;
}

/// Unpacks it in its folder with CMake. Returns the exit status.
int unpack(const std::filesystem::path& file) {
    return ChildProcess({"/usr/bin/env", "-C", file.parent_path().string(), "cmake", "-E", "tar", "xf", file.string()}).wait().status;
}
std::string bytes_of(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

TEST(Zip, IsReadByAnotherProgram) {
    const TemporaryFolder folder;
    const std::string large(70'000, 'x');
    ASSERT_EQ(unpack(folder.write("a.zip", archive({{"000000.png", "first"}, {"empty", ""}, {"b.txt", large}}))), 0);
    EXPECT_EQ(bytes_of(folder.path() / "000000.png"), "first");
    EXPECT_TRUE(std::filesystem::is_empty(folder.path() / "empty"));
    EXPECT_EQ(bytes_of(folder.path() / "b.txt"), large);
}

TEST(Zip, ChecksumIsTheStandards) {
    const std::string bytes = archive({{"a", "123456789"}});
    EXPECT_EQ(bytes.substr(14, 4), std::string("\x26\x39\xF4\xCB")) << "CRC-32's check value, 0xCBF43926";
    const std::size_t entry = bytes.find("PK\1\2");
    ASSERT_NE(entry, std::string::npos);
    EXPECT_EQ(bytes.substr(entry + 16, 4), bytes.substr(14, 4)) << "and the same in the table of contents";
}

TEST(Zip, SaysNothingAboutWhenItWasMade) {
    const std::string bytes = archive({{"a", "b"}});
    const std::size_t entry = bytes.find("PK\1\2");
    ASSERT_NE(entry, std::string::npos);
    const std::string first_of_1980("\0\0\x21\0", 4);  // time and date as MS-DOS has them
    EXPECT_EQ(bytes.substr(10, 4), first_of_1980);
    EXPECT_EQ(bytes.substr(entry + 12, 4), first_of_1980);
}

TEST(Zip, MoreFilesThanTheFormatCountsAreRefused) {
    std::size_t written = 0;
    ZipWriter zip([&](std::string_view part) { written += part.size(); });
    for (std::uint32_t i = 0; i < ZipWriter::most_files; ++i) zip.add("a", "");
    const std::size_t before = written;
    EXPECT_THROW(zip.add("a", ""), OutputError);
    EXPECT_EQ(written, before);
}

}  // namespace
}  // namespace tetfront
