// From layers to the picture: kernels, compositing and modulation.
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <deque>
#include <limits>
#include <optional>
#include <thread>

#include "models/network_numbers.h"
#include "ops/kernels/sample_tile.h"
#include "ops/kernels/splat.h"
#include "runtime/empty_layers.h"
#include "runtime/fully_connected_rows.h"
#include "runtime/parallel.h"
#include "runtime/tile_step.h"

namespace ld {
namespace {

class SplatStep : public Step {
 public:
  SplatStep(const graph::Splat& op, const graph::Node& node, StepContext& context)
      : op_(op),
        node_(node),
        context_(context),
        embedding_(context.input(node, 0)),
        shared_(context.input(node, 1)),
        log_n_(context.input(node, 2)),
        out_(context.output(node)),
        network_(tile_network(op.generator, context.weights, embedding_.planes / log_n_.planes,
                              op.kernel * op.kernel)) {
    int64_t channels = 0;
    for (size_t i = 3; i < node.inputs.size(); ++i) {
      values_.push_back(context.input(node, i));
      channels += values_.back().planes / log_n_.planes;
    }
    shape_ = {log_n_.planes, op.kernel, channels, embedding_.height, embedding_.width};
    // What is filtered is the first of them; the last channels of that are parts.
    main_ = context.graph[node.inputs[3]].channels - context.graph[node.inputs[3]].parts;
    parts_ = context.graph[node.inputs[3]].parts;
    pixels_ = stretch_pixels(shape_.layers * shape_.taps(), shape_.width);
    finds_empty_ = context.skips && shape_.layers > 1 && values_.size() == 2 && is_composited(node);
    for (int t = 0; t < context.threads; ++t) workers_.emplace_back(network_, shape_, pixels_);
  }

  void start() override {
    while (!strips_.empty()) drop_front();
    next_ = 0;
  }

  int64_t scratch_bytes(int64_t rows) const override {
    const int64_t strips = (rows + 2 * shape_.radius()) / op_.rows + 2,
                  most = (shape_.height + op_.rows - 1) / op_.rows;
    const SplatStrip one(shape_, op_.joint, 0, std::min(op_.rows, shape_.height));
    const int64_t of_layers = finds_empty_ ? EmptyLayers::bytes(shape_, op_.rows) : 0;
    return std::min(strips, most) * (one.floats() * int64_t(sizeof(float)) + of_layers);
  }

  void run(int64_t begin, int64_t end) override {
    add_strips((std::min(end + shape_.radius(), shape_.height) + op_.rows - 1) / op_.rows);
    std::vector<SplatStrip*> strips;
    for (const auto& strip : strips_) strips.push_back(&strip->sums);
    parallel_for(context_.threads, end - begin, [&](int64_t i, int thread) {
      const int64_t y = begin + i;
      merge_row(shape_, op_.joint, strips, y, {out_.row(y), nullptr, nullptr, out_.pitch});
      for (int64_t c = 0; c < out_.planes; ++c)
        if (const float scale = scale_of(c % shape_.channels); scale != 1)
          for (int64_t x = 0; x < out_.width; ++x) out_.row(y, c)[x] /= scale;
      for (const auto& strip : strips_)
        if (strip->looked)
          context_.empty_layers[size_t(thread)] += strip->empty->fill(y, {out_.row(y), out_.pitch});
    });
    while (!strips_.empty() && reach_of_front() <= end) drop_front();
  }

 private:
  struct Worker {
    TileNetwork::Scratch scratch;
    SplatSourcesRow sources;
    std::vector<float> finite;
    Worker(const TileNetwork& network, const FilterShape& shape, int64_t pixels)
        : scratch(network.make_scratch(pixels, false)), sources(shape, pixels), finite(size_t(pixels)) {}
  };

  struct Strip {
    SplatStrip sums;
    std::optional<EmptyLayers> empty;
    bool looked = false;
  };

