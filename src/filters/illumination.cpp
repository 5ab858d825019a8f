#include "filters/illumination.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "filters/kernels/luminance.h"
#include "runtime/parallel.h"

namespace ld {
namespace {

float reinhard(float c) {
  const float bright = std::max(c, 0.0F);
  return bright / (1 + bright);
}

float inverse_reinhard(float c) {
  return c / std::max(1 - c, 1e-4F);
}

template <class Function>
void change_all(RowPlanes& planes, int threads, const Function& function) {
  parallel_for(threads, planes.height(), [&](int64_t y, int) {
    for (int p = 0; p < planes.planes(); ++p) {
      float* const row = planes.row(y, p);
      for (int x = 0; x < planes.width(); ++x) row[x] = function(row[x]);
    }
  });
}

void luminance_row(const RowPlanes& signals, int signal, int64_t y, float* out) {
  const float *const r = signals.row(y, 3 * signal), *const g = signals.row(y, 3 * signal + 1),
                     *const b = signals.row(y, 3 * signal + 2);
  for (int x = 0; x < signals.width(); ++x)
    out[x] = kLuminanceRed * r[x] + kLuminanceGreen * g[x] + kLuminanceBlue * b[x];
}

}  // namespace

void compress(RowPlanes& signals, int threads) {
  change_all(signals, threads, reinhard);
}

void expand(RowPlanes& signals, int threads) {
  change_all(signals, threads, inverse_reinhard);
}

void bound_fireflies(RowPlanes& signals, RowPlanes& spare, double bound, int threads) {
  const int width = signals.width(), height = signals.height();
  resize(spare, width, height, signals.planes());
  parallel_for(threads, height, [&](int64_t y, int) {
    const int64_t first = std::max<int64_t>(y - 1, 0), last = std::min<int64_t>(y + 1, height - 1);
    const auto count_x = static_cast<size_t>(width);
    std::vector<float> own(count_x), row(count_x), columns(count_x);
    for (int s = 0; s < signals.planes() / 3; ++s) {
      std::fill(columns.begin(), columns.end(), 0.0F);
      for (int64_t v = first; v <= last; ++v) {
        luminance_row(signals, s, v, row.data());
        if (v == y) own = row;
        for (size_t x = 0; x < size_t(width); ++x)
          columns[x] += row[x] / 9;  // no sum beyond the largest float
      }
      for (int x = 0; x < width; ++x) {
        const int left = std::max(x - 1, 0), right = std::min(x + 1, width - 1);
        float around = 0;
        for (int u = left; u <= right; ++u) around += columns[size_t(u)];
        const auto count = float((right - left + 1) * int(last - first + 1) - 1);
        const float luminance = own[size_t(x)];
        const float most = float(bound) * (around - luminance / 9) * (9 / std::max(count, 1.0F));
        const float factor = count > 0 && luminance > most ? std::max(most, 0.0F) / luminance : 1.0F;
        for (int c = 3 * s; c < 3 * s + 3; ++c) spare.row(y, c)[x] = factor * signals.row(y, c)[x];
      }
    }
  });
  std::swap(signals, spare);
}

void recombine(const RowPlanes& filtered, int planes, const Illumination& light, bool is_compressed,
               RowPlanes& out, int threads) {
  const int width = filtered.width();
  resize(out, width, filtered.height(), 3);
  parallel_for(threads, filtered.height(), [&](int64_t y, int) {
    for (int c = 0; c < 3; ++c) {
      const float *const a = light.albedo.row(y, c), *const e = light.emission.row(y, c);
      float* const sum = out.row(y, c);
      std::fill_n(sum, width, 0.0F);
      for (int first = 0; first < filtered.planes(); first += planes) {
        const float* const s = filtered.row(y, first + c);
        if (is_compressed)
          for (int x = 0; x < width; ++x) sum[x] += inverse_reinhard(s[x]);
        else
          for (int x = 0; x < width; ++x) sum[x] += s[x];
      }
      for (int x = 0; x < width; ++x) sum[x] = std::min(sum[x] * a[x] + e[x], kLargestSignal);
    }
  });
}

Image image_of(const RowPlanes& picture, int threads) {
  Image image(picture.width(), picture.height(), picture.planes());
  parallel_for(threads, image.height, [&](int64_t y, int) {
    for (int c = 0; c < image.channels; ++c)
      std::copy_n(picture.row(y, c), image.width, image.plane(c) + size_t(y) * size_t(image.width));
  });
  return image;
}

}  // namespace ld
