#pragma once
// A 64-bit hash of bytes, for cache keys and checksums: not for anything that an enemy chooses.
//
//     Hash hash;
//     hash.add(tree.depth()).add_range(positions);
//     std::uint64_t key = hash.value();

#include <bit>
#include <cstdint>
#include <cstring>
#include <ranges>
#include <string_view>
#include <type_traits>

namespace tetfront {

class Hash {
 public:
    Hash& add_bytes(const void* data, std::size_t size) {
        const auto* bytes = static_cast<const unsigned char*>(data);
        for (; size >= 8; bytes += 8, size -= 8) mix(word(bytes, 8));
        if (size) mix(word(bytes, size));
        mix(size);
        return *this;
    }
    /// A value without padding.
    template <class T>
    requires(std::has_unique_object_representations_v<T> || std::is_floating_point_v<T>) Hash& add(const T& value) {
        return add_bytes(&value, sizeof value);
    }
    Hash& add(std::string_view text) { return add(text.size()).add_bytes(text.data(), text.size()); }
    /// A contiguous range of trivially copyable values without padding, with its length.
    template <std::ranges::contiguous_range Range>
    requires(!std::is_convertible_v<Range, std::string_view>) Hash& add_range(const Range& values) {
        return add(std::ranges::size(values))
            .add_bytes(std::ranges::data(values), std::ranges::size(values) * sizeof(*std::ranges::data(values)));
    }
    [[nodiscard]] std::uint64_t value() const {
        std::uint64_t h = state_;  // MurmurHash3's finaliser: every bit of the state reaches every bit of the result
        h = (h ^ (h >> 33)) * 0xff51afd7ed558ccd;
        h = (h ^ (h >> 33)) * 0xc4ceb9fe1a85ec53;
        return h ^ (h >> 33);
    }

 private:
    static std::uint64_t word(const unsigned char* bytes, std::size_t size) {
        std::uint64_t w = 0;
        std::memcpy(&w, bytes, size);
        return w;
    }
    void mix(std::uint64_t w) { state_ = std::rotl((state_ ^ w) * 0x9e3779b97f4a7c15, 29) + 0x632be59bd9b4e019; }

    std::uint64_t state_ = 0xcbf29ce484222325;
};

}  // namespace tetfront
