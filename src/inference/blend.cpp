#include "inference/blend.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "core/window_sums.h"

namespace ld {
namespace {

constexpr double kEpsilon = 0.01;  // beside h^2, as the losses of noisy references have it

/// Mean and variance of the mean of some of a pixel's samples, one channel.
struct Estimate {
  double mean = 0, variance = 0;
  int drawn = 0;
};

/// Of the samples first, first + step, ... Without a second one the variance is unknown, and 0 here.
Estimate estimate(const Frame& frame, int channel, size_t pixel, int first, int step) {
  Estimate result;
  double squares = 0;
  for (int s = first; s < frame.spp; s += step) {
    if (frame.valid_plane(s)[pixel] == 0) continue;
    const double value = frame.plane(s, kRadianceOffset + channel)[pixel], before = value - result.mean;
    ++result.drawn;
    result.mean += before / result.drawn;
    squares += before * (value - result.mean);
  }
  if (result.drawn > 1) result.variance = squares / (double(result.drawn) * (result.drawn - 1));
  return result;
}

/// What a pixel says of the errors, means over the channels; bias_variance is the square of half the distance
/// of what the two halves say of the bias. `caution`: standard errors that its few samples take off.
struct Evidence {
  std::vector<double> known, variance, bias, bias_variance, caution;
  explicit Evidence(size_t pixels)
      : known(pixels), variance(pixels), bias(pixels), bias_variance(pixels), caution(pixels) {}
};

/// d^2 - v over h^2 + epsilon, each ratio formed before it is squared, so that nothing overflows.
double excess(double half, const Estimate& other) {
  const double scale = std::hypot(half, std::sqrt(kEpsilon));
  const double distance = (half - other.mean) / scale;
  return distance * distance - other.variance / scale / scale;
}

Evidence gather(const Frame& frame, const Image& first, const Image& second) {
  Evidence evidence(frame.plane_size());
  for (size_t p = 0; p < frame.plane_size(); ++p)
    for (int c = 0; c < 3; ++c) {
      const Estimate all = estimate(frame, c, p, 0, 1), a = estimate(frame, c, p, 0, 2),
                     b = estimate(frame, c, p, 1, 2);
      if (a.drawn == 0 || b.drawn == 0) continue;
      // A half of one sample has no spread of its own; that of all samples stands for it.
      const auto spread = [&](Estimate half) {
        if (half.drawn < 2) half.variance = all.variance * all.drawn / half.drawn;
        return half;
      };
      const double h1 = first.plane(c)[p], h2 = second.plane(c)[p];
      const double scale = std::hypot(0.5 * h1 + 0.5 * h2, std::sqrt(kEpsilon));
      const double of_first = excess(h1, spread(b)), of_second = excess(h2, spread(a));
      evidence.known[p] = 1;
      evidence.caution[p] = kBlendCaution / all.drawn;
      evidence.variance[p] += all.variance / scale / scale / 3;
      evidence.bias[p] += (0.5 * of_first + 0.5 * of_second) / 3;
      evidence.bias_variance[p] += (0.5 * of_first - 0.5 * of_second) / 3;
    }
  for (double& apart : evidence.bias_variance) apart *= apart;
  return evidence;
}

/// Over the window around each pixel: how many pixels are known, and the means of what they say.
struct Errors {
  std::vector<double> count, variance, bias;
};

/// The bias as far as it is sure, and averaged once more: where by chance it is large in one window alone,
/// noise would come in as a speck.
Errors errors_of(Evidence evidence, int width, int height) {
  const auto sums = [&](const std::vector<double>& plane) {
    return window_sums(plane, width, height, kBlendWindow / 2);
  };
  Errors errors{sums(evidence.known), sums(evidence.variance), sums(evidence.bias)};
  const std::vector<double> bias_variance = sums(evidence.bias_variance), caution = sums(evidence.caution);
  for (size_t p = 0; p < errors.count.size(); ++p) {
    if (errors.count[p] == 0) continue;
    const double confidence = kBlendConfidence + caution[p] / errors.count[p];
    errors.bias[p] = std::max(errors.bias[p] - confidence * std::sqrt(bias_variance[p]), 0.0);
  }
  // In the place of what is no longer needed, which blend_bytes() counts on.
  evidence.bias = sums(errors.bias);
  evidence.known = sums(errors.count);
  for (size_t p = 0; p < errors.count.size(); ++p) {
    if (errors.count[p] == 0) continue;
    errors.variance[p] /= errors.count[p];
    errors.bias[p] = evidence.bias[p] / evidence.known[p];
  }
  return errors;
}

/// a of a pixel of that variance, between a picture with this bias and a mean of this variance.
double share_of_denoised(double own_variance, double variance, double bias) {
  const double noise = std::max(variance, own_variance);
  return variance > 0 ? noise / (noise + bias) : 0;
}

}  // namespace

bool can_blend(const Frame& frame) {
  return frame.spp >= 2;
}

Frame half_of(const Frame& frame, int first) {
  Frame half(frame.width, frame.height, (frame.spp - first + 1) / 2, frame.channels);
  half.features = frame.features;
  half.info = frame.info;
  for (int s = 0; s < half.spp; ++s) {
    const int from = first + 2 * s;
    std::copy_n(frame.plane(from, 0), size_t(frame.channels) * frame.plane_size(), half.plane(s, 0));
    std::copy_n(frame.valid_plane(from), frame.plane_size(), half.valid_plane(s));
  }
  return half;
}

HalfInPlace half_in_place(const Frame& frame, int first, const std::vector<std::string>& features) {
  HalfInPlace half;
  SampleArrays& arrays = half.arrays;
  arrays.width = frame.width;
  arrays.height = frame.height;
  arrays.spp = (frame.spp - first + 1) / 2;
  arrays.depth_scale = frame.info.depth_scale;
  const auto plane = ptrdiff_t(frame.plane_size());
  for (const std::string& name : features) {
    if (!frame.holds(name)) continue;
    const Feature& feature = find_feature(name);
    arrays.features.push_back(
        {&feature, {frame.plane(first, feature.offset), 2 * plane * frame.channels, plane, frame.width, 1}});
  }
  for (int s = first; s < frame.spp; s += 2)
    half.valid.insert(half.valid.end(), frame.valid_plane(s), frame.valid_plane(s) + plane);
  arrays.valid = half.valid.data();
  return half;
}

int64_t blend_bytes(const Frame& frame) {
  const int64_t planes = 1 + 5 + 5 + 2, images = 3 * 3 + 3 + 1 + 3;  // what is there at once, of both kinds
  return int64_t(frame.plane_size()) *
         (planes * int64_t(sizeof(double)) + images * int64_t(sizeof(float)) + (frame.spp + 1) / 2);
}

Blended blend_with_mean(const Frame& frame, const Image& denoised, const Image& first, const Image& second) {
  if (!can_blend(frame))
    fail("blending with the mean needs two samples a pixel or more, found {}", frame.spp);
  for (const Image* image : {&denoised, &first, &second})
    if (image->width != frame.width || image->height != frame.height || image->channels != 3)
      fail("a picture of {}x{} beside a frame of {}x{}", image->width, image->height, frame.width,
           frame.height);
  Evidence evidence = gather(frame, first, second);
  const std::vector<double> own_variance = evidence.variance;
  const Errors errors = errors_of(std::move(evidence), frame.width, frame.height);
  Blended result = {denoised, Image(frame.width, frame.height, 1)};
  const Image mean = mean_radiance(frame);
  for (size_t p = 0; p < frame.plane_size(); ++p) {
    const double a =
        errors.count[p] > 0 ? share_of_denoised(own_variance[p], errors.variance[p], errors.bias[p]) : 1;
    result.weight.pixels[p] = float(a);
    for (int c = 0; c < 3; ++c) {
      const double y = mean.plane(c)[p];
      result.picture.plane(c)[p] = float(a * denoised.plane(c)[p] + (1 - a) * y);
    }
  }
  return result;
}

}  // namespace ld
