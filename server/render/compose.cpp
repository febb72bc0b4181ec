#include "server/render/compose.hpp"

#include "engine/base/error.hpp"
#include "engine/base/parallel.hpp"

#include <algorithm>
#include <array>
#include <vector>

namespace tetfront {

namespace {

/// [4 * width] sums over the n x n samples of each pixel of a row.
void add_samples(const Samples& samples, int row, std::vector<std::uint32_t>& sums) {
    const auto n = static_cast<std::size_t>(samples.per_side), width = static_cast<std::size_t>(samples.part.width);
    std::ranges::fill(sums, 0U);
    for (std::size_t k = 0; k < n; ++k) {
        const std::uint8_t* sample = &samples.rgba[(static_cast<std::size_t>(row) * n + k) * width * n * 4];
        if (n == 2) {  // what pictures are made with unless asked otherwise
            for (std::size_t x = 0; x < width; ++x, sample += 8)
                for (std::size_t c = 0; c < 4; ++c) sums[4 * x + c] += static_cast<std::uint32_t>(sample[c]) + sample[c + 4];
        } else {
            for (std::size_t x = 0; x < width; ++x)
                for (std::size_t i = 0; i < n; ++i, sample += 4)
                    for (std::size_t c = 0; c < 4; ++c) sums[4 * x + c] += sample[c];
        }
    }
}

void put(std::uint8_t* out, int channels, const std::array<std::uint32_t, 4>& premultiplied) {
    const std::uint32_t alpha = premultiplied[3];
    for (std::size_t c = 0; c < 3; ++c)
        out[c] = static_cast<std::uint8_t>(channels == 3 || alpha == 255 ? premultiplied[c]
                                           : alpha == 0 ? 0 : std::min(255U, (premultiplied[c] * 255 + alpha / 2) / alpha));
    if (channels == 4) out[3] = static_cast<std::uint8_t>(alpha);
}

}  // namespace

void compose(const PixelBox& tile, std::span<const std::uint8_t> backdrop, const Samples& samples, Image& image) {
    const PixelBox& part = samples.part;
    const auto n = static_cast<std::uint32_t>(samples.per_side), full = 255 * n * n;
    ENSURE(backdrop.size() == static_cast<std::size_t>(tile.width) * static_cast<std::size_t>(tile.height) * 4, "backdrop of ", backdrop.size());
    ENSURE(part.empty() || samples.rgba.size() == static_cast<std::size_t>(part.width) * static_cast<std::size_t>(part.height) * n * n * 4,
           samples.rgba.size(), " bytes of samples");
    parallel_for(static_cast<std::size_t>(tile.height), 32, [&](std::size_t begin, std::size_t end) {
        std::vector<std::uint32_t> sums(4 * static_cast<std::size_t>(std::max(0, part.width)));
        for (int row = static_cast<int>(begin); row < static_cast<int>(end); ++row) {
            const std::uint8_t* behind = &backdrop[static_cast<std::size_t>(row) * static_cast<std::size_t>(tile.width) * 4];
            std::uint8_t* out = image.pixel(tile.x, image.height - 1 - tile.y - row);
            for (int x = 0; x < tile.width; ++x)
                put(out + x * image.channels, image.channels, {behind[4 * x], behind[4 * x + 1], behind[4 * x + 2], behind[4 * x + 3]});
            const int over = tile.y + row - part.y;
            if (over < 0 || over >= part.height) continue;
            add_samples(samples, over, sums);
            behind += 4 * (part.x - tile.x), out += image.channels * (part.x - tile.x);
            for (int x = 0; x < part.width; ++x, behind += 4, out += image.channels) {
                const std::uint32_t* sum = &sums[4 * static_cast<std::size_t>(x)];
                if (sum[3] == 0) continue;
                std::array<std::uint32_t, 4> mixed{};
                for (std::size_t c = 0; c < 4; ++c)
                    mixed[c] = (255 * sum[c] + (full - sum[3]) * behind[c] + full / 2) / full;
                put(out, image.channels, mixed);
            }
        }
    });
}

}  // namespace tetfront
