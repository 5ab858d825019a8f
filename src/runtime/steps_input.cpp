// What frames are before a network sees them.
#include <algorithm>

#include "frame/encoding.h"
#include "models/network_numbers.h"
#include "ops/kernels/sample_tile.h"
#include "ops/kernels/tone_map_row.h"
#include "runtime/tile_step.h"

namespace ld {
namespace {

class EncodeStep : public TileStep {
 public:
  EncodeStep(const graph::Encode& op, const graph::Node& node, StepContext& context)
      : context_(context),
        features_(context.output(node, 0)),
        radiance_(context.output(node, 1)),
        valid_(context.output(node, 2)) {
    for (const std::string& name : op.features)
      for (int c = 0; c < find_feature(name).channels; ++c)
        channels_.push_back({&find_feature(name), find_feature(name).offset + c});
  }

  void make(const PixelTile& tile) override {
    for (int s = 0; s < int(context_.picture.samples); ++s) encode_sample(tile, s);
  }

 private:
  struct Channel {
    const Feature* feature;
    int place;  // in the frame
  };

  void encode_sample(const PixelTile& tile, int s) const {
    const SampleStretch from = context_.source->read(s, tile);
    float* valid = valid_.at(tile, s).data;
    const uint8_t* drawn = from.valid();
    for (int64_t x = 0; x < tile.count; ++x) valid[x] = drawn[x] != 0 ? 1.0f : 0.0f;
    const graph::LightParts& parts = context_.graph.parts;
    int64_t light = s * (3 + parts.channels());
    const auto add_light = [&](const float* values) {
      std::copy_n(values, tile.count, radiance_.at(tile, light++).data);
    };
    for (int c = 0; c < 3; ++c) add_light(from.plane(kRadianceOffset + c));
    for (size_t part = 0; part < size_t(parts.colours); ++part)
      for (int c = 0; c < 3; ++c) add_light(from.part(part, c));
    if (parts.alpha) add_light(from.alpha());
    const auto count = int64_t(channels_.size());
    for (int64_t c = 0; c < count; ++c) {
      float* out = features_.at(tile, s * count + c).data;
      const Channel& channel = channels_[size_t(c)];
      // Frames end with the last feature that they hold.
      if (channel.place >= from.frame->channels) {
        std::fill_n(out, tile.count, 0.0f);
        continue;
      }
      const float* values = from.plane(channel.place);
      if (channel.feature->encoding == Encoding::tone_map)
        encode_radiance(values, out, tile.count);
      else
        encode(*channel.feature, context_.source->depth_scale, values, out, size_t(tile.count));
    }
    mask_planes(features_.at(tile, s * count), count, valid, padded(tile.count));
  }

  void encode_radiance(const float* values, float* out, int64_t count) const {
    if (context_.graph.exposed) {
      expose_row(values, context_.source->light.exposure, out, count);
      values = out;
    }
    tone_map_row(values, out, count);
  }

  StepContext& context_;
  RowWindow features_, radiance_, valid_;
  std::vector<Channel> channels_;
};

constexpr DemodulationLimits kDemodulationLimits = {float(kNoReflectance), float(kLeastReflectance),
                                                    float(kMostReflectance), float(kLargestDemodulated)};

/// Of Reflectance.
struct ReflectanceTile {
  graph::Reflectance op;
  RowWindow features, valid, mean;

  int64_t scratch() const { return (3 * valid.planes + 7) * kTilePixels; }

  void operator()(const PixelTile& tile, float* memory) const {
    const int64_t samples = valid.planes, channels = features.planes / samples, pixels = padded(tile.count);
    const PlanarTarget divisors = {memory, kTilePixels},  // [samples][3]
        forms = {divisors.plane(3 * samples), kTilePixels};
    float* share = forms.plane(6);
    const auto feature = [&](int64_t s, int64_t first) {
      return first < 0 ? PlanarRow() : features.at(tile, s * channels + first);
    };
    for (int64_t s = 0; s < samples; ++s)
      demodulate(kDemodulationLimits, feature(s, op.albedo), feature(s, op.specular), features.at(tile, 0),
                 pixels, {divisors.plane(3 * s), kTilePixels}, forms);
    valid_shares(valid.at(tile), samples, pixels, share);
    for (int64_t c = 0; c < 3; ++c)
      mean_of_items({divisors.plane(c), 3 * kTilePixels}, valid.at(tile), share, samples, pixels,
                    mean.at(tile, c).data);
  }
};

/// Of Demodulate.
struct DemodulateTile {
  graph::Demodulate op;
  RowWindow features, radiance, valid, forms, modulators;

