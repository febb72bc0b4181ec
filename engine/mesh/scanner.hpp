#pragma once
// Reads words, numbers and raw bytes from a mesh file that may be broken or hostile. Whatever does not fit throws an
// InputError with the file and the line (the byte, in a binary part); nothing is allocated because of a number that the
// file claims.
//
//     Scanner in(bytes, "box.mesh", '#');
//     std::size_t n = in.count("vertices", 6);      // at least 6 bytes each must follow
//     for (...) x = in.real("a coordinate");

#include <bit>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

namespace tetfront {

class Scanner {
 public:
    /// text must outlive the scanner; it begins at line `first_line` of the file. comment: ignores the rest of a line
    /// from this character on; 0: none.
    Scanner(std::string_view text, std::string file, char comment = '\0', std::size_t first_line = 1);

    /// Nothing but blanks and comments is left.
    [[nodiscard]] bool at_end();
    /// Next word; the text must not be at its end.
    std::string_view word(std::string_view what);
    /// Next word without taking it; empty at the end.
    std::string_view peek();
    /// Not even blanks are left.
    [[nodiscard]] bool out_of_text() const { return offset_ == text_.size(); }
    /// The rest of this line, without its end.
    std::string_view line();

    /// Finite number.
    double real(std::string_view what);
    /// Whole number in [low, high].
    std::int64_t integer(std::string_view what, std::int64_t low = INT64_MIN, std::int64_t high = INT64_MAX);
    /// Number of things of which each takes at least `bytes_each` bytes of what follows.
    std::size_t count(std::string_view what, std::size_t bytes_each);

    /// The next `size` bytes.
    std::string_view bytes(std::size_t size, std::string_view what);
    /// Moves behind the next occurrence of `text`, which must exist.
    void skip_behind(std::string_view text);
    /// Throws unless n things of `bytes_each` bytes may follow.
    void expect(std::uint64_t n, std::size_t bytes_each, std::string_view what);

    [[nodiscard]] std::size_t offset() const { return offset_; }
    [[nodiscard]] std::size_t remaining() const { return text_.size() - offset_; }
    /// Errors name the byte instead of the line from now on (or the line again).
    void set_binary(bool binary) { binary_ = binary; }

    /// Throws InputError{file, line or byte of the last thing taken, problem, remedy}.
    [[noreturn]] void fail(const std::string& problem, const std::string& remedy = {}) const;

 private:
    void skip_blanks();

    std::string_view text_;
    std::string file_;
    char comment_;
    std::size_t first_line_;
    bool binary_ = false;
    std::size_t offset_ = 0;  // next byte to read
    std::size_t last_ = 0;    // begin of the last thing taken
};

/// A value in a given byte order. `from` has at least sizeof(T) bytes.
template <class T>
T load(const char* from, bool big_endian) {
    char bytes[sizeof(T)];
    for (std::size_t i = 0; i < sizeof(T); ++i)
        bytes[i] = from[big_endian == (std::endian::native == std::endian::big) ? i : sizeof(T) - 1 - i];
    T value;
    std::memcpy(&value, bytes, sizeof(T));
    return value;
}

}  // namespace tetfront
