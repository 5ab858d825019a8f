#include "dataset/crop.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/error.h"
#include "core/tone_map.h"
#include "frame/encoding.h"
#include "frame/half_rows.h"

namespace ld {
namespace {

/// Where each pixel of a frame goes in the planes of the result: an affine map.
class PixelMap {
 public:
  PixelMap(const Augmentation& a, const PackedFrame& frame) : x0_(a.x), y0_(a.y) {
    if (a.width < 1 || a.height < 1 || a.x < 0 || a.y < 0 || a.x + a.width > frame.width ||
        a.y + a.height > frame.height)
      fail("a crop of {}x{} at ({}, {}) does not lie inside a frame of {}x{}", a.width, a.height, a.x, a.y,
           frame.width, frame.height);
    origin_ = place(a, 0, 0);
    step_x_ = place(a, 1, 0) - origin_;
    step_y_ = place(a, 0, 1) - origin_;
  }

  /// Writes a rectangle of pixels, whose first is (x, y), from rows that are kTileSide apart: along the rows
  /// of the result, since `plane` is far larger than the tile.
  void put(const float* tile, int columns, int rows, int x, int y, float* plane) const {
    float* out = plane + origin_ + (x - x0_) * step_x_ + (y - y0_) * step_y_;
    if (step_x_ == 1)
      for (std::ptrdiff_t j = 0; j < rows; ++j) std::copy_n(tile + j * kTileSide, columns, out + j * step_y_);
    else if (step_x_ == -1)
      for (std::ptrdiff_t j = 0; j < rows; ++j)
        copy_reversed(tile + j * kTileSide, 1, columns, out + j * step_y_);
    else if (step_y_ == 1)
      for (int i = 0; i < columns; ++i) copy_strided(tile + i, kTileSide, rows, out + i * step_x_);
    else
      for (int i = 0; i < columns; ++i) copy_reversed(tile + i, kTileSide, rows, out + i * step_x_);
  }

 private:
  static std::ptrdiff_t place(const Augmentation& a, int x, int y) {
    int width = a.width, height = a.height;
    if (a.flip_x) x = width - 1 - x;
    if (a.flip_y) y = height - 1 - y;
    for (int turn = 0; turn < a.quarter_turns; ++turn) {
      // A counterclockwise turn: the right column becomes the top row.
      y = std::exchange(x, y);
      y = width - 1 - y;
      std::swap(width, height);
    }
    return std::ptrdiff_t{y} * width + x;
  }

  static void copy_strided(const float* values, int stride, int count, float* out) {
    for (std::ptrdiff_t i = 0; i < count; ++i) out[i] = values[i * stride];
  }
  static void copy_reversed(const float* values, int stride, int count, float* out) {
    for (std::ptrdiff_t i = 0; i < count; ++i) out[-i] = values[i * stride];
  }

  int x0_, y0_;
  std::ptrdiff_t origin_, step_x_, step_y_;
};

/// Turns the vectors of one feature, given as their x and y.
void turn_vectors(Vector kind, const Augmentation& a, float* vx, float* vy, int count) {
  // Work with +y up; a counterclockwise turn takes (x, y) to (-y, x).
  const float up = kind == Vector::y_down ? -1.0F : 1.0F;
  const float sign_x = a.flip_x ? -1.0F : 1.0F, sign_y = a.flip_y ? -up : up;
  for (int i = 0; i < count; ++i) {
    float x = sign_x * vx[i], y = sign_y * vy[i];
    for (int turn = 0; turn < a.quarter_turns; ++turn) x = -std::exchange(y, x);
    // Adding 0 turns -0 into 0, so that four turns give back the same bits.
    vx[i] = x + 0.0F;
    vy[i] = up * y + 0.0F;
  }
}

/// Frames that run backwards: what moved forth moves back, and what was drawn early was drawn late. The two
/// components of a motion are planes of `count` values.
void reverse_time(const Feature& feature, const uint8_t* valid, float* values, int count) {
  if (feature.name == "motion")
    for (int i = 0; i < 2 * count; ++i) values[i] = 0.0F - values[i];
  if (feature.name == "time")
    for (int i = 0; i < count; ++i) values[i] = valid[i] != 0 ? 1 - values[i] : 0;
}

/// tone_map() of every half float that is not negative: a crop of 128x128 at 8 spp has twelve times as many
/// values as the table.
class ToneMapTable {
 public:
  explicit ToneMapTable(float exposure) : values_(1 << 15) {
    std::vector<uint16_t> bits(values_.size());
    for (size_t i = 0; i < bits.size(); ++i) bits[i] = static_cast<uint16_t>(i);
    half_to_float(bits.data(), values_.data(), bits.size());
    for (float& value : values_) value = tone_map(exposure * value);
  }
  void look_up(const uint16_t* half_bits, float* out, int count) const {
    for (int i = 0; i < count; ++i) out[i] = half_bits[i] < values_.size() ? values_[half_bits[i]] : 0.0F;
  }

