#include "runtime/executor.h"

#include <algorithm>
#include <chrono>
#include <numeric>
#include <type_traits>
#include <variant>

#include "core/error.h"
#include "runtime/arena.h"
#include "runtime/denormals.h"
#include "runtime/light_ranges.h"
#include "runtime/parallel.h"
#include "runtime/sample_source.h"
#include "runtime/step.h"
#include "runtime/tile_unit.h"

namespace ld {

using graph::ValueId;

namespace {

constexpr double kProgressSteps = 64;

/// Enough pixels for the threads, and so few rows that they stay in the caches: every operator on the way
/// through the U-net keeps a block waiting.
int64_t default_block(int threads, int64_t width) {
  constexpr int64_t kPixels = 16384, kFewest = 8;
  return std::max(kPixels * std::max(threads, 1) / width / kFewest * kFewest, kFewest);
}

std::unique_ptr<Step> make_unit(const Unit& unit, StepContext& context) {
  const graph::Node& first = context.graph.nodes[unit.nodes[0]];
  if (graph::is_pixelwise(first.op)) return std::make_unique<TileUnit>(unit, context);
  return std::visit(
      [&](const auto& op) -> std::unique_ptr<Step> {
        using Made = decltype(make_step(op, first, context));
        if constexpr (std::is_same_v<Made, std::unique_ptr<Step>>) return make_step(op, first, context);
        return nullptr;  // pixelwise: made above
      },
      first.op);
}

}  // namespace

struct Execution::State {
  int64_t block;
  StepContext context;
  RowSchedule schedule;
  int64_t arena_floats;
  Arena arena;
  std::vector<std::unique_ptr<Step>> steps;  // of each unit
  std::vector<ValueId> outputs;
  std::vector<double> row_work;  // of each unit, a row of its output
  decltype(ExecutionOptions::made) made;
  FrameState* left = nullptr;  // of the frame that runs
  std::optional<LightRanges> ranges;
  int64_t even_pixels = 0;  // of the frame that runs
  double work = 0;

  State(const graph::Graph& graph, const NamedWeights& weights, const PictureExtent& picture,
        const ExecutionOptions& options)
      : block(options.block_rows > 0 ? options.block_rows : default_block(options.threads, picture.width)),
        context{graph, weights, picture, std::max(options.threads, 1), {}, {graph, picture}},
        schedule(graph, picture, block),
        arena_floats(make_windows()),
        arena(arena_floats),
        outputs(graph.outputs()),
        made(options.made) {
    float* next = arena.begin();
    for (RowWindow& window : context.windows) {
      window.memory = next;
      next += Arena::round_up(window.floats());
    }
    context.skips = options.skip_within.has_value();
    if (context.skips && graph.outputs().size() == 1 && graph.state.empty())
      if (const auto reach = graph::light_reach(graph))
        ranges.emplace(*reach, picture, 3 + graph.parts.channels(), *options.skip_within);
    for (const Unit& unit : schedule.units()) {
      steps.push_back(make_unit(unit, context));
      row_work.push_back(0);
      for (const size_t n : unit.nodes) row_work.back() += work_of_row(graph.nodes[n]);
      work += row_work.back() * double(extent_of(graph, unit.outputs[0], picture).height);
    }
  }

  bool is_image_of(const Image& image, ValueId id) const {
    const ValueExtent extent = extent_of(context.graph, id, context.picture);
    return image.width == extent.width && image.height == extent.height && image.channels == extent.planes;
  }

  /// Planes for what a frame leaves; none where nobody keeps it.
  void make_state(FrameState* after) {
    left = after;
    if (left == nullptr) return;
    left->clear();
    for (const ValueId id : context.graph.state) {
      const ValueExtent extent = extent_of(context.graph, id, context.picture);
      left->emplace_back(int(extent.width), int(extent.height), int(extent.planes));
    }
  }

  /// What was made of the state.
  void keep_state(const Unit& unit, int64_t begin, int64_t end) {
    if (left == nullptr) return;
    for (size_t i = 0; i < left->size(); ++i) {
      const ValueId id = context.graph.state[i];
      if (std::find(unit.outputs.begin(), unit.outputs.end(), id) == unit.outputs.end()) continue;
      Image& image = (*left)[i];
      for (int64_t y = begin; y < end; ++y)
        for (int c = 0; c < image.channels; ++c)
          std::copy_n(context.windows[id].row(y, c), image.width, &image.at(c, 0, int(y)));
    }
  }

