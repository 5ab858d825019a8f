// Where a picture's light is so even that every mean of it is the same.
#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include "graph/extent.h"
#include "graph/light_reach.h"
#include "runtime/row_window.h"

namespace ld {

class SampleSource;
struct SampleStretch;

/// The least and the largest value of each channel of the light (radiance, then light parts) over the valid
/// samples of blocks of 8x1 pixels.
///
/// A pixel that is a weighted mean of samples (graph/light_reach.h) lies between the least and the largest of
/// those in its reach, whatever the network says. Where these are so near one another that their middle m
/// differs from each by at most `within` (1 + |m|), rounding counted, no network has to run: the pixel is m.
/// `within` is so the largest difference in log(1 + x), absolute for dark and relative for bright light. 0:
/// only where all light is 0, whose mean is 0 bit for bit, which that of other equal numbers is not.
///
/// Pixels without samples and, with demodulation, surfaces that reflect, whose light is filtered in two forms
/// (models/demodulation.h), count as even where they are black alone.
class LightRanges {
 public:
  LightRanges(const graph::LightReach& reach, const graph::PictureExtent& picture, int64_t channels,
              double within);

  /// Row y of one sample, and of each of its channels. Different rows at once.
  void begin_row(int64_t y);
  void add(int64_t y, const SampleStretch& row, const graph::LightParts& parts);
  void end_row(int64_t y);

  /// Looks for even blocks when all rows are there. The source says where there are surfaces.
  void find_even(SampleSource& source, int threads);

  /// Of each row the pixels from the first to the last that are not even.
  std::vector<graph::Span> uneven_rows() const;
  /// Writes the even ones outside of uneven_rows() to a row of such channels.
  void fill(int64_t y, PlanarTarget row) const;

  int64_t bytes() const;

 private:
  static constexpr int64_t kBlock = 8;
  struct Range {
    float least = std::numeric_limits<float>::infinity(), largest = -least;
    void include(const Range& other) {
      least = std::min(least, other.least);
      largest = std::max(largest, other.largest);
    }
    float middle() const { return 0.5f * least + 0.5f * largest; }
    /// No light, or no samples.
    bool is_black() const { return least >= largest && (least == 0 || least > largest); }
  };

  size_t block(int64_t y, int64_t b) const { return size_t(y * blocks_ + b); }
  bool is_even(const Range& range) const;
  /// visit(block) for those that the kernels of a block's pixels reach.
  template <class Visit>
  void visit_reach(int64_t y, int64_t b, const Visit& visit) const {
    const int64_t sides = (reach_.radius + kBlock - 1) / kBlock;
    for (int64_t v = std::max<int64_t>(y - reach_.radius, 0);
         v <= std::min(y + reach_.radius, picture_.height - 1); ++v)
      for (int64_t u = std::max<int64_t>(b - sides, 0); u <= std::min(b + sides, blocks_ - 1); ++u)
        visit(block(v, u));
  }
  Range range_around(int64_t y, int64_t b, int64_t channel) const;
  bool is_even_around(int64_t y, int64_t b) const;
  void find_surfaces(SampleSource& source, const PixelTile& tile);
  /// From the first block that is not even to the last.
  graph::Span uneven(int64_t y) const;

  graph::LightReach reach_;
  graph::PictureExtent picture_;
  int64_t channels_, blocks_;
  double within_, rounding_;
  std::vector<Range> ranges_;        // [height, blocks, channels]
  std::vector<uint8_t> drawn_;       // [height, width]: whether a pixel has samples
  std::vector<uint8_t> black_only_;  // [height, blocks]: holes and surfaces
  std::vector<uint8_t> even_;        // [height, blocks]: by itself while rows are read, then with its reach
};

}  // namespace ld