  static const std::shared_ptr<const ToneMapTable>& unexposed() {
    static const auto table = std::make_shared<const ToneMapTable>(1.0F);
    return table;
  }

 private:
  std::vector<float> values_;
};

/// A feature in the network's order, and its first channel in the packed frame.
struct Source {
  const Feature* feature;
  int channel;
};

std::vector<Source> sources_of(const PackedFrame& frame, const std::vector<std::string>& features) {
  std::vector<Source> sources;
  for (const std::string& name : features) {
    int channel = 0;
    auto held = frame.features.begin();
    for (; held != frame.features.end() && *held != name; ++held) channel += find_feature(*held).channels;
    if (held == frame.features.end()) fail("the packed frame does not hold the feature '{}'", name);
    sources.push_back({&find_feature(name), channel});
  }
  return sources;
}

/// Of the three channels of what is tone mapped, if anything is.
using ToneMapTables = std::array<std::shared_ptr<const ToneMapTable>, 3>;

ToneMapTables tables_of(const Augmentation& a, const std::vector<Source>& sources) {
  ToneMapTables tables;
  if (std::none_of(sources.begin(), sources.end(),
                   [](const Source& source) { return source.feature->encoding == Encoding::tone_map; }))
    return tables;
  for (size_t c = 0; c < 3; ++c) {
    const float factor = a.exposure[c];
    if (factor == 1)
      tables[c] = ToneMapTable::unexposed();
    else if (c > 0 && factor == a.exposure[c - 1])
      tables[c] = tables[c - 1];
    else
      tables[c] = std::make_shared<const ToneMapTable>(factor);
  }
  return tables;
}

/// Of light or of a surface: a path tracer treats its three channels alike.
bool is_colour(const Feature& feature) {
  return feature.channels == 3 && feature.vector == Vector::none;
}

/// Reads one crop; holds what is the same for all tiles.
class CropReader {
 public:
  CropReader(const PackedFrame& frame, const Augmentation& a, const std::vector<std::string>& features,
             const CropPlanes& planes, const SampleList& samples, const SampleList& targets,
             const SampleList& noisy)
      : frame_(frame),
        a_(a),
        map_(a, frame),
        planes_(planes),
        sources_(sources_of(frame, features)),
        samples_(frame.chosen(samples)),
        targets_(targets.empty() ? targets : frame.chosen(targets)),
        noisy_(noisy.empty() ? noisy : frame.chosen(noisy)),
        tables_(tables_of(a, sources_)),
        plane_(static_cast<size_t>(a.width) * static_cast<size_t>(a.height)),
        values_(static_cast<size_t>(frame.channels()) * kTilePixels) {}

  void read(int tile_x, int tile_y) {
    x0_ = std::max(tile_x * kTileSide, a_.x);
    y0_ = std::max(tile_y * kTileSide, a_.y);
    x1_ = std::min((tile_x + 1) * kTileSide, a_.x + a_.width);
    y1_ = std::min((tile_y + 1) * kTileSide, a_.y + a_.height);
    first_ = (y0_ - tile_y * kTileSide) * kTileSide + x0_ - tile_x * kTileSide;
    const size_t tile =
        static_cast<size_t>(tile_y) * static_cast<size_t>(frame_.tiles_x()) + static_cast<size_t>(tile_x);
    const uint16_t* samples = frame_.samples + tile * frame_.tile_samples();
    const uint8_t* valid = frame_.valid + tile * frame_.tile_valid();
    features_out_ = planes_.features;
    radiance_out_ = planes_.radiance;
    for (size_t i = 0; i < samples_.size(); ++i) {
      const auto s = static_cast<size_t>(samples_[i]);
      read_sample(samples + s * values_.size(), valid + s * kTilePixels);
      std::copy_n(valid + s * kTilePixels, kTilePixels, encoded_.begin());
      put(encoded_.data(), planes_.valid + i * plane_);
    }
    const float* const reference = frame_.reference + tile * PackedFrame::kTileReference;
    put_colours(targets_.empty() ? reference : mean_of(targets_, samples, valid, reference),
                planes_.reference);
    if (!noisy_.empty()) put_colours(mean_of(noisy_, samples, valid, reference), planes_.noisy);
  }

