#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/error.h"
#include "filters/kernels/luminance.h"
#include "filters/kernels/svgf_accumulate.h"
#include "filters/svgf.h"
#include "runtime/parallel.h"

namespace ld {
namespace {

/// What one thread needs for a row: bounds of the history, and which pixels have no bilinear tap.
struct RowMemory {
  std::vector<float> columns, bounds, missing;

  void resize(int64_t pitch, int planes) {
    columns.resize(size_t(3 * pitch));
    bounds.resize(size_t(pitch * 2 * planes));
    missing.resize(size_t(pitch));
  }

  const float* fill_bounds(const Surfaces& surfaces, const RowPlanes& signals, int64_t y, float deviations) {
    HistoryBoundsRow row;
    row.width = surfaces.width();
    row.pitch = signals.pitch();
    row.planes = signals.planes();
    for (int64_t j = 0; j < 5; ++j) {
      const int64_t v = y + j - 2;
      if (v < 0 || v >= surfaces.height()) continue;
      row.ids[size_t(j)] = surfaces.of.row(v, kId);
      row.signals[size_t(j)] = signals.row(v);
    }
    row.deviations = deviations;
    row.columns = columns.data() + RowPlanes::kMargin;
    row.bounds = bounds.data();
    svgf_history_bounds_row(row);
    return bounds.data();
  }
};

/// The pixels among the 3x3 around p' that show the surface of pixel (x, y).
struct Neighbours {
  int count = 0;
  std::array<int64_t, 9> x{}, y{};

  Neighbours(const Surfaces& now, const RowPlanes& slopes, const Surfaces& before, const HistoryTest& test,
             int64_t px, int64_t py) {
    const float* const here = now.of.row(py) + px;
    const int64_t pitch = now.of.pitch();
    const float depth = here[kDepth * pitch] + now.flow.at(px, py, 2);
    const float slope = std::max(std::abs(slopes.at(px, py, 0)), std::abs(slopes.at(px, py, 1)));
    const float tolerance = test.depth_slopes * slope + test.depth_least;
    const auto u = int64_t(std::floor(float(px) + now.flow.at(px, py, 0) + 0.5F)),
               v = int64_t(std::floor(float(py) + now.flow.at(px, py, 1) + 0.5F));
    for (int64_t t = std::max<int64_t>(v - 1, 0); t <= std::min<int64_t>(v + 1, before.height() - 1); ++t)
      for (int64_t s = std::max<int64_t>(u - 1, 0); s <= std::min<int64_t>(u + 1, before.width() - 1); ++s) {
        const float* const there = before.of.row(t) + s;
        float cosine = 0;
        for (int c = kNormalX; c <= kNormalZ; ++c) cosine += here[c * pitch] * there[c * pitch];
        if (there[kId * pitch] != here[kId * pitch] || cosine < test.least_cosine ||
            !(std::abs(there[kDepth * pitch] - depth) <= tolerance))
          continue;
        x[size_t(count)] = s;
        y[size_t(count++)] = t;
      }
  }

