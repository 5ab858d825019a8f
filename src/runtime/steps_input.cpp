// What frames are before a network sees them.
#include <algorithm>
#include <cmath>

#include "frame/encoding.h"
#include "models/network_numbers.h"
#include "ops/kernels/tone_map_row.h"
#include "runtime/frame_exposure.h"
#include "runtime/parallel.h"
#include "runtime/step.h"

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
    for (int c = 0; c < 3; ++c)
      std::copy_n(frame.plane(s, kRadianceOffset + c) + offset, frame.width, radiance_.row(y, 3 * s + c));
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

class DemodulateStep : public Step {
 public:
  DemodulateStep(const graph::Demodulate& op, const graph::Node& node, StepContext& context)
      : op_(op),
        context_(context),
        features_(context.input(node, 0)),
        radiance_(context.input(node, 1)),
        valid_(context.input(node, 2)),
        forms_(context.output(node, 0)),
        modulators_(context.output(node, 1)),
        items_(context.items(node.inputs[0])),
        feature_channels_(features_.planes / items_),
        scratch_(size_t(context.threads)) {
    for (auto& memory : scratch_) memory.resize(size_t(items_ * 3 * features_.pitch));
  }

  void run(int64_t begin, int64_t end) override {
    parallel_for(context_.threads, end - begin,
                 [&](int64_t i, int thread) { row(begin + i, scratch_[size_t(thread)].data()); });
  }

 private:
  /// `a` [S][3]: the demodulators of the row.
  void row(int64_t y, float* a) const {
    const int64_t samples = items_, width = features_.width, pitch = features_.pitch;
    for (int64_t s = 0; s < samples; ++s) sample(y, s, a + s * 3 * pitch);
    for (int64_t x = 0; x < width; ++x) {
      float count = 0;
      for (int64_t s = 0; s < samples; ++s) count += valid_.row(y, s)[x];
      const float share = 1 / std::max(count, 1.0f);
      float relative = 0;
      for (int64_t c = 0; c < 3; ++c) {
        float mean = 0, missed = 0, variance = 0;
        for (int64_t s = 0; s < samples; ++s)
          mean += valid_.row(y, s)[x] * share * a[(s * 3 + c) * pitch + x];
        // The mean of many values is rounded; what it misses is the mean of the rest
        // (models/sample_statistics.h).
        for (int64_t s = 0; s < samples; ++s)
          missed += valid_.row(y, s)[x] * share * (a[(s * 3 + c) * pitch + x] - mean);
        for (int64_t s = 0; s < samples; ++s) {
          const float rest = a[(s * 3 + c) * pitch + x] - mean - missed;
          variance += valid_.row(y, s)[x] * share * rest * rest;
        }
        mean += missed;
        modulators_.row(y, c)[x] = mean;
        relative += variance / (mean == 0 ? 1 : mean * mean);
      }
      modulators_.row(y, 3)[x] = relative / 3;
    }
  }

  void sample(int64_t y, int64_t s, float* a) const {
    const int64_t pitch = features_.pitch;
    const auto reflectance = [&](int64_t x, int64_t c) {
      float sum = 0;
      for (const int64_t first : {op_.albedo, op_.specular})
        if (first >= 0) sum += features_.row(y, s * feature_channels_ + first + c)[x];
      return sum;
    };
    for (int64_t x = 0; x < features_.width; ++x) {
      float r[3], most = 0;
      for (int64_t c = 0; c < 3; ++c) most = std::max(most, r[c] = reflectance(x, c));
      for (int64_t c = 0; c < 3; ++c) {
        const float clamped = std::clamp(r[c], float(kLeastReflectance), float(kMostReflectance));
        a[c * pitch + x] = most <= float(kNoReflectance) ? 1.0f : clamped;
      }
    }
    for (int64_t c = 0; c < 3; ++c) {
      const float* radiance = radiance_.row(y, s * 3 + c);
      float* divided = forms_.row(y, s * 6 + c);
      float* plain = forms_.row(y, s * 6 + 3 + c);
      for (int64_t x = 0; x < features_.width; ++x) {
        divided[x] = std::min(radiance[x], float(kLargestDemodulated)) / a[c * pitch + x];
        plain[x] = radiance[x];
      }
    }
  }

  graph::Demodulate op_;
  StepContext& context_;
  RowWindow features_, radiance_, valid_, forms_, modulators_;
  int64_t items_, feature_channels_;
  std::vector<std::vector<float>> scratch_;
};

}  // namespace

std::unique_ptr<Step> make_step(const graph::Encode& op, const graph::Node& node, StepContext& context) {
  return std::make_unique<EncodeStep>(op, node, context);
}
std::unique_ptr<Step> make_step(const graph::Demodulate& op, const graph::Node& node, StepContext& context) {
  return std::make_unique<DemodulateStep>(op, node, context);
}

}  // namespace ld