 private:
  void put_colours(const float* colours, float* planes) {
    for (int c = 0; c < 3; ++c)
      put_exposed(colours + tile_plane(colour(c)), c, planes + static_cast<size_t>(c) * plane_);
  }

  const float* mean_of(const SampleList& list, const uint16_t* samples, const uint8_t* valid,
                       const float* otherwise) {
    target_.fill(0);
    drawn_.fill(0);
    for (const int s : list) {
      half_to_float(samples + static_cast<size_t>(s) * values_.size(), values_.data(), target_.size());
      const uint8_t* mask = valid + tile_plane(s);
      for (size_t p = 0; p < kTilePixels; ++p) drawn_[p] += mask[p];
      // The channels of what is not valid are 0.
      for (size_t i = 0; i < target_.size(); ++i) target_[i] += values_[i];
    }
    for (size_t i = 0; i < target_.size(); ++i) {
      const int drawn = drawn_[i % kTilePixels];
      target_[i] = drawn > 0 ? target_[i] / static_cast<float>(drawn) : otherwise[i];
    }
    return target_.data();
  }

  void read_sample(const uint16_t* half_bits, const uint8_t* valid) {
    half_to_float(half_bits, values_.data(), values_.size());
    for (int c = 0; c < 3; ++c, radiance_out_ += plane_)
      put_exposed(values_.data() + tile_plane(colour(c)), c, radiance_out_);
    for (const Source& source : sources_) {
      float* values = values_.data() + tile_plane(source.channel);
      if (source.feature->vector != Vector::none)
        turn_vectors(source.feature->vector, a_, values, values + kTilePixels, kTilePixels);
      if (a_.reversed) reverse_time(*source.feature, valid, values, kTilePixels);
      for (int c = 0; c < source.feature->channels; ++c, features_out_ += plane_) {
        const int from = is_colour(*source.feature) ? colour(c) : c;
        if (source.feature->encoding == Encoding::tone_map)
          tables_[static_cast<size_t>(c)]->look_up(half_bits + tile_plane(source.channel + from),
                                                   encoded_.data(), kTilePixels);
        else
          encode(*source.feature, frame_.depth_scale, values + tile_plane(from), encoded_.data(),
                 kTilePixels);
        put(encoded_.data(), features_out_);
      }
    }
  }

  int colour(int channel) const { return a_.colours[static_cast<size_t>(channel)]; }

  void put(const float* tile, float* plane) const {
    map_.put(tile + first_, x1_ - x0_, y1_ - y0_, x0_, y0_, plane);
  }

  void put_exposed(const float* tile, int channel, float* plane) {
    const float factor = a_.exposure[static_cast<size_t>(channel)];
    if (factor == 1) {
      put(tile, plane);
      return;
    }
    for (size_t p = 0; p < kTilePixels; ++p) encoded_[p] = factor * tile[p];
    put(encoded_.data(), plane);
  }

  const PackedFrame& frame_;
  const Augmentation a_;
  const PixelMap map_;
  const CropPlanes planes_;
  const std::vector<Source> sources_;
  const SampleList samples_, targets_, noisy_;
  const ToneMapTables tables_;  // of each channel
  const size_t plane_;          // floats of a plane of the result
  std::vector<float> values_;   // of all channels of one sample of the tile, in the units of the files
  std::array<float, kTilePixels> encoded_{};
  std::array<float, PackedFrame::kTileReference> target_{};
  std::array<int, kTilePixels> drawn_{};
  int x0_ = 0, y0_ = 0, x1_ = 0, y1_ = 0, first_ = 0;  // the tile's part of the crop, where it begins
  float *features_out_ = nullptr, *radiance_out_ = nullptr;
};

}  // namespace

void read_crop(const PackedFrame& frame, const Augmentation& augmentation,
               const std::vector<std::string>& features, const CropPlanes& planes, const SampleList& samples,
               const SampleList& targets, const SampleList& noisy) {
  CropReader reader(frame, augmentation, features, planes, samples, targets, noisy);
  const TileRange range = augmentation.tiles();
  for (int y = range.y0; y < range.y1; ++y)
    for (int x = range.x0; x < range.x1; ++x) reader.read(x, y);
}

}  // namespace ld