  template <class Value>
  float mean(const Value& value) const {
    float sum = 0;
    for (int i = 0; i < count; ++i) sum += value(x[size_t(i)], y[size_t(i)]);
    return sum / float(count);
  }
  float mean(const RowPlanes& planes, int plane) const {
    return mean([&](int64_t u, int64_t v) { return planes.at(u, v, plane); });
  }
  float least(const RowPlanes& planes, int plane) const {
    float smallest = planes.at(x[0], y[0], plane);
    for (int i = 1; i < count; ++i)
      smallest = std::min(smallest, planes.at(x[size_t(i)], y[size_t(i)], plane));
    return smallest;
  }
};

/// svgf_accumulate_row() for one pixel whose history are these neighbours.
void accumulate_pixel(const Neighbours& neighbours, const SvgfState& previous, const AccumulateRow& row,
                      int64_t x, int signals) {
  const float length = std::min(neighbours.least(previous.moments, 2 * signals) + 1, row.blend.longest);
  row.moments[row.pitch * 2 * signals + x] = length;
  const float share = std::max(row.blend.alpha, 1 / length),
              share_moments = std::max(row.blend.alpha_moments, 1 / length);
  for (int s = 0; s < signals; ++s) {
    for (int c = 0; c < 3; ++c) {
      float history = neighbours.mean(previous.light, 4 * s + c);
      if (row.bounds != nullptr) {
        const float* const bounds = row.bounds + row.pitch * 2 * (3 * s + c) + x;
        history = std::min(std::max(history, bounds[0]), bounds[row.pitch]);
      }
      float& light = row.light[(4 * s + c) * row.pitch + x];  // that of the new frame
      light = share * light + (1 - share) * history;
    }
    float* const moments = row.moments + row.pitch * 2 * s + x;
    const float m1 = neighbours.mean(previous.moments, 2 * s), step = moments[0] - m1;
    const float variance = neighbours.mean([&](int64_t u, int64_t v) {
      const float difference = previous.moments.at(u, v, 2 * s) - m1;
      return previous.moments.at(u, v, 2 * s + 1) + difference * difference;
    });
    moments[0] = m1 + share_moments * step;
    moments[row.pitch] = (1 - share_moments) * (variance + share_moments * (step * step));
    row.light[(4 * s + 3) * row.pitch + x] = moments[row.pitch];
  }
}

PlaneView view_of(const RowPlanes& planes) {
  return {planes.row(0), planes.row_pitch(), planes.pitch()};
}

}  // namespace

void accumulate(const Surfaces& surfaces, const RowPlanes& slopes, const RowPlanes& signals,
                const SvgfState& previous, const SvgfSettings& settings, RowPlanes& light, RowPlanes& moments,
                int threads) {
  const int width = surfaces.width(), height = surfaces.height(), count = signals.planes() / 3;
  if (surfaces.of.floats() > std::numeric_limits<int32_t>::max())
    fail("svgf takes frames of up to 250 megapixels, but this one has {}x{}", width, height);
  resize(light, width, height, 4 * count);
  resize(moments, width, height, 2 * count + 1);
  const bool remembers = surfaces.has_flow && !previous.empty();
  const int64_t pitch = signals.pitch();
  std::vector<RowMemory> memories(size_t(std::max(threads, 1)));
  const auto accumulate_row = [&](int64_t y, RowMemory& memory) {
    AccumulateRow row;
    row.width = width;
    row.height = height;
    row.y = y;
    row.pitch = pitch;
    row.signals = signals.row(y);
    row.light = light.row(y);
    row.moments = moments.row(y);
    if (!remembers) return svgf_accumulate_row(row, count);

    memory.resize(pitch, signals.planes());
    row.surfaces = surfaces.of.row(y);
    row.flow = surfaces.flow.row(y);
    row.slopes = slopes.row(y);
    row.surfaces_before = view_of(previous.surfaces.of);
    row.light_before = view_of(previous.light);
    row.moments_before = view_of(previous.moments);
    row.test = {float(settings.history_depth),
                float(settings.history_depth) * (10 * kReprojectionDepthFloor) * surfaces.unit,
                float(settings.history_normal)};
    row.blend = {float(settings.alpha), float(settings.alpha_moments), float(settings.longest_history)};
    if (settings.antilag == "clip")
      row.bounds = memory.fill_bounds(surfaces, signals, y, float(settings.clip_deviations));
    row.missing = memory.missing.data();
    svgf_accumulate_row(row, count);
    for (int64_t x = 0; x < width; ++x) {
      if (memory.missing[size_t(x)] == 0) continue;
      const Neighbours neighbours(surfaces, slopes, previous.surfaces, row.test, x, y);
      if (neighbours.count > 0) accumulate_pixel(neighbours, previous, row, x, count);
    }
  };
  constexpr int64_t kRows = 16;  // that follow one another share what they read
  parallel_for(threads, (height + kRows - 1) / kRows, [&](int64_t part, int thread) {
    for (int64_t y = part * kRows; y < std::min<int64_t>((part + 1) * kRows, height); ++y)
      accumulate_row(y, memories[size_t(thread)]);
  });
}

}  // namespace ld
