#pragma once
// The words on a picture: title, time, size of the front and error estimate on top, the meaning of the colours below.
// Sizes follow the picture's height; a part for which a small picture has no room is left out.

#include "engine/simulation/frame.hpp"
#include "server/render/image.hpp"
#include "server/render/text.hpp"
#include "server/render/view.hpp"

#include <memory>
#include <string>

namespace tetfront {

class Legend {
 public:
    /// Loads the font on first use; throws InputError when it is missing.
    void draw(Image& image, const Frame& frame, const View& view, const std::string& title);

 private:
    std::unique_ptr<TextPainter> painter_;
};

/// "1,234,567"
std::string with_thousands(std::uint64_t number);

}  // namespace tetfront
