#pragma once
// Values in, bytes out, and back in the same order: for our own binary files on the machine that wrote them.
//
//     ByteWriter out;                          ByteReader in(out.bytes());
//     out.put(3.5);                            double x; std::vector<int> v;
//     out.put_range(std::vector{1, 2});        if (!in.get(x) || !in.get_range(v) || !in.done()) return damaged();
//
// A reader believes no length: it never reserves more memory than there are bytes left.

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace tetfront {

class ByteWriter {
 public:
    template <class T>
    void put(const T& value) {
        static_assert(std::is_trivially_copyable_v<T> && !std::is_pointer_v<T>);
        bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
    }
    /// A std::vector or std::string of such values, with its length.
    template <class Range>
    void put_range(const Range& values) {
        static_assert(std::is_trivially_copyable_v<typename Range::value_type>);
        put(std::uint64_t{values.size()});
        bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(typename Range::value_type));
    }
    [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
    std::string bytes_;
};

/// All get functions return false when the bytes do not hold what is asked for.
class ByteReader {
 public:
    explicit ByteReader(std::string_view bytes) : bytes_(bytes) {}

    template <class T>
    [[nodiscard]] bool get(T& value) {
        static_assert(std::is_trivially_copyable_v<T> && !std::is_pointer_v<T>);
        if (bytes_.size() < sizeof value) return false;
        std::memcpy(static_cast<void*>(&value), bytes_.data(), sizeof value);
        bytes_.remove_prefix(sizeof value);
        return true;
    }
    template <class Range>
    [[nodiscard]] bool get_range(Range& values) {
        using T = typename Range::value_type;
        std::uint64_t size = 0;
        if (!get(size) || size > bytes_.size() / sizeof(T)) return false;
        values.resize(size);
        if (size) std::memcpy(static_cast<void*>(values.data()), bytes_.data(), size * sizeof(T));
        bytes_.remove_prefix(size * sizeof(T));
        return true;
    }
    [[nodiscard]] bool done() const { return bytes_.empty(); }
    /// What has not been read.
    [[nodiscard]] std::string_view rest() const { return bytes_; }

 private:
    std::string_view bytes_;
};

}  // namespace tetfront
