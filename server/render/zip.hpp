#pragma once
// A zip archive that is written piece by piece, to a file or down a pipe. Its files are stored as they are: pictures are
// compressed already.
//
//     ZipWriter zip([&](std::string_view bytes) { ... });
//     zip.add("000000.png", png);
//     zip.finish();                    // without it the archive has no table of contents, and nothing opens it
//
// The format is PKWARE's APPNOTE 6.3, without its 64-bit extension: at most 65,535 files and 4 GiB.

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

namespace tetfront {

class ZipWriter {
 public:
    using Sink = std::function<void(std::string_view bytes)>;
    static constexpr std::uint32_t most_files = 0xffff;
    explicit ZipWriter(Sink sink) : sink_(std::move(sink)) {}

    /// name: of ASCII characters. Throws OutputError when the archive would become too large; and what the sink throws.
    void add(std::string_view name, std::string_view bytes);
    void finish();

 private:
    void write(std::string_view bytes);

    Sink sink_;
    std::uint64_t size_ = 0;
    std::uint32_t files_ = 0;
    std::string directory_;  // the table of contents so far
};

}  // namespace tetfront
