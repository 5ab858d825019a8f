#include "runtime/executor.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <variant>

#include "core/error.h"
#include "ops/kernels/constants.h"
#include "runtime/arena.h"
#include "runtime/denormals.h"
#include "runtime/frame_exposure.h"
#include "runtime/parallel.h"
#include "runtime/step.h"

namespace ld {

using graph::ValueId;

namespace {

// Above this the sums of filters could overflow (ops/finite_sources.h): demodulated radiance is up to 50
// times as large.
constexpr float kLargestRadiance = 1e32f / 50;

constexpr double kProgressSteps = 64;

/// What the values of planes plane_of(0) to plane_of(count - 1) are scaled by.
template <class PlaneOf>
float filter_scale(const Frame& frame, int threads, int64_t count, const PlaneOf& plane_of) {
  std::vector<float> largest(size_t(count), 0.0f);
  parallel_for(threads, count, [&](int64_t i, int) {
    const float* plane = plane_of(i);
    float most = 0;
    for (size_t p = 0; p < frame.plane_size(); ++p) most = std::max(most, std::fabs(plane[p]));
    largest[size_t(i)] = most;
  });
  const bool large =
      std::any_of(largest.begin(), largest.end(), [](float v) { return v > kLargestRadiance; });
  return large ? float(kOverflowScale) : 1.0f;
}

/// Enough pixels for the threads, and so few rows that they stay in the caches: every operator on the way
/// through the U-net keeps a block waiting.
int64_t default_block(int threads, int64_t width) {
  constexpr int64_t kPixels = 16384, kFewest = 8;
  return std::max(kPixels * std::max(threads, 1) / width / kFewest * kFewest, kFewest);
}

}  // namespace

std::unique_ptr<Step> make_step(const graph::Node& node, StepContext& context) {
  return std::visit([&](const auto& op) { return make_step(op, node, context); }, node.op);
}

struct Execution::State {
  int64_t block;
  StepContext context;
  RowSchedule schedule;
  int64_t arena_floats;
  Arena arena;
  std::vector<std::unique_ptr<Step>> steps;
  std::vector<ValueId> outputs;
  std::vector<double> row_work;  // of each node, a row of its output
  std::vector<double> seconds;   // of each node, in the frame that runs
  decltype(ExecutionOptions::made) made;
  double work = 0;

  State(const graph::Graph& graph, const NamedWeights& weights, const PictureExtent& picture,
        const ExecutionOptions& options)
      : block(options.block_rows > 0 ? options.block_rows : default_block(options.threads, picture.width)),
        context{graph, weights, picture, std::max(options.threads, 1), {}},
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
    for (const graph::Node& node : graph.nodes) {
      steps.push_back(make_step(node, context));
      const ValueExtent extent = extent_of(graph, node.outputs[0], picture);
      const graph::NodeCost cost = cost_of(graph, node, picture);
      // What is moved counts for a few multiply-adds.
      const double rows = double(extent.height);
      row_work.push_back((cost.weights + cost.taps) / rows + 4 * double(extent.planes * extent.width));
      work += row_work.back() * rows;
    }
  }

  /// Nothing, or what such a graph leaves.
  void expect_state(const FrameState& before) const {
    const std::vector<ValueId>& state = context.graph.state;
    if (before.empty()) return;
    bool fits = before.size() == state.size();
    for (size_t i = 0; fits && i < state.size(); ++i)
      fits = before[i].width == context.picture.width && before[i].height == context.picture.height &&
             before[i].channels == context.graph[state[i]].channels;
    if (!fits)
      fail("the state of a frame before is not one of this network's for {}x{} pixels; begin without one",
           context.picture.width, context.picture.height);
  }

  /// What one frame leaves for the next.
  int64_t state_bytes() const {
    int64_t planes = 0;
    for (const ValueId id : context.graph.state) planes += context.graph[id].channels;
    return planes * context.picture.height * context.picture.width * int64_t(sizeof(float));
  }

  /// Floats of all windows.
  int64_t make_windows() {
    int64_t floats = 0;
    for (ValueId id = 0; id < context.graph.values.size(); ++id) {
      const ValueExtent extent = extent_of(context.graph, id, context.picture);
      context.windows.emplace_back(extent.planes, extent.width, extent.height, schedule.capacity(id));
      floats += Arena::round_up(context.windows.back().floats());
    }
    return floats;
  }

  void begin(const Frame& frame, const FrameState& before) {
    const PictureExtent& picture = context.picture;
    if (frame.width != picture.width || frame.height != picture.height || frame.spp != picture.samples)
      fail("a frame of {}x{} pixels at {} samples, expected {}x{} at {}", frame.width, frame.height,
           frame.spp, picture.width, picture.height, picture.samples);
    if (!(frame.info.depth_scale > 0)) fail("a frame without a depth scale; expected a number above 0");
    const graph::LightParts& parts = context.graph.parts;
    if (int64_t(frame.parts.size()) < parts.colours || (parts.alpha && frame.alpha.empty()))
      fail("a frame of {} light parts{}; expected {}{}", frame.parts.size(),
           frame.alpha.empty() ? " without alpha" : "", parts.colours, parts.alpha ? " and alpha" : "");
    context.frame = &frame;
    context.before = before.empty() ? nullptr : &before;
    expect_state(before);
    context.value_scale = filter_scale(frame, context.threads, int64_t(frame.spp) * 3, [&](int64_t i) {
      return frame.plane(int(i / 3), kRadianceOffset + int(i % 3));
    });
    // By itself, so that no part changes the picture.
    context.part_scale = filter_scale(frame, context.threads, parts.colours * frame.spp * 3, [&](int64_t i) {
      const int64_t plane = i / parts.colours;
      return frame.part_plane(size_t(i % parts.colours), int(plane / 3), int(plane % 3));
    });
    if (context.graph.exposed) context.exposure = frame_exposure(frame, context.threads);
    seconds.assign(steps.size(), 0);
    for (const auto& step : steps) step->start();
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
  for (const auto& step : state_->steps) bytes += step->scratch_bytes(state_->block);
  // Steps have the weights in the order in which they read them.
  for (const graph::Parameter& parameter : graph::parameters(state_->context.graph))
    bytes += int64_t(state_->context.weights.at(parameter.name).values.size() * sizeof(float));
  return bytes;
}

const std::vector<double>& Execution::seconds() const {
  return state_->seconds;
}

const float* Execution::row(size_t output, int64_t plane, int64_t y) const {
  return state_->context.windows[state_->outputs[output]].row(y, plane);
}

void Execution::run(const Frame& frame, const Progress& progress, const Rows& rows,
                    const FrameState& before) {
  const FlushedDenormals flushed(state_->context.threads);
  state_->begin(frame, before);
  double done = 0, told = 0;
  state_->schedule.walk(
      [&](size_t node, int64_t begin, int64_t end) {
        const auto start = std::chrono::steady_clock::now();
        state_->steps[node]->run(begin, end);
        state_->seconds[node] +=
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        if (state_->made)
          for (const ValueId value : state_->context.graph.nodes[node].outputs)
            state_->made(value, state_->context.windows[value], begin, end);
        done += double(end - begin) * state_->row_work[node];
        const double share = std::min(done / state_->work, 1.0);
        if (!progress || share - told < 1 / kProgressSteps) return;
        told = share;
        progress(share);
      },
      rows);
  if (progress && told < 1) progress(1);
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
  run(frame, progress, keep, before);
  return images;
}

}  // namespace ld
