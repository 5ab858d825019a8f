// Our 3x3 convolutions beside oneDNN's, on the shapes of two U-nets: ld_convolution_speed THREADS. Prints a
// table (docs/performance.md). Not part of a normal build: nothing else needs oneDNN.
#include <omp.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <memory>
#include <oneapi/dnnl/dnnl.hpp>
#include <unordered_map>
#include <vector>

#include <fmt/format.h>

#include "ops/kernels/quantised_convolution.h"
#include "ops/kernels/winograd.h"
#include "runtime/parallel.h"
#include "runtime/row_window.h"

#if DNNL_VERSION_MAJOR != 2
#error "written for oneDNN 2, which Debian 12 has"
#endif

namespace {

struct Shape {
  int64_t inputs, outputs, width, height;
  double multiply_adds() const { return 9.0 * double(inputs * outputs * width * height); }
};

/// Channels and level of each convolution of common_fast and of configs/layer.yaml, in rows of a picture 1920
/// wide of which so many of full resolution are made at a time.
std::vector<Shape> shapes(int64_t block) {
  const std::vector<std::array<int, 3>> layers = {
      {16, 16, 0},   {16, 32, 1},   {32, 48, 2},   {48, 64, 3},   {96, 48, 2},    {48, 48, 2},
      {64, 32, 1},   {32, 32, 1},   {48, 32, 0},   {32, 32, 0},   {64, 64, 0},    {64, 128, 1},
      {128, 256, 2}, {256, 512, 3}, {512, 512, 4}, {512, 512, 5}, {1024, 512, 4}, {768, 256, 3},
      {384, 128, 2}, {256, 128, 1}, {192, 128, 0}};
  std::vector<Shape> made;
  for (const auto& [inputs, outputs, level] : layers)
    made.push_back({inputs, outputs, 1920 >> level, std::max<int64_t>(block >> level, 2)});
  return made;
}

/// float32, or u8 times s8; the rows above and below are given, as to ours, in the order that oneDNN likes.
std::function<void()> of_onednn(const Shape& s, bool int8) {
  using Type = dnnl::memory::data_type;
  using Tag = dnnl::memory::format_tag;
  using Desc = dnnl::memory::desc;
  static const dnnl::engine engine(dnnl::engine::kind::cpu, 0);
  static dnnl::stream stream(engine);
  const Type type = int8 ? Type::u8 : Type::f32;
  dnnl::post_ops activation;
  activation.append_eltwise(1, dnnl::algorithm::eltwise_relu, float(ld::kLeakySlope), 0);
  dnnl::primitive_attr attributes;
  attributes.set_post_ops(activation);
  const dnnl::convolution_forward::primitive_desc chosen(
      {dnnl::prop_kind::forward_inference,
       dnnl::algorithm::convolution_auto,
       Desc({1, s.inputs, s.height + 2, s.width}, type, Tag::any),
       Desc({s.outputs, s.inputs, 3, 3}, int8 ? Type::s8 : Type::f32, Tag::any),
       Desc({s.outputs}, int8 ? Type::s32 : Type::f32, Tag::a),
       Desc({1, s.outputs, s.height, s.width}, type, Tag::any),
       {1, 1},
       {0, 1},
       {0, 1}},
      attributes, engine);
  const auto zeros = [&](const Desc& desc) {
    const dnnl::memory memory(desc, engine);
    std::memset(memory.get_data_handle(), 0, desc.get_size());
    return memory;
  };
  const std::unordered_map<int, dnnl::memory> arguments = {{DNNL_ARG_SRC, zeros(chosen.src_desc())},
                                                           {DNNL_ARG_WEIGHTS, zeros(chosen.weights_desc())},
                                                           {DNNL_ARG_BIAS, zeros(chosen.bias_desc())},
                                                           {DNNL_ARG_DST, zeros(chosen.dst_desc())}};
  const dnnl::convolution_forward convolution(chosen);
  return [convolution, arguments] {
    convolution.execute(stream, arguments);
    stream.wait();
  };
}

/// A window of zeros.
struct Picture {
  ld::RowWindow window;
  std::vector<float> memory;
  Picture(int64_t channels, int64_t width, int64_t height)
      : window(channels, width, height, height), memory(size_t(window.floats() + ld::kPixelStep), 0.0F) {
    const size_t address = reinterpret_cast<size_t>(memory.data()) / sizeof(float);
    window.memory = memory.data() + (ld::kPixelStep - address % ld::kPixelStep) % ld::kPixelStep;
  }
};

template <class Weights, class Scratch>
std::function<void()> of_ours(const Shape& s, int threads, Weights&& packed) {
  const auto weights = std::make_shared<Weights>(std::forward<Weights>(packed));
  const auto in = std::make_shared<Picture>(s.inputs, s.width, s.height + 4);
  const auto out = std::make_shared<Picture>(s.outputs, s.width, s.height + 2);
  const auto scratch = std::make_shared<std::vector<Scratch>>();
  for (int t = 0; t < threads; ++t) scratch->emplace_back(*weights);
  return [=] {
    ld::for_each_stretch(threads, 0, (s.height + 1) / 2, ld::padded(s.width), ld::kWinogradPixels,
                         [&](int64_t pair, int64_t x, int64_t count, int thread) {
                           const int64_t y = 2 * pair;
                           ld::WinogradSource source;
                           source.channels = s.inputs;
                           for (int64_t i = 0; i < 4; ++i) source.rows[size_t(i)] = in->window.planar(y + i);
                           convolve(ld::TileRows<Weights>{weights.get(),
                                                          {source},
                                                          {out->window.row(y), out->window.row(y + 1)},
                                                          out->window.pitch,
                                                          x,
                                                          x + count,
                                                          s.width,
                                                          true},
                                    (*scratch)[size_t(thread)]);
                         });
  };
}

double seconds(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

int main(int argc, char** argv) {
  const int threads = argc > 1 ? std::max(std::atoi(argv[1]), 1) : 1;
  constexpr int kRuns = 9;
  omp_set_num_threads(threads);
  fmt::print(
      "| inputs | outputs | rows x pixels | ours, ms | oneDNN, ms | ours in 8 bits, ms | oneDNN's, ms |\n");
  fmt::print("| ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n");
  std::array<double, 4> sum = {};
  for (const Shape& s : shapes(8 * threads)) {
    const std::vector<float> weights(size_t(s.inputs * s.outputs * 9), 0.01F),
        biases(size_t(s.outputs), 0.0F), scales(size_t(s.outputs), 0.01F);
    const std::vector<int8_t> levels(weights.size(), 1);
    const std::array<std::function<void()>, 4> ways = {
        of_ours<ld::WinogradWeights, ld::WinogradScratch>(
            s, threads, ld::WinogradWeights(weights.data(), biases.data(), s.outputs, s.inputs)),
        of_onednn(s, false),
        of_ours<ld::PackedQuantisedWeights, ld::QuantisedScratch>(
            s, threads,
            ld::PackedQuantisedWeights({levels.data(), scales.data(), biases.data(), s.outputs, s.inputs},
                                       1)),
        of_onednn(s, true)};
    std::array<double, 4> best = {};
    for (int run = 0; run <= kRuns; ++run)
      for (size_t way = 0; way < ways.size(); ++way) {
        const double took = seconds(ways[way]);
        best[way] = run < 2 ? took : std::min(best[way], took);  // memory is new in the first
      }
    fmt::print("| {} | {} | {} x {} |", s.inputs, s.outputs, s.height, s.width);
    for (size_t way = 0; way < ways.size(); ++way) {
      fmt::print(" {:.2f} |", 1e3 * best[way]);
      sum[way] += best[way];
    }
    fmt::print("\n");
  }
  fmt::print("| | | sum | {:.1f} | {:.1f} | {:.1f} | {:.1f} |\n", 1e3 * sum[0], 1e3 * sum[1], 1e3 * sum[2],
             1e3 * sum[3]);
}
