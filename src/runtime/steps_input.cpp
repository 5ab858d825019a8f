// What frames are before a network sees them.
#include <algorithm>
#include <cmath>

#include "frame/encoding.h"
#include "models/network_numbers.h"
#include "ops/kernels/tone_map_row.h"
#include "runtime/frame_exposure.h"
#include "runtime/row_step.h"
#include "runtime/statistics_rows.h"

namespace ld {
namespace {

class EncodeStep : public Step {
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

  void run(int64_t begin, int64_t end) override {
    const Frame& frame = *context_.frame;
    parallel_for(context_.threads, (end - begin) * frame.spp,
                 [&](int64_t i, int) { encode_sample(frame, begin + i / frame.spp, int(i % frame.spp)); });
  }

 private:
  struct Channel {
    const Feature* feature;
    int place;  // in the frame
  };

  void encode_sample(const Frame& frame, int64_t y, int s) const {
    const int64_t offset = y * frame.width;
    const uint8_t* drawn = frame.valid_plane(s) + offset;
    float* valid = valid_.row(y, s);
    for (int64_t x = 0; x < frame.width; ++x) valid[x] = drawn[x] != 0 ? 1.0f : 0.0f;
    const graph::LightParts& parts = context_.graph.parts;
    int64_t light = s * (3 + parts.channels());
    const auto add_light = [&](const float* plane) {
      std::copy_n(plane + offset, frame.width, radiance_.row(y, light++));
    };
    for (int c = 0; c < 3; ++c) add_light(frame.plane(s, kRadianceOffset + c));
    for (size_t part = 0; part < size_t(parts.colours); ++part)
      for (int c = 0; c < 3; ++c) add_light(frame.part_plane(part, s, c));
    if (parts.alpha) add_light(frame.alpha.data() + size_t(s) * frame.plane_size());
    const auto count = int64_t(channels_.size());
    for (int64_t c = 0; c < count; ++c) {
      float* out = features_.row(y, s * count + c);
      const Channel& channel = channels_[size_t(c)];
      const float* values = frame.plane(s, channel.place) + offset;
      if (channel.feature->encoding == Encoding::tone_map)
        encode_radiance(values, out, frame.width);
      else
        encode(*channel.feature, frame.info.depth_scale, values, out, size_t(frame.width));
      for (int64_t x = 0; x < frame.width; ++x) out[x] *= valid[x];
    }
  }

  void encode_radiance(const float* values, float* out, int64_t count) const {
    if (context_.graph.exposed) {
      expose_row(values, context_.exposure, out, count);
      values = out;
    }
    tone_map_row(values, out, count);
  }

  StepContext& context_;
  RowWindow features_, radiance_, valid_;
  std::vector<Channel> channels_;
};

/// Of Demodulate.
struct DemodulateRow {
  graph::Demodulate op;
  RowWindow features, radiance, valid, forms, modulators;

  int64_t scratch() const { return 3 * (valid.planes + 1) * features.pitch; }

  void operator()(int64_t y, float* memory) const {
    const int64_t samples = valid.planes, width = valid.width, pitch = features.pitch;
    float *a = memory, *share = a + samples * 3 * pitch, *missed = share + pitch, *variance = missed + pitch;
    for (int64_t s = 0; s < samples; ++s) sample(y, s, a + s * 3 * pitch);
    shares(valid, y, share);
    float* relative = modulators.row(y, 3);
    std::fill_n(relative, width, 0.0f);
    for (int64_t c = 0; c < 3; ++c) {
      float* mean = modulators.row(y, c);
      mean_and_variance(
          valid, y, share, [&](int64_t s) { return a + (s * 3 + c) * pitch; }, missed, mean, variance);
      for (int64_t x = 0; x < width; ++x) relative[x] += variance[x] / (mean[x] == 0 ? 1 : mean[x] * mean[x]);
    }
    for (int64_t x = 0; x < width; ++x) relative[x] /= 3;
  }

  /// `a` [3]: the demodulators of a row of samples.
  void sample(int64_t y, int64_t s, float* a) const {
    const int64_t pitch = features.pitch, channels = features.planes / valid.planes;
    const auto reflectance = [&](int64_t x, int64_t c) {
      float sum = 0;
      for (const int64_t first : {op.albedo, op.specular})
        if (first >= 0) sum += features.row(y, s * channels + first + c)[x];
      return sum;
    };
    for (int64_t x = 0; x < features.width; ++x) {
      float r[3], most = 0;
      for (int64_t c = 0; c < 3; ++c) most = std::max(most, r[c] = reflectance(x, c));
      for (int64_t c = 0; c < 3; ++c) {
        const float clamped = std::clamp(r[c], float(kLeastReflectance), float(kMostReflectance));
        a[c * pitch + x] = most <= float(kNoReflectance) ? 1.0f : clamped;
      }
    }
    const int64_t in = radiance.planes / valid.planes, out = forms.planes / valid.planes;
    for (int64_t c = 0; c < 3; ++c) {
      const float* light = radiance.row(y, s * in + c);
      float* divided = forms.row(y, s * out + c);
      float* plain = forms.row(y, s * out + 3 + c);
      for (int64_t x = 0; x < features.width; ++x) {
        divided[x] = std::min(light[x], float(kLargestDemodulated)) / a[c * pitch + x];
        plain[x] = light[x];
      }
    }
    const int64_t coloured = (in - 3) / 3 * 3;
    for (int64_t c = 0; c < in - 3; ++c) {
      const float* part = radiance.row(y, s * in + 3 + c);
      const bool colour = c < coloured;
      std::copy_n(part, features.width, forms.row(y, s * out + 6 + coloured + c));
      if (colour)
        divide_part(part, radiance.row(y, s * in + c % 3), a + c % 3 * pitch, forms.row(y, s * out + 6 + c));
    }
  }

  /// Of such parts as the radiance is bounded to, so that their sum is still that.
  void divide_part(const float* __restrict part, const float* __restrict light, const float* __restrict a,
                   float* __restrict divided) const {
    constexpr auto kMost = float(kLargestDemodulated);
    for (int64_t x = 0; x < features.width; ++x) {
      const float bounded = part[x] * (kMost / std::max(light[x], kMost));
      divided[x] = std::clamp(bounded, -kMost, kMost) / a[x];
    }
  }
};

}  // namespace

std::unique_ptr<Step> make_step(const graph::Encode& op, const graph::Node& node, StepContext& context) {
  return std::make_unique<EncodeStep>(op, node, context);
}
std::unique_ptr<Step> make_step(const graph::Demodulate& op, const graph::Node& node, StepContext& context) {
  const DemodulateRow row = {op,
                             context.input(node, 0),
                             context.input(node, 1),
                             context.input(node, 2),
                             context.output(node, 0),
                             context.output(node, 1)};
  return row_step(context, row.scratch(), row);
}

}  // namespace ld
