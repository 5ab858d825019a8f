#include "evaluation/label.h"

#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>

#include <algorithm>
#include <vector>

namespace ld {
namespace {

constexpr int kFontSize = 12, kBaseline = 13, kMargin = 4, kNarrowest = 40;
constexpr float kGround = 0.02F;   // shown as dark grey, 15 % of white
constexpr float kText = 1.71828F;  // e - 1: where the tone map reaches white

}  // namespace

std::optional<Image> render_label(const std::string& text, int width) {
  if (width < kNarrowest) return std::nullopt;
  OIIO::ImageBuf canvas(OIIO::ImageSpec(width, kLabelHeight, 1, OIIO::TypeDesc::FLOAT));
  OIIO::ImageBufAlgo::fill(canvas, {kGround});
  // OpenImageIO looks these up in the system's font folders; the first is Debian's fonts-dejavu-core.
  const std::vector<std::string> fonts = {"DejaVuSans", "LiberationSans-Regular", "DroidSans", "FreeSans"};
  const bool done = std::any_of(fonts.begin(), fonts.end(), [&](const std::string& font) {
    const bool found =
        OIIO::ImageBufAlgo::render_text(canvas, kMargin, kBaseline, text, kFontSize, font, {kText});
    if (!found) canvas.geterror();  // taken, or OpenImageIO prints it when the canvas dies
    return found;
  });
  if (!done) return std::nullopt;

  Image label(width, kLabelHeight, 3);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < kLabelHeight; ++y)
      for (int x = 0; x < width; ++x) label.at(c, x, y) = canvas.getchannel(x, y, 0, 0);
  return label;
}

}  // namespace ld
