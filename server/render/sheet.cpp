#include "server/render/sheet.hpp"

#include "engine/base/error.hpp"

#include <algorithm>

namespace tetfront {

Image contact_sheet(const std::vector<Image>& images, int columns, int gap) {
    ENSURE(!images.empty() && columns >= 1, "images ", images.size(), " columns ", columns);
    const int width = images[0].width, height = images[0].height, count = static_cast<int>(images.size());
    columns = std::min(columns, count);
    const int rows = (count + columns - 1) / columns;
    Image sheet(columns * width + (columns - 1) * gap, rows * height + (rows - 1) * gap, 3);
    std::ranges::fill(sheet.pixels, std::uint8_t{255});
    for (int i = 0; i < count; ++i) {
        const Image& image = images[static_cast<std::size_t>(i)];
        ENSURE(image.width == width && image.height == height && image.channels == 3, "image ", i, " differs");
        const int x = i % columns * (width + gap), y = i / columns * (height + gap);
        for (int row = 0; row < height; ++row)
            std::copy_n(image.pixels.begin() + std::ptrdiff_t{row} * 3 * width, 3 * width, sheet.pixel(x, y + row));
    }
    return sheet;
}

}  // namespace tetfront
