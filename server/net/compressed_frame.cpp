#include "server/net/compressed_frame.hpp"

#include "engine/base/error.hpp"

#include <array>
#include <cstdint>
#include <cstring>
#include <vector>

#include <meshoptimizer.h>

namespace tetfront {

namespace {

constexpr std::size_t header_bytes = 32, box_bytes = 24, pull_bytes = 28, values_bytes = 12;
constexpr char coloured_type = 4, compressed_type = 5;

using PackedVertex = std::array<std::uint16_t, 4>;  // x, y, z, value: the codec wants multiples of 4 bytes

std::size_t padded(std::size_t size) { return (size + 3) / 4 * 4; }

std::uint32_t count_at(std::string_view bytes, std::size_t offset) {
    std::uint32_t count = 0;
    std::memcpy(&count, bytes.data() + offset, sizeof count);
    return count;
}

/// positions: u16 [count][3]; values: u16 [count], or null.
std::vector<unsigned char> pack(const char* positions, const char* values, std::size_t count) {
    if (count == 0) return {};
    std::vector<PackedVertex> vertices(count);
    for (std::size_t i = 0; i < count; ++i) {
        std::memcpy(vertices[i].data(), positions + 6 * i, 6);
        if (values) std::memcpy(&vertices[i][3], values + 2 * i, 2);
    }
    std::vector<unsigned char> stream(meshopt_encodeVertexBufferBound(count, sizeof(PackedVertex)));
    stream.resize(meshopt_encodeVertexBuffer(stream.data(), stream.size(), vertices.data(), count, sizeof(PackedVertex)));
    ENSURE(!stream.empty(), "meshoptimizer refused ", count, " vertices");
    return stream;
}

void append(std::string& out, const std::vector<unsigned char>& stream) {
    out.append(reinterpret_cast<const char*>(stream.data()), stream.size());
    out.resize(padded(out.size()), '\0');
}

}  // namespace

std::string compress_frame(std::string_view plain) {
    ENSURE(plain.size() >= header_bytes + box_bytes, plain.size());
    const std::size_t surface = count_at(plain, 12), front = count_at(plain, 24), pulls = pull_bytes * count_at(plain, 28);
    const std::size_t surface_at = header_bytes + box_bytes, front_at = surface_at + padded(6 * surface),
                      pulls_at = front_at + padded(6 * front), values_at = pulls_at + pulls;
    const bool coloured = plain[0] == coloured_type;
    ENSURE(plain.size() == values_at + (coloured ? values_bytes + padded(2 * surface) : 0), plain.size(), values_at);

    const char* values = coloured ? plain.data() + values_at + values_bytes : nullptr;
    const std::vector<unsigned char> surface_stream = pack(plain.data() + surface_at, values, surface);
    const std::vector<unsigned char> front_stream = pack(plain.data() + front_at, nullptr, front);

    std::string out;
    out.reserve(surface_at + pulls + values_bytes + 8 + padded(surface_stream.size()) + padded(front_stream.size()));
    out.append(plain.substr(0, surface_at));
    out[0] = compressed_type;
    out.append(plain.substr(pulls_at, pulls));
    if (coloured)
        out.append(plain.substr(values_at, values_bytes));
    else
        out.append(values_bytes, '\0');
    const std::array<std::uint32_t, 2> sizes = {static_cast<std::uint32_t>(surface_stream.size()),
                                                static_cast<std::uint32_t>(front_stream.size())};
    out.append(reinterpret_cast<const char*>(sizes.data()), sizeof sizes);
    append(out, surface_stream);
    append(out, front_stream);
    return out;
}

}  // namespace tetfront
