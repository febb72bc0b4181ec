#pragma once
// Several pictures on one: columns and rows with a gap between.
//
//     write_atomically("sheet.png", encode_png(contact_sheet({left, right}, 2), {.level = 9}));

#include "server/render/image.hpp"

#include <vector>

namespace tetfront {

/// RGB images of one size, at least one, row by row on white. gap: [pixels] between neighbours. columns >= 1.
Image contact_sheet(const std::vector<Image>& images, int columns, int gap = 6);

}  // namespace tetfront
