#include "engine/mesh/scanner.hpp"

#include "engine/base/error.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>
#include <utility>

namespace tetfront {

namespace {

bool is_blank(char c) { return c == ' ' || c == '\n' || c == '\t' || c == '\r' || c == '\f' || c == '\v'; }

/// A word of the file as it may be shown: short, printable.
std::string quoted(std::string_view word) {
    std::string text = "'";
    for (char c : word.substr(0, 40)) text += c >= ' ' && c <= '~' ? c : '?';
    return text + (word.size() > 40 ? "...'" : "'");
}

/// from_chars takes no leading plus sign.
std::string_view without_plus(std::string_view word) {
    return word.size() > 1 && word[0] == '+' && word[1] != '-' ? word.substr(1) : word;
}

}  // namespace

Scanner::Scanner(std::string_view text, std::string file, char comment, std::size_t first_line)
    : text_(text), file_(std::move(file)), comment_(comment), first_line_(first_line) {}

void Scanner::skip_blanks() {
    while (offset_ < text_.size()) {
        if (is_blank(text_[offset_])) {
            ++offset_;
        } else if (comment_ && text_[offset_] == comment_) {
            offset_ = std::min(text_.find('\n', offset_), text_.size());
        } else {
            return;
        }
    }
}

bool Scanner::at_end() {
    skip_blanks();
    return offset_ == text_.size();
}

std::string_view Scanner::peek() {
    skip_blanks();
    std::size_t end = offset_;
    while (end < text_.size() && !is_blank(text_[end]) && !(comment_ && text_[end] == comment_)) ++end;
    return text_.substr(offset_, end - offset_);
}

std::string_view Scanner::word(std::string_view what) {
    const std::string_view next = peek();
    last_ = offset_;
    if (next.empty()) fail("ends where " + std::string(what) + " should be", "the file is cut off: export it again");
    offset_ += next.size();
    return next;
}

std::string_view Scanner::line() {
    last_ = offset_;
    const std::size_t end = std::min(text_.find('\n', offset_), text_.size());
    std::string_view rest = text_.substr(offset_, end - offset_);
    offset_ = std::min(end + 1, text_.size());
    if (!rest.empty() && rest.back() == '\r') rest.remove_suffix(1);
    return rest;
}

double Scanner::real(std::string_view what) {
    const std::string_view text = word(what), digits = without_plus(text);
    double value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error == std::errc::result_out_of_range)
        fail(quoted(text) + " is out of range for " + std::string(what), "numbers must fit in double precision");
    if (error != std::errc() || end != digits.data() + digits.size())
        fail(quoted(text) + " is not " + std::string(what), "a number is expected");
    if (!std::isfinite(value)) fail(quoted(text) + " is not finite", "coordinates must be finite numbers");
    return value;
}

std::int64_t Scanner::integer(std::string_view what, std::int64_t low, std::int64_t high) {
    const std::string_view text = word(what), digits = without_plus(text);
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    const bool too_large = error == std::errc::result_out_of_range;
    if (!too_large && (error != std::errc() || end != digits.data() + digits.size()))
        fail(quoted(text) + " is not " + std::string(what), "a whole number is expected");
    if (too_large || value < low || value > high) {
        std::string remedy = "use a whole number";
        if (low != INT64_MIN) remedy += " from " + std::to_string(low);
        if (high != INT64_MAX) remedy += " to " + std::to_string(high);
        fail(quoted(text) + " is out of range for " + std::string(what), remedy);
    }
    return value;
}

std::size_t Scanner::count(std::string_view what, std::size_t bytes_each) {
    const std::int64_t n = integer("the number of " + std::string(what), 0);
    expect(static_cast<std::uint64_t>(n), bytes_each, what);
    return static_cast<std::size_t>(n);
}

void Scanner::expect(std::uint64_t n, std::size_t bytes_each, std::string_view what) {
    // The last of them may lack its blank at the end of the file.
    if (n > (remaining() + 1) / std::max<std::size_t>(bytes_each, 1))
        fail("announces " + std::to_string(n) + " " + std::string(what) + ", but only " + std::to_string(remaining()) +
                 " bytes follow",
             "the file is cut off or broken: export it again");
}

std::string_view Scanner::bytes(std::size_t size, std::string_view what) {
    last_ = offset_;
    if (size > remaining()) fail("ends inside " + std::string(what), "the file is cut off: export it again");
    offset_ += size;
    return text_.substr(last_, size);
}

void Scanner::skip_behind(std::string_view text) {
    last_ = offset_;
    const std::size_t found = text_.find(text, offset_);
    if (found == std::string_view::npos)
        fail("lacks " + quoted(text), "the file is cut off or broken: export it again");
    offset_ = found + text.size();
}

void Scanner::fail(const std::string& problem, const std::string& remedy) const {
    const std::size_t lines =
        static_cast<std::size_t>(std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(last_), '\n'));
    throw InputError{file_, binary_ ? "byte " + std::to_string(last_) : "line " + std::to_string(first_line_ + lines),
                     problem, remedy};
}

}  // namespace tetfront
