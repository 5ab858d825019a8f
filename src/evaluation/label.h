// A line of text as a picture.
#pragma once

#include <optional>
#include <string>

#include "frame/frame.h"

namespace ld {

constexpr int kLabelHeight = 18;

/// White text on dark grey, [3, 18, width], in linear radiance that the tone map turns into those shades;
/// text that is too long is cut. Nothing when this machine has no font, or when width is below 40 pixels,
/// where no name could be read. Throws Error where the module that draws text (frame/picture_formats.h) is
/// missing.
std::optional<Image> render_label(const std::string& text, int width);

}  // namespace ld
