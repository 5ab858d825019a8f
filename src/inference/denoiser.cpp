#include "inference/denoiser.h"

#include <malloc.h>

#include <algorithm>
#include <any>

#include "core/process/process_memory.h"
#include "core/threads.h"
#include "inference/layer_views.h"
#include "models/graphs/network_graph.h"
#include "models/network_numbers.h"
#include "runtime/executor.h"
#include "runtime/sample_source.h"
#include "weights/network_weights.h"

namespace ld {
namespace {

constexpr int64_t kThreads = int64_t(16) << 20;  // stacks, and what operators need for a stretch of a row

int64_t megabytes(int64_t bytes) {
  return (bytes + kBudgetMegabyte - 1) / kBudgetMegabyte;
}

/// What is to be denoised, as plans see it.
struct Input {
  PictureExtent picture;
  int64_t aside;  // bytes that a budget does not count
};

Input input_of(const Frame& frame) {
  return {{frame.spp, frame.height, frame.width}, frame.bytes()};
}

Input input_of(const SampleArrays& arrays) {
  return {{arrays.spp, arrays.height, arrays.width}, -ArraySource::bytes(arrays)};
}

/// The progress function of the options, which may end it.
Execution::Progress progress_of(const DenoiseOptions& options) {
  if (!options.progress && !options.cancel) return {};
  return [&options](double share) {
    if (options.cancel && options.cancel()) throw Cancelled();
    if (options.progress) options.progress(share);
  };
}

int threads_of(const DenoiseOptions& options) {
  return options.threads > 0 ? options.threads : default_threads();
}

}  // namespace

struct Denoiser::State {
  NetworkWeights network;
  // What the last frame ran with.
  graph::Graph graph;
  std::unique_ptr<Execution> execution;
  int threads = 0;
  int64_t budget = 0;
  std::optional<double> skip_within;

  std::unique_ptr<Execution> plan(const graph::Graph& of, const PictureExtent& picture, int used_threads,
                                  int64_t block = 0, std::optional<double> skip = 0) const {
    return std::make_unique<Execution>(of, network.weights, picture,
                                       ExecutionOptions{used_threads, block, skip});
  }

  /// With as many rows at a time as the budget allows.
  std::unique_ptr<Execution> plan(const graph::Graph& of, const Input& input,
                                  const DenoiseOptions& options) const {
    const PictureExtent& picture = input.picture;
    if (picture.samples == 0 || picture.width == 0 || picture.height == 0)
      fail("a frame of {}x{} pixels at {} samples; expected at least one sample and pixel", picture.width,
           picture.height, picture.samples);
    malloc_trim(0);  // what earlier plans have freed
    const int64_t base =
        std::max<int64_t>(resident_bytes() - input.aside - options.memory_aside_bytes, 0) + kThreads;
    auto made = plan(of, picture, threads_of(options), 0, options.skip_within);
    if (options.max_memory_bytes <= 0) return made;
    while (base + made->memory_bytes() > options.max_memory_bytes) {
      const int64_t block = made->block_rows();
      if (block == 1)
        fail_usage(
            "a memory budget of {} MB is too small for {}x{} pixels at {} samples (beside the frame "
            "itself); the smallest is {} MB, of which program and weights take {}",
            options.max_memory_bytes / kBudgetMegabyte, picture.width, picture.height, picture.samples,
            megabytes(base + made->memory_bytes()), megabytes(base));
      made.reset();
      made = plan(of, picture, threads_of(options), block / 2, options.skip_within);
    }
    return made;
  }

  Execution& execution_for(const Input& input, const graph::LightParts& parts,
                           const DenoiseOptions& options) {
    const bool fits = execution && execution->picture() == input.picture && graph.parts == parts &&
                      threads == threads_of(options) && budget == options.max_memory_bytes &&
                      skip_within == options.skip_within;
    if (!fits) {
      execution.reset();
      graph = network_graph(network.config, parts);
      execution = plan(graph, input, options);
      threads = threads_of(options);
      budget = options.max_memory_bytes;
      skip_within = options.skip_within;
    }
    return *execution;
  }

  /// What the frame before has left, which is gone from there: a frame that is not finished leaves nothing.
  /// Other light parts than those of the frame before have no history.
  FrameState taken_from(SequenceState* sequence) const {
    FrameState before;
    if (sequence == nullptr || graph.state.empty()) return before;
    if (auto* left = std::any_cast<FrameState>(&sequence->memory)) before = std::move(*left);
    sequence->memory.reset();
    if (!before.empty() && before[0].channels != graph[graph.state[0]].channels) before.clear();
    return before;
  }

