#include "evaluation/label.h"

#include <vector>

#include "frame/picture_formats.h"

namespace ld {
namespace {

constexpr int kFontSize = 12, kBaseline = 13, kMargin = 4, kNarrowest = 40;
constexpr float kGround = 0.02F;   // shown as dark grey, 15 % of white
constexpr float kText = 1.71828F;  // e - 1: where the tone map reaches white

}  // namespace

std::optional<Image> render_label(const std::string& text, int width) {
  if (width < kNarrowest) return std::nullopt;
  const std::vector<float> letters =
      picture_formats().draw_text(text, width, kLabelHeight, kFontSize, kMargin, kBaseline);
  if (letters.empty()) return std::nullopt;

  Image label(width, kLabelHeight, 3);
  for (int c = 0; c < 3; ++c)
    for (size_t p = 0; p < letters.size(); ++p)
      label.plane(c)[p] = letters[p] * kText + (1 - letters[p]) * kGround;
  return label;
}

}  // namespace ld