  /// Whether the layers of the result are composited ([MH20] eq. 5), and nothing else becomes of them.
  bool is_composited(const graph::Node& node) const {
    const graph::Graph& graph = context_.graph;
    const graph::ValueId result = node.outputs[0];
    const std::vector<graph::ValueId> outputs = graph.outputs();
    bool composited = false, other = std::find(outputs.begin(), outputs.end(), result) != outputs.end();
    for (const graph::Node& reader : graph.nodes)
      if (std::find(reader.inputs.begin(), reader.inputs.end(), result) != reader.inputs.end())
        (std::holds_alternative<graph::Composite>(reader.op) ? composited : other) = true;
    return composited && !other;
  }

  /// Keeps the memory of a strip that has all of its rows: it does for every other.
  void drop_front() {
    const int64_t number = next_ - int64_t(strips_.size());
    if ((number + 1) * op_.rows <= shape_.height) spare_.push_back(std::move(strips_.front()));
    strips_.pop_front();
  }

  /// One past the last row that the first strip reaches.
  int64_t reach_of_front() const {
    const int64_t number = next_ - int64_t(strips_.size());
    return std::min((number + 1) * op_.rows + shape_.radius(), shape_.height);
  }

  /// Sums up the sources of all strips before `count`. Stretches reach into one another's columns: first come
  /// the even ones of all strips, then the odd ones, each after its neighbours, whatever the threads.
  void add_strips(int64_t count) {
    const auto first = int64_t(strips_.size());
    for (; next_ < count; ++next_) {
      strips_.push_back(begin_strip(next_ * op_.rows));
      look_at_layers(*strips_.back(), next_ * op_.rows);
    }
    const int64_t made = int64_t(strips_.size()) - first, number = next_ - made;
    const int64_t stretches = (shape_.width + pixels_ - 1) / pixels_, even = (stretches + 1) / 2;
    std::vector<std::atomic<bool>> done(size_t(made * stretches));
    parallel_for(context_.threads, made * stretches, [&](int64_t i, int thread) {
      const bool odd = i >= made * even;
      const int64_t of_strip = odd ? stretches - even : even, at = odd ? i - made * even : i;
      const int64_t strip = at / of_strip, stretch = 2 * (at % of_strip) + (odd ? 1 : 0);
      const auto is_done = [&](int64_t other) -> std::atomic<bool>& {
        return done[size_t(strip * stretches + other)];
      };
      for (const int64_t other : {stretch - 1, stretch + 1})
        if (odd && other < stretches)
          while (!is_done(other).load(std::memory_order_acquire)) std::this_thread::yield();
      add_column((number + strip) * op_.rows, stretch * pixels_, workers_[size_t(thread)],
                 *strips_[size_t(first + strip)]);
      is_done(stretch).store(true, std::memory_order_release);
    });
  }

  std::unique_ptr<Strip> begin_strip(int64_t first) {
    const int64_t last = std::min(first + op_.rows, shape_.height);
    if (spare_.empty()) {
      auto made = std::make_unique<Strip>(Strip{{shape_, op_.joint, first, last}, std::nullopt});
      if (finds_empty_) made->empty.emplace(shape_, op_.rows);
      return made;
    }
    std::unique_ptr<Strip> strip = std::move(spare_.back());
    spare_.pop_back();
    strip->sums.restart(shape_, first, last);
    return strip;
  }

  void look_at_layers(Strip& strip, int64_t first) const {
    // Values that filters scale are no longer those that were looked at.
    strip.looked = strip.empty && context_.source->light.value_scale == 1;
    if (strip.looked)
      strip.empty->look({values_[0], values_[1], context_.demand.rows(node_.inputs[4])}, first,
                        std::min(first + op_.rows, shape_.height), context_.threads);
  }

  /// The stretches at `x` of a strip's sources: the rows that one reaches stay in the cache for the next.
  void add_column(int64_t first, int64_t x, Worker& worker, Strip& strip) const {
    const SplatSkips* skips = strip.looked ? &strip.empty->skips() : nullptr;
    for (int64_t y = first; y < std::min(first + op_.rows, shape_.height); ++y) {
      const Stretch at{y, x, std::min(pixels_, shape_.width - x)};
      if (!context_.demand.wants(node_.inputs[0], y, x, at.count)) continue;
      stage_stretch(at, worker);
      splat_exponents(shape_, worker.sources, at.count);
      splat_stretch(shape_, worker.sources, at, strip.sums, skips);
    }
  }