  int64_t scratch() const { return (3 * valid.planes + 4) * kTilePixels; }

  void operator()(const PixelTile& tile, float* memory) const {
    const int64_t samples = valid.planes, channels = features.planes / samples, pixels = padded(tile.count);
    const PlanarTarget divisors = {memory, kTilePixels},  // [samples][3]
        variances = {divisors.plane(3 * samples), kTilePixels};
    float* share = variances.plane(3);
    const auto feature = [&](int64_t s, int64_t first) {
      return first < 0 ? PlanarRow() : features.at(tile, s * channels + first);
    };
    const int64_t in = radiance.planes / samples, out = forms.planes / samples;
    for (int64_t s = 0; s < samples; ++s) {
      const PlanarTarget of_sample = {divisors.plane(3 * s), kTilePixels};
      demodulate(kDemodulationLimits, feature(s, op.albedo), feature(s, op.specular),
                 radiance.at(tile, in * s), pixels, of_sample, forms.at(tile, out * s));
      divide_parts(radiance.at(tile, in * s), in - 3, of_sample, pixels, forms.at(tile, out * s));
    }
    const PlanarTarget means = modulators.at(tile);
    valid_shares(valid.at(tile), samples, pixels, share);
    for (int64_t c = 0; c < 3; ++c)
      moments_of_items({divisors.plane(c), 3 * kTilePixels}, valid.at(tile), share, samples, pixels,
                       means.plane(c), variances.plane(c));
    relative_variance(means, variances, pixels, modulators.at(tile, 3).data);
  }

  /// The parts behind a sample's radiance.
  static void divide_parts(PlanarRow light, int64_t parts, PlanarRow divisors, int64_t pixels,
                           PlanarTarget to) {
    const int64_t coloured = parts / 3 * 3;
    for (int64_t c = 0; c < parts; ++c) {
      std::copy_n(light.plane(3 + c), pixels, to.plane(6 + coloured + c));
      if (c < coloured)
        divide_part(light.plane(3 + c), light.plane(c % 3), divisors.plane(c % 3), pixels, to.plane(6 + c));
    }
  }

  /// Of such parts as the radiance is bounded to, so that their sum is still that.
  static void divide_part(const float* __restrict part, const float* __restrict light,
                          const float* __restrict divisor, int64_t pixels, float* __restrict divided) {
    constexpr auto kMost = float(kLargestDemodulated);
    for (int64_t x = 0; x < pixels; ++x) {
      const float bounded = part[x] * (kMost / std::max(light[x], kMost));
      divided[x] = std::clamp(bounded, -kMost, kMost) / divisor[x];
    }
  }
};

}  // namespace

std::unique_ptr<TileStep> make_step(const graph::Encode& op, const graph::Node& node, StepContext& context) {
  return std::make_unique<EncodeStep>(op, node, context);
}
std::unique_ptr<TileStep> make_step(const graph::Reflectance& op, const graph::Node& node,
                                    StepContext& context) {
  const ReflectanceTile tile = {op, context.input(node, 0), context.input(node, 1), context.output(node)};
  return tile_step(context, tile.scratch(), tile);
}
std::unique_ptr<TileStep> make_step(const graph::Demodulate& op, const graph::Node& node,
                                    StepContext& context) {
  const DemodulateTile tile = {op,
                               context.input(node, 0),
                               context.input(node, 1),
                               context.input(node, 2),
                               context.output(node, 0),
                               context.output(node, 1)};
  return tile_step(context, tile.scratch(), tile);
}

}  // namespace ld
