#include "server/render/zip.hpp"

#include "engine/base/atomic_file.hpp"

#include <limits>

#include <zlib.h>

namespace tetfront {

namespace {

constexpr std::uint16_t version = 20;              // 2.0: the least that every program reads
constexpr std::uint16_t date = (1 << 5) | 1;       // 1980-01-01, so that the same pictures give the same bytes
constexpr std::uint32_t regular_file = 0100644U << 16;

void put16(std::string& bytes, std::uint32_t value) {
    bytes += static_cast<char>(value & 0xff);
    bytes += static_cast<char>(value >> 8 & 0xff);
}
void put32(std::string& bytes, std::uint64_t value) {
    put16(bytes, static_cast<std::uint32_t>(value & 0xffff));
    put16(bytes, static_cast<std::uint32_t>(value >> 16 & 0xffff));
}

/// What a file's own header and its entry in the directory have in common.
std::string description(std::string_view name, std::string_view bytes) {
    const auto checksum = ::crc32_z(0, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
    std::string header;
    put16(header, version), put16(header, 0), put16(header, 0);  // no flags, stored
    put16(header, 0), put16(header, date);
    put32(header, checksum), put32(header, bytes.size()), put32(header, bytes.size());
    put16(header, static_cast<std::uint32_t>(name.size())), put16(header, 0);  // nothing extra
    return header;
}

}  // namespace

void ZipWriter::add(std::string_view name, std::string_view bytes) {
    constexpr std::uint64_t most = std::numeric_limits<std::uint32_t>::max();
    if (files_ == most_files || size_ + bytes.size() + directory_.size() + 1024 > most)
        throw OutputError("a zip archive holds 65,535 files and 4 GiB: take fewer frames or a smaller size");
    const std::uint64_t offset = size_;
    const std::string common = description(name, bytes);
    std::string header;
    put32(header, 0x04034b50);
    header.append(common).append(name);
    write(header);
    write(bytes);
    put32(directory_, 0x02014b50);
    put16(directory_, 3 << 8 | version);  // made on Unix
    directory_.append(common);
    put16(directory_, 0), put16(directory_, 0), put16(directory_, 0);  // no comment, first disk, plain bytes
    put32(directory_, regular_file), put32(directory_, offset);
    directory_.append(name);
    ++files_;
}

void ZipWriter::finish() {
    std::string end;
    put32(end, 0x06054b50);
    put16(end, 0), put16(end, 0), put16(end, files_), put16(end, files_);
    put32(end, directory_.size()), put32(end, size_), put16(end, 0);
    write(directory_);
    write(end);
}

void ZipWriter::write(std::string_view bytes) {
    sink_(bytes);
    size_ += bytes.size();
}

}  // namespace tetfront
