#include "runtime/light_ranges.h"

#include <algorithm>
#include <cmath>

#include "models/network_numbers.h"
#include "runtime/parallel.h"
#include "runtime/sample_source.h"
#include "runtime/step.h"

namespace ld {
namespace {

constexpr double kLargestEven = 1e30;  // beyond, filters scale their values (Light::value_scale)

}  // namespace

LightRanges::LightRanges(const graph::LightReach& reach, const graph::PictureExtent& picture,
                         int64_t channels, double within)
    : reach_(reach),
      picture_(picture),
      channels_(channels),
      blocks_((picture.width + kBlock - 1) / kBlock),
      within_(within),
      // Numbers above and below the line, each rounded by half a unit of 2^-23 with every addition: those of
      // the filters, those over samples, and 64 for partition, compositor and modulation.
      rounding_(double(reach.additions * reach.layers * (reach.samples ? picture.samples : 1) +
                       2 * picture.samples + 64) *
                std::exp2(-23)),
      ranges_(size_t(picture.height * blocks_ * channels)),
      drawn_(size_t(picture.height * picture.width)),
      black_only_(size_t(picture.height * blocks_)),
      even_(black_only_.size()) {}

int64_t LightRanges::bytes() const {
  return int64_t(ranges_.size() * sizeof(Range) + drawn_.size() + black_only_.size() + even_.size());
}

void LightRanges::begin_row(int64_t y) {
  std::fill_n(ranges_.begin() + y * blocks_ * channels_, blocks_ * channels_, Range());
  std::fill_n(even_.begin() + y * blocks_, blocks_, uint8_t{1});
  std::fill_n(drawn_.begin() + y * picture_.width, picture_.width, uint8_t{0});
}

void LightRanges::add(int64_t y, const SampleStretch& row, const graph::LightParts& parts) {
  std::vector<const float*> planes;
  planes.reserve(size_t(channels_));
  for (int c = 0; c < 3; ++c) planes.push_back(row.plane(kRadianceOffset + c));
  for (size_t part = 0; part < size_t(parts.colours); ++part)
    for (int c = 0; c < 3; ++c) planes.push_back(row.part(part, c));
  if (parts.alpha) planes.push_back(row.alpha());
  const uint8_t* valid = row.valid();
  uint8_t* drawn = drawn_.data() + y * picture_.width;
  for (int64_t b = 0; b < blocks_; ++b) {
    // Most blocks have noise, and are done with their first sample.
    if (even_[block(y, b)] == 0) continue;
    Range* ranges = &ranges_[block(y, b) * size_t(channels_)];
    const int64_t first = b * kBlock, end = std::min(first + kBlock, picture_.width);
    for (int64_t x = first; x < end; ++x) drawn[x] = uint8_t(drawn[x] | valid[x]);
    for (size_t c = 0; c < planes.size(); ++c)
      for (int64_t x = first; x < end; ++x)
        if (valid[x] != 0) ranges[c].include({planes[c][x], planes[c][x]});
    even_[block(y, b)] = uint8_t(is_even(ranges[0]) && is_even(ranges[1]) && is_even(ranges[2]));
  }
}

void LightRanges::end_row(int64_t y) {
  const uint8_t* drawn = drawn_.data() + y * picture_.width;
  for (int64_t b = 0; b < blocks_; ++b)
    black_only_[block(y, b)] = uint8_t(
        std::count(drawn + b * kBlock, drawn + std::min((b + 1) * kBlock, picture_.width), uint8_t{0}) > 0);
}

bool LightRanges::is_even(const Range& range) const {
  if (range.is_black()) return true;
  const double largest = std::max(std::fabs(range.least), std::fabs(range.largest));
  const double half = (double(range.largest) - double(range.least)) / 2;
  return largest <= kLargestEven &&
         half + rounding_ * largest <= within_ * (1 + std::fabs(double(range.middle())));
}

LightRanges::Range LightRanges::range_around(int64_t y, int64_t b, int64_t channel) const {
  Range range;
  visit_reach(y, b, [&](size_t at) { range.include(ranges_[at * size_t(channels_) + size_t(channel)]); });
  return range;
}

bool LightRanges::is_even_around(int64_t y, int64_t b) const {
  if (even_[block(y, b)] == 0) return false;  // of its own
  bool black = true;
  for (int64_t c = 0; c < channels_; ++c) {
    const Range range = range_around(y, b, c);
    if (!is_even(range)) return false;
    black = black && range.is_black();
  }
  if (black) return true;
  bool any = false;
  visit_reach(y, b, [&](size_t at) { any = any || black_only_[at] != 0; });
  return !any;
}

void LightRanges::find_even(SampleSource& source, int threads) {
  const auto find = [&] {
    parallel_for(threads, picture_.height, [&](int64_t y, int) {
      for (int64_t b = 0; b < blocks_; ++b) even_[block(y, b)] = uint8_t(is_even_around(y, b));
    });
  };
  find();
  if ((!reach_.albedo && !reach_.specular) || std::count(even_.begin(), even_.end(), uint8_t{1}) == 0) return;
  // Whether there are surfaces is asked only where it matters: in the reach of what seems even.
  std::vector<uint8_t> asked(even_.size());
  for (int64_t y = 0; y < picture_.height; ++y)
    for (int64_t b = 0; b < blocks_; ++b)
      if (even_[block(y, b)] != 0) visit_reach(y, b, [&](size_t at) { asked[at] = 1; });
  for_each_stretch(threads, 0, picture_.height, picture_.width, kTilePixels,
                   [&](int64_t y, int64_t x, int64_t count, int thread) {
                     const auto first = asked.begin() + y * blocks_ + x / kBlock;
                     if (std::count(first, first + (count + kBlock - 1) / kBlock, uint8_t{1}) > 0)
                       find_surfaces(source, {y, x, count, thread});
                   });
  find();
}

void LightRanges::find_surfaces(SampleSource& source, const PixelTile& tile) {
  for (int s = 0; s < int(picture_.samples); ++s) {
    const SampleStretch from = source.read(s, tile);
    for (const char* name : {"albedo", "specular"}) {
      const int place = find_feature(name).offset;
      if (place >= from.frame->channels || !(name[0] == 'a' ? reach_.albedo : reach_.specular)) continue;
      for (int c = 0; c < 3; ++c)
        for (int64_t x = 0; x < tile.count; ++x)
          // Half, as albedo and specular add up.
          if (from.plane(place + c)[x] > float(kNoReflectance / 2))
            black_only_[block(tile.y, (tile.x + x) / kBlock)] = 1;
    }
  }
}

graph::Span LightRanges::uneven(int64_t y) const {
  const auto begin = even_.begin() + y * blocks_, end = begin + blocks_;
  const auto first = std::find(begin, end, uint8_t{0});
  if (first == end) return {};
  auto last = end;
  while (*(last - 1) != 0) --last;
  return {(first - begin) * kBlock, std::min((last - begin) * kBlock, picture_.width)};
}

std::vector<graph::Span> LightRanges::uneven_rows() const {
  std::vector<graph::Span> rows;
  for (int64_t y = 0; y < picture_.height; ++y) rows.push_back(uneven(y));
  return rows;
}

void LightRanges::fill(int64_t y, PlanarTarget row) const {
  const graph::Span left = uneven(y);
  for (int64_t b = 0; b < blocks_; ++b) {
    const int64_t first = b * kBlock, end = std::min(first + kBlock, picture_.width);
    if (left.meets(first, end - first)) continue;
    for (int64_t c = 0; c < channels_; ++c) {
      const Range range = range_around(y, b, c);
      std::fill(row.plane(c) + first, row.plane(c) + end, range.is_black() ? 0.0f : range.middle());
    }
  }
}

}  // namespace ld