  /// Of a frame or arrays.
  template <class Samples>
  DenoisedParts denoise_parts(const Samples& samples, const graph::LightParts& parts,
                              const DenoiseOptions& options, SequenceState* sequence = nullptr) {
    Execution& run = execution_for(input_of(samples), parts, options);
    const Image colour(samples.width, samples.height, 3);
    DenoisedParts result = {colour, std::vector<Image>(size_t(parts.colours), colour), {}};
    if (parts.alpha) result.alpha = Image(samples.width, samples.height, 1);
    std::vector<Image*> images = {&result.picture};
    for (Image& part : result.parts) images.push_back(&part);
    images.push_back(&result.alpha);
    const FrameState before = taken_from(sequence);
    FrameState after;
    run.run(
        samples, progress_of(options),
        [&](int64_t begin, int64_t end) {
          int64_t plane = 0;
          for (Image* image : images)
            for (int c = 0; c < image->channels; ++c, ++plane)
              for (int64_t y = begin; y < end; ++y)
                std::copy_n(run.row(0, plane, y), image->width, &image->at(c, 0, int(y)));
        },
        before, sequence == nullptr ? nullptr : &after);
    if (!after.empty()) sequence->memory = std::move(after);
    for (float& value : result.alpha.pixels) value = std::min(value, 1.0f);  // rounding may lead beyond
    return result;
  }

  /// For what only a network with layers has.
  void expect_layers() const {
    if (network.config.name != "layer")
      fail_usage("the model's network is '{}', which has no layers to look at; expected 'layer'",
                 network.config.name);
  }
};

void check_skip_within(double within) {
  if (!(within >= 0 && within <= 1)) fail_usage("skip_within is {}; expected a number from 0 to 1", within);
}

Denoiser::Denoiser(const std::filesystem::path& model) : state_(std::make_unique<State>()) {
  state_->network = read_network_weights(model);
  required_ = state_->network.config.required_features();
}

Denoiser::~Denoiser() = default;

const NetworkConfig& Denoiser::network_config() const {
  return state_->network.config;
}

bool Denoiser::remembers() const {
  return !state_->network.graph.state.empty();
}

Image Denoiser::denoise(const Frame& frame, const DenoiseOptions& options, SequenceState* sequence) const {
  return state_->denoise_parts(frame, {}, options, sequence).picture;
}

DenoisedParts Denoiser::denoise_parts(const Frame& frame, bool alpha, const DenoiseOptions& options,
                                      SequenceState* sequence) const {
  if (alpha && frame.alpha.empty()) fail("no alpha to filter: the frame has none");
  return state_->denoise_parts(frame, {int64_t(frame.parts.size()), alpha}, options, sequence);
}

DenoisedParts Denoiser::denoise_parts(const SampleArrays& arrays, const DenoiseOptions& options,
                                      SequenceState* sequence) const {
  return state_->denoise_parts(arrays, {int64_t(arrays.parts.size()), arrays.alpha.has_value()}, options,
                               sequence);
}

Image Denoiser::frames_held(const SequenceState& sequence, int width, int height) const {
  const graph::Graph& graph = state_->network.graph;
  const auto* left = std::any_cast<FrameState>(&sequence.memory);
  for (size_t part = 0; left != nullptr && part < left->size(); ++part)
    if (graph[graph.state[part]].name == "frames") return left->at(part);
  Image frames(width, height, 1);
  std::fill(frames.pixels.begin(), frames.pixels.end(),
            std::min(float(sequence.history() + 1), float(kLongestHistory)));
  return frames;
}

Skipped Denoiser::skipped() const {
  return state_->execution ? state_->execution->skipped() : Skipped();
}

int64_t Denoiser::least_memory_bytes(int width, int height, int spp) const {
  malloc_trim(0);
  const int64_t base = resident_bytes() + kThreads;
  const auto least = state_->plan(state_->network.graph, {spp, height, width}, default_threads(), 1);
  return base + least->memory_bytes();
}

std::vector<LayerPicture> Denoiser::layers(const Frame& frame, const DenoiseOptions& options) const {
  state_->expect_layers();
  state_->execution.reset();  // both at a time are more than a budget is meant for
  const graph::Graph graph = layer_views_graph(network_config());
  return layer_pictures(network_config(),
                        state_->plan(graph, input_of(frame), options)->run(frame, progress_of(options)));
}

std::vector<Image> Denoiser::kernels_at(const Frame& frame, int x, int y) const {
  state_->expect_layers();
  if (x < 0 || y < 0 || x >= frame.width || y >= frame.height)
    fail_usage("there is no pixel ({}, {}) in a frame of {}x{}", x, y, frame.width, frame.height);
  const graph::Graph graph = layer_sources_graph(network_config());
  return layer_kernels(network_config(), state_->network.weights, *state_->plan(graph, input_of(frame), {}),
                       frame, x, y);
}

}  // namespace ld
