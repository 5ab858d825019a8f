// What the frame before has left, and what becomes of it (models/history.h).
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "frame/schema.h"
#include "models/network_numbers.h"
#include "ops/kernels/warp_taps.h"
#include "runtime/row_step.h"
#include "runtime/tile_step.h"

namespace ld {
namespace {

/// Graph::state in its order.
enum StatePart { kLight, kFrames, kSurface };

class RecallStep : public Step {
 public:
  RecallStep(const graph::Recall& op, const graph::Node& node, StepContext& context)
      : op_(op),
        context_(context),
        features_(context.input(node, 0)),
        valid_(context.input(node, 1)),
        past_(context.output(node, 0)),
        frames_(context.output(node, 1)),
        surface_(context.output(node, 2)),
        flow_scale_(find_feature("flow").scale),
        by_depth_(size_t(context.threads)) {}

  void run(int64_t begin, int64_t end) override {
    parallel_for(context_.threads, end - begin,
                 [&](int64_t i, int thread) { row(begin + i, by_depth_[size_t(thread)]); });
  }

 private:
  using Depths = std::vector<std::pair<float, int64_t>>;

  float feature(int64_t y, int64_t x, int64_t sample, int64_t first, int64_t c = 0) const {
    return first < 0 ? 0 : features_.row(y, sample * channels() + first + c)[x];
  }
  int64_t channels() const { return features_.planes / valid_.planes; }

  /// Of the valid samples that of the lower median depth, the first of equals; -1 where there is none.
  int64_t representative(int64_t y, int64_t x, Depths& depths) const {
    depths.clear();
    for (int64_t s = 0; s < valid_.planes; ++s)
      if (valid_.row(y, s)[x] != 0) depths.emplace_back(feature(y, x, s, op_.depth), s);
    if (depths.empty()) return -1;
    const auto median = depths.begin() + std::ptrdiff_t((depths.size() - 1) / 2);
    std::nth_element(depths.begin(), median, depths.end());
    return median->second;
  }

  float decoded(float encoded) const {
    const float room = 1 - std::fabs(encoded);
    return room <= 0 ? std::numeric_limits<float>::infinity() : flow_scale_ * encoded / room;
  }

  void row(int64_t y, Depths& depths) const {
    for (int64_t c = 0; c < past_.planes; ++c) std::fill_n(past_.row(y, c), past_.width, 0.0f);
    std::fill_n(frames_.row(y), past_.width, 0.0f);
    for (int64_t x = 0; x < past_.width; ++x) {
      const int64_t s = representative(y, x, depths);
      GuideSurface<float> now;
      if (s >= 0)
        now = {feature(y, x, s, op_.depth), feature(y, x, s, op_.normal, 0), feature(y, x, s, op_.normal, 1),
               feature(y, x, s, op_.normal, 2)};
      const float planes[4] = {now.depth, now.nx, now.ny, now.nz};
      for (int64_t c = 0; c < 4; ++c) surface_.row(y, c)[x] = planes[c];
      if (s >= 0 && context_.before != nullptr)
        look_up(y, x, now, decoded(feature(y, x, s, op_.flow, 0)), decoded(feature(y, x, s, op_.flow, 1)));
    }
  }

  void look_up(int64_t y, int64_t x, const GuideSurface<float>& now, float flow_x, float flow_y) const {
    const FrameState& before = *context_.before;
    const auto counts = [&](int64_t u, int64_t v) {
      const auto of_surface = [&](int c) { return before[kSurface].at(c, int(u), int(v)); };
      return before[kFrames].at(0, int(u), int(v)) != 0 &&
             may_be_same_surface(now, {of_surface(0), of_surface(1), of_surface(2), of_surface(3)});
    };
    const WarpTaps<float> taps =
        warp_taps(float(x) + flow_x, float(y) + flow_y, past_.width, past_.height, counts);
    for (int i = 0; i < 4; ++i) {
      if (!(taps.weights[i] > 0)) continue;
      const int u = int(taps.column(i)), v = int(taps.row(i));
      for (int64_t c = 0; c < past_.planes; ++c)
        past_.row(y, c)[x] += taps.weights[i] * before[kLight].at(int(c), u, v);
      frames_.row(y)[x] += taps.weights[i] * before[kFrames].at(0, u, v);
    }
  }

  graph::Recall op_;
  StepContext& context_;
  RowWindow features_, valid_, past_, frames_, surface_;
  float flow_scale_;
  std::vector<Depths> by_depth_;  // a thread's own
};

/// Of Compare.
struct CompareRow {
  int64_t radius;
  RowWindow light, past, frames, out;

  int64_t scratch() const { return 2 * out.pitch; }