  void stage_stretch(const Stretch& at, Worker& worker) const {
    SplatSourcesRow& sources = worker.sources;
    network_.begin_tile(worker.scratch, at.count, {shared_.row(at.y) + at.x, shared_.pitch});
    for (int64_t l = 0; l < shape_.layers; ++l)
      network_.forward(worker.scratch, at.count,
                       {embedding_.row(at.y, l * network_.x_inputs()) + at.x, embedding_.pitch},
                       {sources.logits.row(l * shape_.taps()), sources.logits.pitch()});
    stage({log_n_.row(at.y) + at.x, shape_.layers, log_n_.pitch}, at.count, sources.log_n.row(0),
          sources.log_n.pitch());
    for (int64_t l = 0; l < shape_.layers; ++l) stage_values(at, l, worker);
  }

  bool is_part(int64_t channel) const { return channel >= main_ && channel < main_ + parts_; }
  float scale_of(int64_t channel) const {
    return is_part(channel) ? context_.source->light.part_scale : context_.source->light.value_scale;
  }

  /// A pixel's layer whose values or weight are not finite sends nothing (ops/finite_sources.h). Parts have
  /// no say in that: they are finite.
  void stage_values(const Stretch& at, int64_t l, Worker& worker) const {
    SplatSourcesRow& sources = worker.sources;
    float* log_n = sources.log_n.row(l);
    float* finite = worker.finite.data();
    for (int64_t x = 0; x < at.count; ++x)
      finite[x] = log_n[x] < std::numeric_limits<float>::infinity() ? 1.0f : 0.0f;
    int64_t c = 0;
    for (const RowWindow& values : values_) {
      const int64_t channels = values.planes / shape_.layers;
      for (int64_t i = 0; i < channels; ++i, ++c) {
        const float* __restrict from = values.row(at.y, l * channels + i) + at.x;
        float* __restrict to = sources.values.row(l * shape_.channels + c);
        const float scale = scale_of(c);
        for (int64_t x = 0; x < at.count; ++x) {
          const bool good = std::fabs(from[x]) <= std::numeric_limits<float>::max();
          to[x] = good ? from[x] * scale : 0.0f;
          finite[x] = good ? finite[x] : 0.0f;
        }
        std::fill(to + at.count, to + padded(at.count), 0.0f);
      }
    }
    for (int64_t x = 0; x < at.count; ++x)
      if (finite[x] == 0) {
        log_n[x] = -std::numeric_limits<float>::infinity();
        for (int64_t i = 0; i < shape_.channels; ++i) sources.values.row(l * shape_.channels + i)[x] = 0;
      }
  }

  graph::Splat op_;
  const graph::Node& node_;
  StepContext& context_;
  RowWindow embedding_, shared_, log_n_, out_;
  std::vector<RowWindow> values_;
  TileNetwork network_;
  FilterShape shape_{};
  int64_t main_ = 0, parts_ = 0;  // channels
  int64_t pixels_ = 0;
  std::vector<Worker> workers_;
  bool finds_empty_ = false;                   // layers without influence
  std::deque<std::unique_ptr<Strip>> strips_;  // those that rows to come still need
  std::vector<std::unique_ptr<Strip>> spare_;  // memory of those that are done
  int64_t next_ = 0;                           // the number of the first strip that is not made
};

/// The network reads how steady the divisors are, and the context.
class ModulationFactorsStep : public Step {
 public:
  ModulationFactorsStep(const graph::ModulationFactors& op, const graph::Node& node, StepContext& context)
      : node_(node),
        context_(context),
        modulators_(context.input(node, 0)),
        shared_(context.input(node, 1)),
        out_(context.output(node)),
        network_(tile_network({op.weights, {1}}, context.weights, 1, 1)),
        scratch_(network_.make_scratches(context.threads, kTilePixels)) {}

