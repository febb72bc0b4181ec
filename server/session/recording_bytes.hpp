#pragma once
// The bytes of a recording's chunks: plain values one after another, and compressed arrays. Only for recording*.cpp.
//
//     PayloadWriter out;                                      PayloadReader in(payload, "run.tfr");
//     out.put(time); out.put_array(std::span(triangles));     in.get<double>(); in.get_array<Triangle>();

#include "engine/base/error.hpp"
#include "engine/base/hash.hpp"
#include "engine/simulation/frame.hpp"
#include "server/session/recording.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include <meshoptimizer.h>

namespace tetfront::recording {

enum Kind : std::uint32_t { info = 1, model = 2, topology = 3, frame = 4, end = 5, event = 6 };

struct FileHeader {
    std::array<char, 8> magic = {'t', 'e', 't', 'f', 'r', 'o', 'n', 't'};
    std::uint32_t version = recording_version, zero = 0;
};
static_assert(sizeof(FileHeader) == 16);

struct ChunkHeader {
    std::uint32_t kind = 0, zero = 0;
    std::uint64_t size = 0, checksum = 0;
};
static_assert(sizeof(ChunkHeader) == 24);

inline constexpr std::uint64_t largest_payload = std::uint64_t{1} << 30;

inline Hash checksum_of(std::uint32_t kind, std::uint64_t size) { return Hash().add(kind).add(size); }

/// x, y, z in steps of the recording, and something beside it.
struct PackedPoint {
    std::array<std::int32_t, 3> at;
    std::uint32_t value;
};
struct PackedEdge {
    std::uint32_t a, b, level;
};
struct PackedPiece {
    std::array<std::uint32_t, 4> corners;
    std::uint32_t level;
    float young;
};
constexpr std::int32_t not_finite = std::numeric_limits<std::int32_t>::min();

class PayloadWriter {
 public:
    template <class T>
    requires std::is_arithmetic_v<T> || std::is_enum_v<T>
    void put(T value) { append(&value, sizeof value); }
    template <class T, std::size_t N>
    void put(const std::array<T, N>& values) { append(values.data(), sizeof values); }
    void put(std::string_view text) {
        put(static_cast<std::uint32_t>(text.size()));
        append(text.data(), text.size());
    }
    template <class T>
    void put_array(std::span<const T> values) {
        static_assert(std::is_trivially_copyable_v<T> && sizeof(T) % 4 == 0 && sizeof(T) <= 256);
        put(static_cast<std::uint32_t>(values.size()));
        std::vector<unsigned char> coded(meshopt_encodeVertexBufferBound(values.size(), sizeof(T)));
        const std::size_t size =
            values.empty() ? 0
                           : meshopt_encodeVertexBuffer(coded.data(), coded.size(), values.data(), values.size(), sizeof(T));
        ENSURE(size > 0 || values.empty(), "meshoptimizer refused ", values.size(), " elements");
        put(static_cast<std::uint32_t>(size));
        append(coded.data(), size);
    }
    [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
    void append(const void* data, std::size_t size) { bytes_.append(static_cast<const char*>(data), size); }
    std::string bytes_;
};

/// Throws InputError for whatever does not fit.
class PayloadReader {
 public:
    PayloadReader(std::string_view bytes, const std::string& source) : bytes_(bytes), source_(source) {}

    template <class T>
    requires std::is_arithmetic_v<T>
    T get() {
        T value;
        std::memcpy(&value, take(sizeof value).data(), sizeof value);
        return value;
    }
    template <class T, std::size_t N>
    std::array<T, N> get_all() {
        std::array<T, N> values;
        std::memcpy(values.data(), take(sizeof values).data(), sizeof values);
        return values;
    }
    std::string get_text(std::size_t longest) {
        const auto length = get<std::uint32_t>();
        check(length <= longest, "a text is too long");
        return std::string(take(length));
    }
    template <class T>
    std::vector<T> get_array() {
        const auto count = get<std::uint32_t>(), size = get<std::uint32_t>();
        const std::string_view coded = take(size);
        // The codec spends at least 2 bits on 16 bytes: what claims to hold more is no reason to reserve memory.
        check(std::uint64_t{count} * sizeof(T) <= 64 * (std::uint64_t{size} + 1024), "an array claims to be too long");
        std::vector<T> values(count);
        if (count == 0) return values;
        const int error = meshopt_decodeVertexBuffer(values.data(), count, sizeof(T),
                                                     reinterpret_cast<const unsigned char*>(coded.data()), coded.size());
        check(error == 0, "an array is not as its codec makes it");
        return values;
    }
    void finish() const { check(bytes_.empty(), "a chunk is longer than its contents"); }
    void check(bool good, const char* problem) const {
        if (!good) throw InputError(source_, "recording", problem, "record it again");
    }

 private:
    std::string_view take(std::size_t size) {
        check(size <= bytes_.size(), "a chunk is shorter than its contents");
        const std::string_view part = bytes_.substr(0, size);
        bytes_.remove_prefix(size);
        return part;
    }

    std::string_view bytes_;
    const std::string& source_;
};

/// Where positions of a model are counted from, and the length of a step [m].
struct Grid {
    std::array<double, 3> origin{};
    double step = 1;

    explicit Grid(const std::array<float, 6>& box) {
        double longest = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            origin[i] = static_cast<double>(box[i]);
            longest = std::max(longest, static_cast<double>(box[i + 3]) - origin[i]);
        }
        step = longest > 0 && std::isfinite(longest) ? longest / (1 << 20) : 1e-6;
    }
    [[nodiscard]] std::array<std::int32_t, 3> pack(const std::array<float, 3>& p) const {
        std::array<std::int32_t, 3> packed{};
        for (std::size_t i = 0; i < 3; ++i) {
            const double x = std::round((static_cast<double>(p[i]) - origin[i]) / step);
            // Farther than two thousand times the object's size: as far as goes.
            packed[i] = std::isnan(x) ? not_finite : static_cast<std::int32_t>(std::clamp(x, -2147483647.0, 2147483647.0));
        }
        return packed;
    }
    [[nodiscard]] std::array<float, 3> unpack(const std::array<std::int32_t, 3>& p) const {
        std::array<float, 3> x{};
        for (std::size_t i = 0; i < 3; ++i)
            x[i] = p[i] == not_finite ? std::numeric_limits<float>::quiet_NaN()
                                      : static_cast<float>(origin[i] + step * p[i]);
        return x;
    }
};

}  // namespace tetfront::recording
