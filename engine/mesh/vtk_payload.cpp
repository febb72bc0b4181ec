#include "engine/mesh/vtk_payload.hpp"

#include "engine/mesh/scanner.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include <zlib.h>

namespace tetfront {

namespace {

/// zlib cannot compress better than this.
constexpr std::uint64_t max_zlib_ratio = 1040;

/// Digit of a base64 character, -1: padding, -2: none.
int base64_digit(char c) {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    if (c == '+') return 62;
    if (c == '/') return 63;
    return c == '=' ? -1 : -2;
}

/// Bytes one after another. Base64 groups with padding may come in the middle: some writers encode a header on its own.
class ByteSource {
 public:
    ByteSource(std::string_view text, bool base64, const VtkFail& fail) : text_(text), base64_(base64), fail_(fail) {}

    std::string take(std::uint64_t size) {
        const std::uint64_t available =
            base64_ ? pending_.size() + (text_.size() - next_) / 4 * 3 : text_.size() - next_;
        if (size > available)
            fail_("an array announces " + std::to_string(size) + " bytes, but only " + std::to_string(available) +
                      " follow",
                  "the file is cut off or broken: export it again");
        std::string bytes;
        if (!base64_) {
            bytes = text_.substr(next_, size);
            next_ += size;
            return bytes;
        }
        bytes.reserve(size + 3);
        std::swap(bytes, pending_);
        while (bytes.size() < size) take_group(bytes);
        pending_ = bytes.substr(size);
        bytes.resize(size);
        return bytes;
    }

 private:
    void take_group(std::string& out) {
        std::array<int, 4> digits{};
        for (int& digit : digits) {
            while (next_ < text_.size() &&
                   (text_[next_] == ' ' || text_[next_] == '\n' || text_[next_] == '\r' || text_[next_] == '\t'))
                ++next_;
            if (next_ == text_.size())
                fail_("an array ends too early", "the file is cut off or broken: export it again");
            digit = base64_digit(text_[next_++]);
            if (digit == -2)
                fail_("an array holds a character that is not base64", "the file is broken: export it again");
        }
        const int bytes = digits[3] >= 0 ? 3 : digits[2] >= 0 ? 2 : 1;
        if (digits[0] < 0 || digits[1] < 0 || (digits[2] < 0 && digits[3] >= 0))
            fail_("an array holds broken base64", "the file is broken: export it again");
        const unsigned value = static_cast<unsigned>(digits[0]) << 18 | static_cast<unsigned>(digits[1]) << 12 |
                               static_cast<unsigned>(std::max(digits[2], 0)) << 6 |
                               static_cast<unsigned>(std::max(digits[3], 0));
        for (int i = 0; i < bytes; ++i) out += static_cast<char>(value >> (16 - 8 * i) & 0xFF);
    }

    std::string_view text_;
    bool base64_;
    const VtkFail& fail_;
    std::size_t next_ = 0;
    std::string pending_;  // decoded, not yet taken
};

}  // namespace

std::string decode_payload(std::string_view text, const VtkEncoding& encoding, const VtkFail& fail) {
    ByteSource source(text, encoding.base64, fail);
    const std::size_t width = size_of(encoding.header);
    const auto read_size = [&] {
        return static_cast<std::uint64_t>(
            load_integer(source.take(width).data(), encoding.header, encoding.big_endian));
    };
    const auto check_total = [&](std::uint64_t bytes) {
        if (bytes > max_vtk_payload)
            fail("an array announces " + std::to_string(bytes) + " bytes", "the file is broken or too large");
    };
    if (!encoding.zlib) {
        const std::uint64_t size = read_size();
        check_total(size);
        return source.take(size);
    }
    const std::uint64_t blocks = read_size(), block_size = read_size(), last_size = read_size();
    if (blocks > text.size()) fail("an array announces " + std::to_string(blocks) + " blocks", "the file is broken");
    check_total(block_size);
    check_total(last_size);
    std::vector<std::uint64_t> compressed;
    for (std::uint64_t b = 0; b < blocks; ++b) compressed.push_back(read_size());
    std::string out;
    for (std::uint64_t b = 0; b < blocks; ++b) {
        const std::uint64_t size = b + 1 == blocks && last_size > 0 ? last_size : block_size;
        const std::string packed = source.take(compressed[b]);
        if (size > max_zlib_ratio * (packed.size() + 1))
            fail("a compressed block claims too many bytes", "the file is broken");
        check_total(out.size() + size);
        const std::size_t before = out.size();
        out.resize(before + size);
        uLongf unpacked = size;
        const int result = uncompress(reinterpret_cast<Bytef*>(out.data() + before), &unpacked,
                                      reinterpret_cast<const Bytef*>(packed.data()), packed.size());
        if (result != Z_OK || unpacked != size) fail("a compressed block is broken", "export the file again");
    }
    return out;
}

}  // namespace tetfront