  /// Nothing, or what such a graph leaves.
  void expect_state(const FrameState& before) const {
    const std::vector<ValueId>& state = context.graph.state;
    if (before.empty()) return;
    bool fits = before.size() == state.size();
    for (size_t i = 0; fits && i < state.size(); ++i) fits = is_image_of(before[i], state[i]);
    if (!fits)
      fail("the state of a frame before is not one of this network's for {}x{} pixels; begin without one",
           context.picture.width, context.picture.height);
  }

  /// What one frame leaves for the next.
  int64_t state_bytes() const {
    int64_t floats = 0;
    for (const ValueId id : context.graph.state) {
      const ValueExtent extent = extent_of(context.graph, id, context.picture);
      floats += extent.planes * extent.height * extent.width;
    }
    return floats * int64_t(sizeof(float));
  }

  double work_of_row(const graph::Node& node) const {
    const ValueExtent extent = extent_of(context.graph, node.outputs[0], context.picture);
    const graph::NodeCost cost = cost_of(context.graph, node, context.picture);
    // What is moved counts for a few multiply-adds.
    return (cost.weights + cost.taps) / double(extent.height) + 4 * double(extent.planes * extent.width);
  }

  /// Floats of all windows.
  int64_t make_windows() {
    context.windows.resize(context.graph.values.size());
    for (const Unit& unit : schedule.units())
      for (const size_t n : unit.nodes)
        for (const ValueId id : context.graph.nodes[n].outputs) context.windows[id] = window_of(unit, id);
    int64_t floats = 0;
    for (const RowWindow& window : context.windows) floats += Arena::round_up(window.floats());
    return floats;
  }

  RowWindow window_of(const Unit& unit, ValueId id) const {
    const ValueExtent extent = extent_of(context.graph, id, context.picture);
    if (schedule.capacity(id) > 0) return {extent.planes, extent.width, extent.height, schedule.capacity(id)};
    return RowWindow::of_tiles(extent.planes, extent.width, extent.height, context.threads,
                               tile_pixels(context.graph, unit, context.picture));
  }

  void begin(SampleSource& source, const FrameState& before) {
    const PictureExtent &picture = context.picture, given = source.extent();
    if (!(given == picture))
      fail("a frame of {}x{} pixels at {} samples, expected {}x{} at {}", given.width, given.height,
           given.samples, picture.width, picture.height, picture.samples);
    if (!(source.depth_scale > 0)) fail("a frame without a depth scale; expected a number above 0");
    const graph::LightParts &parts = context.graph.parts, held = source.parts();
    if (held.colours < parts.colours || (parts.alpha && !held.alpha))
      fail("a frame of {} light parts{}; expected {}{}", held.colours, held.alpha ? "" : " without alpha",
           parts.colours, parts.alpha ? " and alpha" : "");
    context.source = &source;
    expect_state(before);
    context.before = before.empty() ? nullptr : &before;
    context.seconds.assign(context.graph.nodes.size(), 0);
    context.copied.assign(size_t(context.threads), 0);
    context.empty_layers.assign(size_t(context.threads), 0);
    want_uneven_pixels(source);
    for (const auto& step : steps) step->start();
  }

  LightRanges* ranges_of(const PictureExtent& given) {
    return ranges && given == context.picture ? &*ranges : nullptr;
  }

  /// Only those of the picture that are not known beforehand.
  void want_uneven_pixels(SampleSource& source) {
    even_pixels = 0;
    if (!ranges) return;
    ranges->find_even(source, context.threads);
    const std::vector<graph::Span> uneven = ranges->uneven_rows();
    even_pixels = context.picture.height * context.picture.width;
    for (const graph::Span& row : uneven) even_pixels -= row.end - row.begin;
    if (even_pixels > 0)
      context.demand.want(uneven);
    else
      context.demand.want_all();
  }

  /// The others, of rows that are made.
  void fill_even_pixels(int64_t begin, int64_t end) {
    if (even_pixels == 0) return;
    const RowWindow& out = context.windows[outputs[0]];
    parallel_for(context.threads, end - begin, [&](int64_t i, int) {
      ranges->fill(begin + i, {out.row(begin + i), out.pitch});
    });
  }

  Skipped skipped() const {
    const auto sum = [](const std::vector<int64_t>& of_threads) {
      return double(std::accumulate(of_threads.begin(), of_threads.end(), int64_t{0}));
    };
    double samples = 0, layers = 0;
    for (const graph::Node& node : context.graph.nodes) {
      const ValueExtent extent = extent_of(context.graph, node.outputs[0], context.picture);
      const double items = double(context.items(node.outputs[0]) * extent.height * extent.width);
      if (std::holds_alternative<graph::FullyConnected>(node.op)) samples += items;
      if (std::holds_alternative<graph::Splat>(node.op)) layers += items;
    }
    return {double(even_pixels) / double(context.picture.height * context.picture.width),
            sum(context.copied) / std::max(samples, 1.0), sum(context.empty_layers) / std::max(layers, 1.0)};
  }