  void operator()(int64_t y, float* memory) const {
    float *difference = memory, *sum = memory + out.pitch;
    for (int64_t c = 0; c < 2; ++c) std::fill_n(out.row(y, c), out.width, 0.0f);
    for (int64_t c = 0; c < 3; ++c) {
      add_relative(c, y, y + 1, 0, difference, sum, out.row(y, 0));
      add_relative(c, std::max<int64_t>(y - radius, 0), std::min(y + radius + 1, out.height), radius,
                   difference, sum, out.row(y, 1));
    }
    const float* __restrict n = frames.row(y);
    for (int64_t x = 0; x < out.width; ++x) {
      const bool known = n[x] != 0;
      for (int64_t c = 0; c < 2; ++c) out.row(y, c)[x] = known ? out.row(y, c)[x] / 3 : 0;
      out.row(y, 2)[x] = known ? 1 / n[x] : 0;
    }
  }

  /// |sum of differences| over the sum of both, over so many rows and columns.
  void add_relative(int64_t c, int64_t top, int64_t bottom, int64_t columns, float* __restrict difference,
                    float* __restrict sum, float* __restrict to) const {
    std::fill_n(difference, out.width, 0.0f);
    std::fill_n(sum, out.width, 0.0f);
    for (int64_t v = top; v < bottom; ++v) {
      const float* __restrict n = frames.row(v);
      const float* __restrict now = light.row(v, c);
      const float* __restrict then = past.row(v, c);
      for (int64_t x = 0; x < out.width; ++x) {
        const float f = std::min(now[x], float(kLargestCompared)),
                    h = std::min(then[x], float(kLargestCompared));
        difference[x] += n[x] != 0 ? h - f : 0;
        sum[x] += n[x] != 0 ? h + f : 0;
      }
    }
    for (int64_t x = 0; x < out.width; ++x) {
      float d = 0, t = 0;
      for (int64_t u = std::max<int64_t>(x - columns, 0); u < std::min(x + columns + 1, out.width); ++u) {
        d += difference[u];
        t += sum[u];
      }
      if (t != 0) to[x] += std::fabs(d) / t;
    }
  }
};

}  // namespace

std::unique_ptr<Step> make_step(const graph::Recall& op, const graph::Node& node, StepContext& context) {
  return std::make_unique<RecallStep>(op, node, context);
}
std::unique_ptr<Step> make_step(const graph::Compare& op, const graph::Node& node, StepContext& context) {
  const CompareRow row = {op.radius, context.input(node, 0), context.input(node, 1), context.input(node, 2),
                          context.output(node)};
  return row_step(context, node, row.scratch(), row);
}
std::unique_ptr<TileStep> make_step(const graph::Remember&, const graph::Node& node, StepContext& context) {
  const RowWindow logit = context.input(node, 0), light = context.input(node, 1),
                  past = context.input(node, 2), frames = context.input(node, 3),
                  drawn = context.input(node, 4), out = context.output(node, 0),
                  counted = context.output(node, 1);
  return tile_step(context, 3 * kTilePixels, [=](const PixelTile& tile, float* __restrict k) {
    const float* __restrict before = frames.at(tile).data;
    const float* __restrict z = logit.at(tile).data;
    const float* __restrict valid = drawn.at(tile).data;
    float* __restrict count = counted.at(tile).data;
    for (int64_t x = 0; x < tile.count; ++x) {
      const float n = before[x] == 0 ? 1 : before[x];
      k[x] = before[x] == 0 ? 0 : 1 / (1 + std::exp(-(z[x] + std::log(n))));
      const float share = (1 - k[x]) * (1 - k[x]) * n + k[x] * k[x];
      count[x] = valid[x] * std::min(n / share, float(kLongestHistory));
    }
    float* __restrict believed = k + kTilePixels, * __restrict most = believed + kTilePixels;
    std::fill_n(believed, tile.count, 0.0f);
    std::fill_n(most, tile.count, 0.0f);
    for (int64_t c = 0; c < 3; ++c) {
      const float* __restrict f = light.at(tile, c).data;
      const float* __restrict h = past.at(tile, c).data;
      for (int64_t x = 0; x < tile.count; ++x) {
        most[x] += std::min(f[x], float(kLargestCompared));
        believed[x] += std::min(h[x], float(kLargestCompared));
      }
    }
    for (int64_t x = 0; x < tile.count; ++x)
      believed[x] = believed[x] == 0 ? 1 : std::min(float(kBrightestHistory) * most[x] / believed[x], 1.0f);
    for (int64_t c = 0; c < out.planes; ++c) {
      const float* __restrict f = light.at(tile, c).data;
      const float* __restrict h = past.at(tile, c).data;
      float* __restrict to = out.at(tile, c).data;
      for (int64_t x = 0; x < tile.count; ++x) to[x] = f[x] + k[x] * (believed[x] * h[x] - f[x]);
    }
  });
}

}  // namespace ld
