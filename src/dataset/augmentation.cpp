#include "dataset/augmentation.h"

#include <algorithm>

#include "core/error.h"

namespace ld {
namespace {

/// Where each pixel of the result comes from.
class PixelMap {
 public:
  PixelMap(const Augmentation& a, int width, int height) : a_(a), width_(width) {
    if (a.width < 1 || a.height < 1 || a.x < 0 || a.y < 0 || a.x + a.width > width || a.y + a.height > height)
      fail("a crop of {}x{} at ({}, {}) does not lie inside a frame of {}x{}", a.width, a.height, a.x, a.y,
           width, height);
  }

  int result_width() const { return a_.quarter_turns % 2 == 0 ? a_.width : a_.height; }
  int result_height() const { return a_.quarter_turns % 2 == 0 ? a_.height : a_.width; }

  /// Index into a source plane for the pixel (x, y) of the result: the steps undone in reverse.
  size_t source(int x, int y) const {
    int w = result_width(), h = result_height();
    for (int turn = 0; turn < a_.quarter_turns; ++turn) {
      // A counterclockwise turn moved (x, y) of a picture h wide to (y, h - 1 - x).
      const int before_x = h - 1 - y;
      y = x;
      x = before_x;
      std::swap(w, h);
    }
    if (a_.flip_y) y = h - 1 - y;
    if (a_.flip_x) x = w - 1 - x;
    return static_cast<size_t>(a_.y + y) * static_cast<size_t>(width_) + static_cast<size_t>(a_.x + x);
  }

  template <class Source, class Result>
  void copy(const Source* source_plane, Result* result) const {
    for (int y = 0; y < result_height(); ++y)
      for (int x = 0; x < result_width(); ++x) *result++ = static_cast<Result>(source_plane[source(x, y)]);
  }

 private:
  Augmentation a_;
  int width_;
};

/// Turns the vectors of one feature of one sample, given as the planes of their x and y.
void turn_vectors(Vector kind, const Augmentation& a, float* vx, float* vy, size_t count) {
  // Work with +y up; a counterclockwise turn takes (x, y) to (-y, x).
  const float up = kind == Vector::y_down ? -1.0F : 1.0F;
  for (size_t i = 0; i < count; ++i) {
    float x = vx[i], y = up * vy[i];
    if (a.flip_x) x = -x;
    if (a.flip_y) y = -y;
    for (int turn = 0; turn < a.quarter_turns; ++turn) {
      const float turned = -y;
      y = x;
      x = turned;
    }
    // Adding 0 turns -0 into 0, so that four turns give back the same bits.
    vx[i] = x + 0.0F;
    vy[i] = up * y + 0.0F;
  }
}

}  // namespace

HalfFrame to_half(const Frame& frame) {
  HalfFrame result;
  result.width = frame.width;
  result.height = frame.height;
  result.spp = frame.spp;
  result.samples.assign(frame.samples.begin(), frame.samples.end());
  // Frames made in memory may exceed half's range, which files never do.
  for (Imath::half& value : result.samples)
    if (value.isInfinity()) value = value.isNegative() ? -kEscapedDepth : kEscapedDepth;
  result.valid = frame.valid;
  result.info = frame.info;
  return result;
}

Frame augment(const HalfFrame& frame, const Augmentation& augmentation) {
  const PixelMap map(augmentation, frame.width, frame.height);
  Frame result(map.result_width(), map.result_height(), frame.spp);
  result.info = frame.info;
  const size_t pixels = static_cast<size_t>(frame.width) * static_cast<size_t>(frame.height);
  for (int s = 0; s < frame.spp; ++s) {
    map.copy(frame.valid.data() + static_cast<size_t>(s) * pixels, result.valid_plane(s));
    for (int c = 0; c < kSampleChannels; ++c)
      map.copy(
          frame.samples.data() + (static_cast<size_t>(s) * kSampleChannels + static_cast<size_t>(c)) * pixels,
          result.plane(s, c));
    for (const Feature& feature : feature_schema())
      if (feature.vector != Vector::none)
        turn_vectors(feature.vector, augmentation, result.plane(s, feature.offset),
                     result.plane(s, feature.offset + 1), result.plane_size());
  }
  return result;
}

Image augment(const Image& image, const Augmentation& augmentation) {
  const PixelMap map(augmentation, image.width, image.height);
  Image result(map.result_width(), map.result_height(), image.channels);
  for (int c = 0; c < image.channels; ++c) map.copy(image.plane(c), result.plane(c));
  return result;
}

Augmentation random_augmentation(RandomStream& stream, int width, int height, int size, bool flips,
                                 bool rotations) {
  Augmentation a;
  a.width = std::min(size, width);
  a.height = std::min(size, height);
  a.x = static_cast<int>(stream.below(static_cast<uint32_t>(width - a.width + 1)));
  a.y = static_cast<int>(stream.below(static_cast<uint32_t>(height - a.height + 1)));
  if (flips) {
    a.flip_x = stream.below(2) == 1;
    a.flip_y = stream.below(2) == 1;
  }
  if (rotations) a.quarter_turns = static_cast<int>(stream.below(4));
  return a;
}

}  // namespace ld