  void run(int64_t begin, int64_t end) override {
    for_each_stretch(context_.threads, begin, end, out_.width, kTilePixels,
                     [&](int64_t y, int64_t x, int64_t count, int thread) {
                       if (context_.demand.wants(node_, y, x, count)) make({y, x, count, thread});
                     });
  }

 private:
  void make(const PixelTile& tile) {
    TileNetwork::Scratch& scratch = scratch_[size_t(tile.thread)];
    std::array<const float*, 3> variances = {};
    for (int64_t i = 0; i < 3; ++i)
      if (const int64_t y = tile.y - 1 + i; y >= 0 && y < modulators_.height)
        variances[size_t(i)] = modulators_.row(y, 3);
    steadiness({variances, out_.width}, float(kSteadyFalloff), tile.x, tile.count, scratch.x);
    network_.begin_tile(scratch, tile.count, shared_.at(tile));
    network_.forward(scratch, tile.count);
    modulation_factors(modulators_.at(tile), scratch.a.back(), padded(tile.count), out_.at(tile));
  }

  const graph::Node& node_;
  StepContext& context_;
  RowWindow modulators_, shared_, out_;
  TileNetwork network_;
  std::vector<TileNetwork::Scratch> scratch_;  // of each thread
};

}  // namespace

std::unique_ptr<Step> make_step(const graph::Splat& op, const graph::Node& node, StepContext& context) {
  return std::make_unique<SplatStep>(op, node, context);
}
std::unique_ptr<TileStep> make_step(const graph::Mix&, const graph::Node& node, StepContext& context) {
  const RowWindow logit = context.input(node, 0), valid = context.input(node, 1),
                  first = context.input(node, 2), second = context.input(node, 3), out = context.output(node);
  return tile_step(context, kTilePixels, [=](const PixelTile& tile, float* __restrict k) {
    for (int64_t x = 0; x < tile.count; ++x)
      k[x] = valid.at(tile).data[x] / (1 + std::exp(-logit.at(tile).data[x]));
    for (int64_t c = 0; c < out.planes; ++c) {
      const float* __restrict a = first.at(tile, c).data;
      const float* __restrict b = second.at(tile, c).data;
      float* __restrict to = out.at(tile, c).data;
      for (int64_t x = 0; x < tile.count; ++x) to[x] = k[x] * a[x] + (1 - k[x]) * b[x];
    }
  });
}
std::unique_ptr<TileStep> make_step(const graph::Composite&, const graph::Node& node, StepContext& context) {
  const RowWindow in = context.input(node, 0), out = context.output(node);
  return tile_step(context, kTilePixels, [=](const PixelTile& tile, float* __restrict visible) {
    const int64_t colours = out.planes, count = tile.count, layers = in.planes / (colours + 1);
    for (int64_t c = 0; c < colours; ++c) std::copy_n(in.at(tile, c).data, count, out.at(tile, c).data);
    std::copy_n(in.at(tile, colours).data, count, visible);
    for (int64_t l = 1; l < layers; ++l) {
      for (int64_t c = 0; c < colours; ++c) {
        const float* __restrict layer = in.at(tile, l * (colours + 1) + c).data;
        float* __restrict to = out.at(tile, c).data;
        for (int64_t x = 0; x < count; ++x) to[x] += visible[x] * layer[x];
      }
      const float* __restrict transmittance = in.at(tile, l * (colours + 1) + colours).data;
      for (int64_t x = 0; x < count; ++x) visible[x] *= transmittance[x];
    }
  });
}
std::unique_ptr<Step> make_step(const graph::ModulationFactors& op, const graph::Node& node,
                                StepContext& context) {
  return std::make_unique<ModulationFactorsStep>(op, node, context);
}
std::unique_ptr<TileStep> make_step(const graph::Modulate&, const graph::Node& node, StepContext& context) {
  const RowWindow filtered = context.input(node, 0), factors = context.input(node, 1),
                  out = context.output(node);
  return tile_step(context, 0, [=](const PixelTile& tile, float*) {
    modulate({filtered.at(tile), factors.at(tile), out.planes - 3, float(kLargestModulated),
              padded(tile.count), out.at(tile)});
  });
}

}  // namespace ld
