#include "render/shading/probe.h"

#include "render/geometry/sampling.h"

namespace ld {
namespace {

/// Where on the picture a direction (in the probe's own axes) falls, in [0, 1) from left to right and top to
/// bottom.
Vec2 to_picture(Vec3 d) {
  const float azimuth = std::atan2(d.x, -d.z) / (2 * kPi) + 0.5F;
  const float polar = std::atan2(std::hypot(d.x, d.z), d.y) / kPi;  // acos loses its digits near the poles
  return {azimuth < 1 ? azimuth : 0, polar};
}

Vec3 to_direction(Vec2 p) {
  const float azimuth = (p.x - 0.5F) * 2 * kPi, polar = p.y * kPi;
  const float r = std::sin(polar);
  return {r * std::sin(azimuth), std::cos(polar), -r * std::cos(azimuth)};
}

}  // namespace

Vec3 Probe::radiance(Vec3 direction) const {
  const Vec2 p = to_picture(orientation.to_local(direction));
  return scale * image->bilinear(p.x * static_cast<float>(image->width),
                                 p.y * static_cast<float>(image->height), true);
}

ProbeSampler::ProbeSampler(const Probe& probe)
    : width_(probe.image->width), height_(probe.image->height), orientation_(probe.orientation) {
  const auto w = static_cast<size_t>(width_), h = static_cast<size_t>(height_);
  rows_.resize(h);
  columns_.resize(w * h);
  const auto value = [&](size_t row, size_t column) {
    return static_cast<double>(luminance(probe.scale * probe.image->texels[row * w + column]));
  };
  double total = 0, power = 0;
  for (size_t j = 0; j < h; ++j) {
    const double pi = static_cast<double>(kPi);
    const double solid_angle = 2 * pi * pi / static_cast<double>(w * h) *
                               std::sin(pi * (static_cast<double>(j) + 0.5) / static_cast<double>(h));
    double row_sum = 0;
    for (size_t i = 0; i < w; ++i) {
      // Bilinear lookup brings the neighbours' light into this texel: none that can shine may be left out.
      double around = 0;
      for (size_t dj = j == 0 ? 0 : j - 1; dj <= std::min(j + 1, h - 1); ++dj)
        for (const size_t di : {(i + w - 1) % w, i, (i + 1) % w}) around += value(dj, di);
      power += value(j, i) * solid_angle;
      row_sum += (0.5 * value(j, i) + around / 18) * solid_angle;
      columns_[j * w + i] = static_cast<float>(row_sum);
    }
    for (size_t i = 0; i < w; ++i)
      columns_[j * w + i] = row_sum > 0
                                ? static_cast<float>(static_cast<double>(columns_[j * w + i]) / row_sum)
                                : static_cast<float>(i + 1) / static_cast<float>(w);
    rows_[j] = static_cast<float>(total += row_sum);
  }
  for (float& row : rows_) row = total > 0 ? static_cast<float>(static_cast<double>(row) / total) : 0;
  power_ = static_cast<float>(power);
}

float ProbeSampler::texel_pdf(size_t row, size_t column, float polar) const {
  const auto w = static_cast<size_t>(width_);
  const float density = bin_share(rows_.data(), row) * bin_share(&columns_[row * w], column) *
                        static_cast<float>(width_) * static_cast<float>(height_);
  return density / (2 * kPi * kPi * std::sin(kPi * polar));
}

SkySample ProbeSampler::sample(float u0, float u1) const {
  const auto w = static_cast<size_t>(width_);
  const size_t row = choose_bin(rows_.data(), rows_.size(), u0);
  const size_t column = choose_bin(&columns_[row * w], w, u1);
  const Vec2 place = {(static_cast<float>(column) + u1) / static_cast<float>(width_),
                      (static_cast<float>(row) + u0) / static_cast<float>(height_)};
  SkySample drawn;
  drawn.direction = orientation_.to_world(to_direction(place));
  drawn.pdf = texel_pdf(row, column, place.y);
  return drawn;
}

float ProbeSampler::pdf(Vec3 direction) const {
  const Vec2 p = to_picture(orientation_.to_local(direction));
  const int row = std::clamp(static_cast<int>(p.y * static_cast<float>(height_)), 0, height_ - 1);
  const int column = std::clamp(static_cast<int>(p.x * static_cast<float>(width_)), 0, width_ - 1);
  return texel_pdf(static_cast<size_t>(row), static_cast<size_t>(column), p.y);
}

}  // namespace ld
