#include "runtime/executor.h"

#include <algorithm>
#include <variant>

#include "core/error.h"
#include "ops/kernels/constants.h"
#include "runtime/frame_exposure.h"
#include "runtime/parallel.h"
#include "runtime/step.h"

namespace ld {
namespace {

// Above this the sums of filters could overflow (ops/finite_sources.h): demodulated radiance is up to 50
// times as large.
constexpr float kLargestRadiance = 1e32f / 50;

float largest_radiance(const Frame& frame, int threads) {
  std::vector<float> largest(size_t(frame.spp) * 3, 0.0f);
  parallel_for(threads, int64_t(largest.size()), [&](int64_t i, int) {
    const float* plane = frame.plane(int(i / 3), kRadianceOffset + int(i % 3));
    float most = 0;
    for (size_t p = 0; p < frame.plane_size(); ++p) most = std::max(most, plane[p]);
    largest[size_t(i)] = most;
  });
  return *std::max_element(largest.begin(), largest.end());
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
  StepContext context;
  RowSchedule schedule;
  Floats arena;
  int64_t arena_floats = 0;
  std::vector<std::unique_ptr<Step>> steps;

  State(const graph::Graph& graph, const NamedWeights& weights, const PictureExtent& picture,
        const ExecutionOptions& options)
      : context{graph, weights, picture, std::max(options.threads, 1), {}},
        schedule(
            graph, picture,
            options.block_rows > 0 ? options.block_rows : default_block(options.threads, picture.width)) {
    for (graph::ValueId id = 0; id < graph.values.size(); ++id) {
      const ValueExtent extent = extent_of(graph, id, picture);
      context.windows.emplace_back(extent.planes, extent.width, extent.height, schedule.capacity(id));
      arena_floats += padded(context.windows.back().floats());
    }
    arena = hwy::AllocateAligned<float>(size_t(arena_floats));
    std::fill_n(arena.get(), arena_floats, 0.0f);
    float* next = arena.get();
    for (RowWindow& window : context.windows) {
      window.memory = next;
      next += padded(window.floats());
    }
    for (const graph::Node& node : graph.nodes) steps.push_back(make_step(node, context));
  }
};

Execution::Execution(const graph::Graph& graph, const NamedWeights& weights, const PictureExtent& picture,
                     const ExecutionOptions& options)
    : state_(std::make_unique<State>(graph, weights, picture, options)) {}

Execution::~Execution() = default;

int64_t Execution::arena_bytes() const {
  return state_->arena_floats * int64_t(sizeof(float));
}

Image Execution::run(const Frame& frame) {
  StepContext& context = state_->context;
  if (frame.width != context.picture.width || frame.height != context.picture.height ||
      frame.spp != context.picture.samples)
    fail("a frame of {}x{} pixels at {} samples, expected {}x{} at {}", frame.width, frame.height, frame.spp,
         context.picture.width, context.picture.height, context.picture.samples);
  if (!(frame.info.depth_scale > 0)) fail("a frame without a depth scale; expected a number above 0");
  context.frame = &frame;
  context.value_scale =
      largest_radiance(frame, context.threads) > kLargestRadiance ? float(kOverflowScale) : 1.0f;
  if (context.graph.exposed) context.exposure = frame_exposure(frame, context.threads);
  for (const auto& step : state_->steps) step->start();
  Image picture(frame.width, frame.height, 3);
  const RowWindow& result = context.windows[context.graph.output];
  state_->schedule.walk(
      [&](size_t node, int64_t begin, int64_t end) { state_->steps[node]->run(begin, end); },
      [&](int64_t begin, int64_t end) {
        for (int64_t y = begin; y < end; ++y)
          for (int c = 0; c < 3; ++c) std::copy_n(result.row(y, c), frame.width, &picture.at(c, 0, int(y)));
      });
  return picture;
}

}  // namespace ld
