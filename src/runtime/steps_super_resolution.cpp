// Light at half resolution, sub-pixel convolutions, and what borders repeat
// (models/networks/espcn_kpcn_network.cpp).
#include <algorithm>
#include <cmath>

#include "core/tone_map.h"
#include "ops/kernels/convolution.h"
#include "ops/kernels/tone_map_row.h"
#include "runtime/parallel.h"
#include "runtime/row_step.h"
#include "runtime/tile_step.h"

namespace ld {
namespace {

class EdgeConvolutionStep : public Step {
 public:
  EdgeConvolutionStep(const graph::EdgeConvolution& op, const graph::Node& node, StepContext& context)
      : op_(op),
        context_(context),
        out_(context.output(node)),
        weights_(context.weights.at(op.weights + ".weight").values.data(),
                 context.weights.at(op.weights + ".bias").values.data(), out_.planes,
                 context.weights.at(op.weights + ".weight").shape[1], op.kernel) {
    for (size_t i = 0; i < node.inputs.size(); ++i) inputs_.push_back(context.input(node, i));
    for (int t = 0; t < context.threads; ++t) {
      scratch_.push_back(hwy::AllocateAligned<float>(size_t(rows_floats())));
      std::fill_n(scratch_.back().get(), rows_floats(), 0.0f);
    }
  }

  int64_t scratch_bytes(int64_t) const override {
    return context_.threads * rows_floats() * int64_t(sizeof(float));
  }

  void run(int64_t begin, int64_t end) override {
    for_each_stretch(context_.threads, begin, end, out_.width, kStretch,
                     [&](int64_t y, int64_t x, int64_t count, int thread) {
                       float* rows = scratch_[size_t(thread)].get() + kPixelStep;
                       ConvolutionSource source;
                       source.channels = weights_.inputs;
                       for (int64_t i = 0; i < op_.kernel; ++i) {
                         float* row = rows + i * weights_.inputs * kPitch;
                         copy_row(y + i - radius(), x, count, row);
                         source.rows[size_t(i)] = {row, kPitch};
                       }
                       convolve({&weights_,
                                 {source},
                                 out_.row(y) + x,
                                 out_.pitch,
                                 0,
                                 padded(count),
                                 out_.width - x,
                                 op_.activation});
                     });
  }

 private:
  static constexpr int64_t kStretch = 480;  // pixels: whole blocks of every vector width
  static constexpr int64_t kPitch = kStretch + 2 * kPixelStep;

  int64_t radius() const { return op_.kernel / 2; }
  int64_t rows_floats() const { return op_.kernel * weights_.inputs * kPitch + kPixelStep; }

  /// Pixels [x - radius, x + count + radius) of a row of all inputs to `to` - radius: those of the border for
  /// what is beyond.
  void copy_row(int64_t y, int64_t x, int64_t count, float* to) const {
    for (const RowWindow& in : inputs_) {
      const int64_t row = std::clamp<int64_t>(y, 0, in.height - 1);
      for (int64_t c = 0; c < in.planes; ++c, to += kPitch) {
        const float* from = in.row(row, c);
        std::copy_n(from + x, count, to);
        for (int64_t i = 1; i <= radius(); ++i) {
          to[-i] = from[std::max<int64_t>(x - i, 0)];
          to[count + i - 1] = from[std::min(x + count + i - 1, in.width - 1)];
        }
      }
    }
  }

  graph::EdgeConvolution op_;
  StepContext& context_;
  std::vector<RowWindow> inputs_;
  RowWindow out_;
  PackedConvolution weights_;
  std::vector<Floats> scratch_;  // of each thread: rows of all channels
};

/// Of HalveLight.
struct HalveLightRow {
  graph::HalveLight op;
  RowWindow light, drawn, reflectance, half_light, known, half_reflectance;
  bool demodulates;

  int64_t scratch() const { return 4 * half_light.width; }

  void operator()(int64_t y, float* shares) const {
    const int64_t width = half_light.width;
    for (int64_t x = 0; x < width; ++x) {
      float count = 0;
      for (int64_t i = 0; i < 4; ++i) {
        const float is_drawn = pixel(drawn, y, 0, x, i);
        shares[i * width + x] = is_drawn;
        count += is_drawn;
      }
      known.row(y)[x] = count > 0 ? 1.0f : 0.0f;
      for (int64_t i = 0; i < 4; ++i) shares[i * width + x] /= std::max(count, 1.0f);
    }
    for (int64_t c = 0; c < 3; ++c) {
      float* to = half_light.row(y, c);
      average(light, y, c, shares, to);
      if (!op.mapped)
        for (int64_t x = 0; x < width; ++x) to[x] = std::min(to[x], kHalfMax);
      if (!demodulates) {
        if (!op.mapped) tone_map_row(to, to, width);
        continue;
      }
      float* divisor = half_reflectance.row(y, c);
      average(reflectance, y, c, shares, divisor);
      for (int64_t x = 0; x < width; ++x) {
        if (known.row(y)[x] == 0) divisor[x] = 1;
        to[x] = (op.mapped ? tone_map_inverse(to[x]) : to[x]) / divisor[x];
      }
      tone_map_row(to, to, width);
    }
  }

