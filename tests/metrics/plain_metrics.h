// The metrics once more, written from their equations as plain loops in long double, and pictures to try them
// on. Shares no code with src/metrics.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/random.h"
#include "frame/frame.h"

namespace ld::plain {

/// Radiance of a wide range: log-normal over about e^-6 to e^6, one value in eight black.
inline Image random_image(int width, int height, uint32_t number) {
  RandomStream stream(71, RandomPurpose::test, number);
  Image image(width, height, 3);
  for (float& x : image.pixels)
    x = stream.below(8) == 0 ? 0.0F : static_cast<float>(std::exp(2 * stream.normal() - 1));
  return image;
}

/// The same picture with multiplicative noise of deviation `amount`.
inline Image with_noise(const Image& image, double amount, uint32_t number) {
  RandomStream stream(72, RandomPurpose::test, number);
  Image noisy = image;
  for (float& x : noisy.pixels) x = static_cast<float>(x * std::exp(amount * stream.normal()));
  return noisy;
}

/// [MH20], eq. 7 and 8, clamped to [0, 1].
inline long double shown(long double x) {
  if (x <= 0) return 0;
  const long double y = std::log1p(x);
  const long double s = y <= 0.0031308L ? 12.92L * y : 1.055L * std::pow(y, 1.0L / 2.4L) - 0.055L;
  return std::min(s, 1.0L);
}

inline double relmse(const Image& d, const Image& r) {
  long double sum = 0;
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < r.height; ++y)
      for (int x = 0; x < r.width; ++x) {
        const long double a = d.at(c, x, y), b = r.at(c, x, y);
        sum += (a - b) * (a - b) / (b * b + 0.0001L);
      }
  return static_cast<double>(sum / (3.0L * r.width * r.height));
}

inline double smape(const Image& d, const Image& r) {
  long double sum = 0;
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < r.height; ++y)
      for (int x = 0; x < r.width; ++x) {
        const long double a = d.at(c, x, y), b = r.at(c, x, y);
        sum += std::fabs(a - b) / (std::fabs(a) + std::fabs(b) + 0.01L);
      }
  return static_cast<double>(sum / (3.0L * r.width * r.height));
}

inline double psnr(const Image& d, const Image& r) {
  long double sum = 0;
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < r.height; ++y)
      for (int x = 0; x < r.width; ++x) {
        const long double difference = shown(d.at(c, x, y)) - shown(r.at(c, x, y));
        sum += difference * difference;
      }
  return static_cast<double>(10 * std::log10(3.0L * r.width * r.height / sum));
}

/// SSIM of one window of one channel, its centre at (cx, cy): means first, then deviations from them (two
/// passes).
inline long double ssim_at(const Image& d, const Image& r, int c, int cx, int cy, int radius) {
  long double weight_sum = 0, mean_a = 0, mean_b = 0;
  for (int j = -radius; j <= radius; ++j)
    for (int i = -radius; i <= radius; ++i) {
      const long double w = std::exp(-(i * i + j * j) / 4.5L);
      weight_sum += w;
      mean_a += w * shown(d.at(c, cx + i, cy + j));
      mean_b += w * shown(r.at(c, cx + i, cy + j));
    }
  mean_a /= weight_sum;
  mean_b /= weight_sum;
  long double variance_a = 0, variance_b = 0, covariance = 0;
  for (int j = -radius; j <= radius; ++j)
    for (int i = -radius; i <= radius; ++i) {
      const long double w = std::exp(-(i * i + j * j) / 4.5L) / weight_sum;
      const long double a = shown(d.at(c, cx + i, cy + j)) - mean_a,
                        b = shown(r.at(c, cx + i, cy + j)) - mean_b;
      variance_a += w * a * a;
      variance_b += w * b * b;
      covariance += w * a * b;
    }
  return (2 * mean_a * mean_b + 0.0001L) * (2 * covariance + 0.0009L) /
         ((mean_a * mean_a + mean_b * mean_b + 0.0001L) * (variance_a + variance_b + 0.0009L));
}

inline double ssim(const Image& d, const Image& r) {
  int window = std::min(11, std::min(r.width, r.height));
  if (window % 2 == 0) --window;
  const int radius = window / 2;
  long double sum = 0;
  int64_t count = 0;
  for (int c = 0; c < 3; ++c)
    for (int y = radius; y < r.height - radius; ++y)
      for (int x = radius; x < r.width - radius; ++x) {
        sum += ssim_at(d, r, c, x, y, radius);
        ++count;
      }
  return static_cast<double>(sum / count);
}

}  // namespace ld::plain