  void run(size_t unit, int64_t begin, int64_t end) {
    const auto start = std::chrono::steady_clock::now();
    steps[unit]->run(begin, end);
    const std::vector<size_t>& nodes = schedule.units()[unit].nodes;
    if (!graph::is_pixelwise(context.graph.nodes[nodes[0]].op))  // those know better
      context.seconds[nodes[0]] +=
          std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    keep_state(schedule.units()[unit], begin, end);
    if (!made) return;
    for (const ValueId value : schedule.units()[unit].outputs)
      made(value, context.windows[value], begin, end);
  }

  /// Makes all rows, and hands out those of the outputs.
  void walk(SampleSource& source, const Progress& progress, const Rows& rows, const FrameState& before,
            FrameState* after) {
    begin(source, before);
    make_state(after);
    double done = 0, told = 0;
    schedule.walk(
        [&](size_t unit, int64_t begin, int64_t end) {
          run(unit, begin, end);
          done += double(end - begin) * row_work[unit];
          const double share = std::min(done / work, 1.0);
          if (!progress || share - told < 1 / kProgressSteps) return;
          told = share;
          progress(share);
        },
        [&](int64_t first, int64_t last) {
          fill_even_pixels(first, last);
          rows(first, last);
        });
    if (progress && told < 1) progress(1);
  }
};

Execution::Execution(const graph::Graph& graph, const NamedWeights& weights, const PictureExtent& picture,
                     const ExecutionOptions& options)
    : state_(std::make_unique<State>(graph, weights, picture, options)) {}

Execution::~Execution() = default;

const PictureExtent& Execution::picture() const {
  return state_->context.picture;
}

int64_t Execution::block_rows() const {
  return state_->block;
}

int64_t Execution::arena_bytes() const {
  return state_->arena_floats * int64_t(sizeof(float));
}

int64_t Execution::memory_bytes() const {
  int64_t bytes = arena_bytes() + 2 * state_->state_bytes();  // the last frame's and this one's
  if (state_->ranges) bytes += state_->ranges->bytes();
  for (const auto& step : state_->steps) bytes += step->scratch_bytes(state_->block);
  // Steps have the weights in the order in which they read them.
  for (const graph::Parameter& parameter : graph::parameters(state_->context.graph))
    bytes += int64_t(state_->context.weights.at(parameter.name).values.size() * sizeof(float));
  return bytes;
}

const std::vector<double>& Execution::seconds() const {
  return state_->context.seconds;
}

Skipped Execution::skipped() const {
  return state_->skipped();
}

const float* Execution::row(size_t output, int64_t plane, int64_t y) const {
  return state_->context.windows[state_->outputs[output]].row(y, plane);
}

void Execution::run(const Frame& frame, const Progress& progress, const Rows& rows, const FrameState& before,
                    FrameState* after) {
  const FlushedDenormals flushed(state_->context.threads);
  FrameSource source(frame, state_->context.graph, state_->context.threads,
                     state_->ranges_of({frame.spp, frame.height, frame.width}));
  state_->walk(source, progress, rows, before, after);
}

void Execution::run(const SampleArrays& arrays, const Progress& progress, const Rows& rows,
                    const FrameState& before, FrameState* after) {
  const FlushedDenormals flushed(state_->context.threads);
  ArraySource source(arrays, state_->context.graph, state_->context.threads,
                     state_->ranges_of({arrays.spp, arrays.height, arrays.width}));
  state_->walk(source, progress, rows, before, after);
}

std::vector<Image> Execution::run(const Frame& frame, const Progress& progress, const FrameState& before) {
  std::vector<Image> images;
  for (const ValueId output : state_->outputs)
    images.emplace_back(frame.width, frame.height, int(state_->context.windows[output].planes));
  const Rows keep = [&](int64_t begin, int64_t end) {
    for (size_t i = 0; i < images.size(); ++i)
      for (int64_t y = begin; y < end; ++y)
        for (int c = 0; c < images[i].channels; ++c)
          std::copy_n(row(i, c, y), frame.width, &images[i].at(c, 0, int(y)));
  };
  FrameState after;
  run(frame, progress, keep, before, &after);
  for (Image& image : after) images.push_back(std::move(image));
  return images;
}

}  // namespace ld
