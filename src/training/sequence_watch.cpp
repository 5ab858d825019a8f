#include "training/sequence_watch.h"

#include <algorithm>

namespace ld {

Image shrunk(const Image& image, int factor) {
  Image small((image.width + factor - 1) / factor, (image.height + factor - 1) / factor, image.channels);
  for (int c = 0; c < image.channels; ++c)
    for (int y = 0; y < small.height; ++y)
      for (int x = 0; x < small.width; ++x) {
        const int right = std::min((x + 1) * factor, image.width),
                  bottom = std::min((y + 1) * factor, image.height);
        double sum = 0;
        for (int v = y * factor; v < bottom; ++v)
          for (int u = x * factor; u < right; ++u) sum += image.at(c, u, v);
        small.at(c, x, y) = static_cast<float>(sum / ((right - x * factor) * (bottom - y * factor)));
      }
  return small;
}

void SequenceWatch::add(const SurfaceGuides& guides, const Image& noisy, const Image& denoised,
                        const Image& reference, bool keep) {
  ground_.advance(guides, reference);
  noisy_.add(ground_, noisy);
  denoised_.add(ground_, denoised);
  if (!keep || kept_.size() == static_cast<size_t>(kStripFrames)) return;
  const int factor = (std::max(noisy.width, noisy.height) + kStripSide - 1) / kStripSide;
  kept_.push_back({shrunk(noisy, factor), shrunk(denoised, factor), shrunk(reference, factor)});
}

std::vector<double> SequenceWatch::finish() {
  std::vector<double> values = denoised_.scores(ground_, noisy_).values;
  ground_ = {};
  noisy_ = {};
  denoised_ = {};
  return values;
}

Image SequenceWatch::strip() const {
  if (kept_.empty()) return {};
  const int width = kept_[0][0].width, height = kept_[0][0].height;
  Image strip(width * static_cast<int>(kept_.size()), 3 * height, 3);
  for (size_t frame = 0; frame < kept_.size(); ++frame)
    for (int row = 0; row < 3; ++row)
      for (int c = 0; c < 3; ++c)
        for (int y = 0; y < height; ++y)
          std::copy_n(&kept_[frame][static_cast<size_t>(row)].plane(c)[y * width], width,
                      &strip.at(c, static_cast<int>(frame) * width, row * height + y));
  return strip;
}

}  // namespace ld
