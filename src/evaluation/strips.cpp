#include "evaluation/strips.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "evaluation/label.h"
#include "frame/frame_file.h"

namespace ld {
namespace {

constexpr int kSeparator = 2;  // pixels
constexpr float kGrey = 0.2F;  // linear; shown as a mid grey that neither dark nor bright pictures hide
constexpr size_t kComparisonRows = 4;

Image grey_canvas(int width, int height) {
  Image canvas(width, height, 3);
  std::fill(canvas.pixels.begin(), canvas.pixels.end(), kGrey);
  return canvas;
}

void paste(const Image& image, int left, int top, Image& canvas) {
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) canvas.at(c, left + x, top + y) = image.at(c, x, y);
}

/// Magenta, as if it were a colour: black would hide a broken pixel.
void mark_not_finite(Image& image) {
  for (size_t i = 0; i < image.plane_size(); ++i) {
    float &red = image.plane(0)[i], &green = image.plane(1)[i], &blue = image.plane(2)[i];
    if (std::isfinite(red) && std::isfinite(green) && std::isfinite(blue)) continue;
    red = blue = 2;
    green = 0;
  }
}

}  // namespace

bool is_evenly_chosen(size_t frame, size_t count, size_t chosen) {
  const size_t rows = std::min(chosen, count);
  for (size_t row = 0; row < rows; ++row)
    if (row * count / rows == frame) return true;
  return false;
}

Image make_strip(const std::vector<LabelledPicture>& pictures) {
  if (pictures.empty()) fail("a strip of no pictures");
  const Image& first = pictures.front().image;
  for (const LabelledPicture& picture : pictures)
    if (picture.image.width != first.width || picture.image.height != first.height ||
        picture.image.channels != 3)
      fail("a strip needs pictures of one size: {} is {}x{}, {} is {}x{}", pictures.front().label,
           first.width, first.height, picture.label, picture.image.width, picture.image.height);

  const int label_height = render_label(pictures.front().label, first.width) ? kLabelHeight : 0;
  const int count = static_cast<int>(pictures.size());
  Image strip = grey_canvas(count * (first.width + kSeparator) - kSeparator, first.height + label_height);
  for (int i = 0; i < count; ++i) {
    const LabelledPicture& picture = pictures[size_t(i)];
    const int left = i * (first.width + kSeparator);
    if (const auto label = render_label(picture.label, first.width)) paste(*label, left, 0, strip);
    Image shown = picture.image;
    mark_not_finite(shown);
    paste(shown, left, label_height, strip);
  }
  return strip;
}

Image stack_strips(const std::vector<Image>& strips) {
  if (strips.empty()) fail("a stack of no strips");
  int width = 0, height = -kSeparator;
  for (const Image& strip : strips) {
    width = std::max(width, strip.width);
    height += strip.height + kSeparator;
  }
  Image stack = grey_canvas(width, height);
  int top = 0;
  for (const Image& strip : strips) {
    paste(strip, 0, top, stack);
    top += strip.height + kSeparator;
  }
  return stack;
}

StripWriter::StripWriter(std::filesystem::path folder, size_t frame_count)
    : folder_(std::move(folder)), frame_count_(frame_count) {}

void StripWriter::add(size_t frame, const std::string& name, const std::vector<LabelledPicture>& pictures) {
  Image strip = make_strip(pictures);
  write_image(path_of(name), strip);
  if (is_evenly_chosen(frame, frame_count_, kComparisonRows)) chosen_.push_back(std::move(strip));
}

std::filesystem::path StripWriter::finish() const {
  std::filesystem::path path = folder_ / "comparison.png";
  write_image(path, stack_strips(chosen_));
  return path;
}

}  // namespace ld