  /// The i-th of the four pixels that become one; the border's where there is none.
  static float pixel(const RowWindow& in, int64_t y, int64_t plane, int64_t x, int64_t i) {
    return in.row(std::min(2 * y + i / 2, in.height - 1), plane)[std::min(2 * x + i % 2, in.width - 1)];
  }

  void average(const RowWindow& in, int64_t y, int64_t plane, const float* shares, float* to) const {
    for (int64_t x = 0; x < half_light.width; ++x) {
      float sum = 0;
      for (int64_t i = 0; i < 4; ++i) sum += shares[i * half_light.width + x] * pixel(in, y, plane, x, i);
      to[x] = sum;
    }
  }
};

}  // namespace

std::unique_ptr<Step> make_step(const graph::EdgeConvolution& op, const graph::Node& node,
                                StepContext& context) {
  return std::make_unique<EdgeConvolutionStep>(op, node, context);
}

std::unique_ptr<Step> make_step(const graph::HalveLight& op, const graph::Node& node, StepContext& context) {
  const bool demodulates = node.inputs.size() > 2;
  const HalveLightRow row = {op,
                             context.input(node, 0),
                             context.input(node, 1),
                             demodulates ? context.input(node, 2) : RowWindow(),
                             context.output(node, 0),
                             context.output(node, 1),
                             demodulates ? context.output(node, 2) : RowWindow(),
                             demodulates};
  return row_step(context, node, row.scratch(), row);
}

std::unique_ptr<Step> make_step(const graph::SpaceToDepth&, const graph::Node& node, StepContext& context) {
  const RowWindow in = context.input(node, 0), out = context.output(node);
  return row_step(context, node, 0, [=](int64_t y, float*) {
    for (int64_t c = 0; c < out.planes; ++c) {
      const float* from = in.row(std::min(2 * y + c % 4 / 2, in.height - 1), c / 4);
      float* to = out.row(y, c);
      for (int64_t x = 0; x < out.width; ++x) to[x] = from[std::min(2 * x + c % 2, in.width - 1)];
    }
  });
}

std::unique_ptr<Step> make_step(const graph::DepthToSpace&, const graph::Node& node, StepContext& context) {
  const RowWindow in = context.input(node, 0), out = context.output(node);
  return row_step(context, node, 0, [=](int64_t y, float*) {
    for (int64_t c = 0; c < out.planes; ++c)
      for (int64_t j = 0; j < 2; ++j) {
        const float* from = in.row(y / 2, 4 * c + y % 2 * 2 + j);
        float* to = out.row(y, c);
        for (int64_t x = j; x < out.width; x += 2) to[x] = from[x / 2];
      }
  });
}

std::unique_ptr<TileStep> make_step(const graph::Relight&, const graph::Node& node, StepContext& context) {
  const RowWindow mapped = context.input(node, 0), out = context.output(node);
  if (node.inputs.size() == 1)
    return tile_step(context, 0, [=](const PixelTile& tile, float*) {
      for (int64_t c = 0; c < 3; ++c)
        for (int64_t x = 0; x < tile.count; ++x)
          out.at(tile, c).data[x] = tone_map_inverse(mapped.at(tile, c).data[x]);
    });
  const RowWindow own = context.input(node, 1), drawn = context.input(node, 2),
                  otherwise = context.input(node, 3);
  return tile_step(context, 0, [=](const PixelTile& tile, float*) {
    for (int64_t c = 0; c < 3; ++c)
      for (int64_t x = 0; x < tile.count; ++x) {
        const RowWindow& reflectance = drawn.at(tile).data[x] > 0 ? own : otherwise;
        out.at(tile, c).data[x] =
            tone_map_inverse(mapped.at(tile, c).data[x]) * reflectance.at(tile, c).data[x];
      }
  });
}

std::unique_ptr<TileStep> make_step(const graph::Channels& op, const graph::Node& node,
                                    StepContext& context) {
  const RowWindow in = context.input(node, 0), out = context.output(node);
  const int64_t items = context.items(node.outputs[0]), count = out.planes / items, all = in.planes / items;
  return tile_step(context, 0, [=](const PixelTile& tile, float*) {
    for (int64_t c = 0; c < out.planes; ++c)
      std::copy_n(in.at(tile, c / count * all + op.first + c % count).data, padded(tile.count),
                  out.at(tile, c).data);
  });
}

std::unique_ptr<TileStep> make_step(const graph::Add&, const graph::Node& node, StepContext& context) {
  const RowWindow a = context.input(node, 0), b = context.input(node, 1), out = context.output(node);
  return tile_step(context, 0, [=](const PixelTile& tile, float*) {
    for (int64_t c = 0; c < out.planes; ++c) {
      const float* __restrict x = a.at(tile, c).data, * __restrict y = b.at(tile, c).data;
      float* __restrict to = out.at(tile, c).data;
      for (int64_t i = 0; i < tile.count; ++i) to[i] = x[i] + y[i];
    }
  });
}

}  // namespace ld
