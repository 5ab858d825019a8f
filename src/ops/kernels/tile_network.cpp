#include "ops/kernels/tile_network.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace ld {

void stage(const Planes& from, int64_t pixels, float* to, int64_t pitch) {
  for (int64_t c = 0; c < from.count; ++c) {
    std::memcpy(to + c * pitch, from.data + c * from.stride, size_t(pixels) * sizeof(float));
    std::fill(to + c * pitch + pixels, to + c * pitch + padded(pixels), 0.0f);
  }
}

void unstage(const float* from, int64_t pitch, int64_t rows, int64_t pixels, float* to, int64_t stride) {
  stream_rows(from, pitch, rows, pixels, to, stride);
}

TileNetwork::TileNetwork(std::vector<Layer> layers, int64_t x_inputs, Last last, bool for_backward)
    : layers_(std::move(layers)), x_inputs_(x_inputs), last_(last) {
  for (size_t i = 0; i < layers_.size(); ++i) {
    const Layer& layer = layers_[i];
    const int64_t inputs = i == 0 ? x_inputs_ : layer.inputs;
    forward_.emplace_back(layer.weights, layer.outputs, inputs, layer.inputs, 1);
    if (for_backward) backward_.emplace_back(layer.weights, inputs, layer.outputs, 1, layer.inputs);
  }
  if (shared_inputs() == 0) return;
  const Layer& first = layers_[0];
  const float* shared_weights = first.weights + x_inputs_;
  shared_.emplace_back(shared_weights, first.outputs, shared_inputs(), first.inputs, 1);
  if (for_backward) shared_.emplace_back(shared_weights, shared_inputs(), first.outputs, 1, first.inputs);
}

int64_t TileNetwork::scratch_width(bool backward) const {
  int64_t width = x_inputs_ + shared_inputs() + (shared_inputs() > 0 ? layers_[0].outputs : 0);
  for (const Layer& layer : layers_) width += (backward ? 2 : 1) * layer.outputs;
  if (backward) width += x_inputs_ + layers_[0].outputs + shared_inputs();
  return width;
}

TileNetwork::Scratch TileNetwork::make_scratch(int64_t pixels, bool backward) const {
  Scratch s;
  s.pitch = padded(pixels);
  s.memory = hwy::AllocateAligned<float>(size_t(scratch_width(backward) * s.pitch));
  float* next = s.memory.get();
  const auto take = [&](int64_t rows) { return std::exchange(next, next + rows * s.pitch); };
  s.x = take(x_inputs_);
  s.shared = take(shared_inputs());
  s.shared_sum = shared_inputs() > 0 ? take(layers_[0].outputs) : nullptr;
  for (const Layer& layer : layers_) s.a.push_back(take(layer.outputs));
  if (!backward) return s;
  for (const Layer& layer : layers_) s.g.push_back(take(layer.outputs));
  s.x_gradient = take(x_inputs_);
  s.first_gradient = take(layers_[0].outputs);
  s.shared_gradient = take(shared_inputs());
  return s;
}

std::vector<TileNetwork::Scratch> TileNetwork::make_scratches(int threads, int64_t pixels) const {
  std::vector<Scratch> scratches;
  for (int t = 0; t < threads; ++t) scratches.push_back(make_scratch(pixels, false));
  return scratches;
}

void TileNetwork::begin_tile(Scratch& s, int64_t pixels, PlanarRow shared) const {
  if (s.first_gradient != nullptr) std::fill_n(s.first_gradient, layers_[0].outputs * s.pitch, 0.0f);
  if (shared_inputs() == 0) return;
  TileProduct product;
  product.weights = &shared_[0];
  product.in = shared.data;
  product.in_pitch = shared.pitch;
  product.bias = layers_[0].biases;
  product.out = s.shared_sum;
  product.out_pitch = s.pitch;
  product.pixels = padded(pixels);
  multiply(product);
}

void TileNetwork::forward(Scratch& s, int64_t pixels, PlanarRow x, PlanarTarget out) const {
  for (int64_t i = 0; i < depth(); ++i) {
    const size_t layer = size_t(i);
    const bool given = i + 1 == depth() && out.data != nullptr;
    TileProduct product;
    product.weights = &forward_[layer];
    product.in = i == 0 ? x.data : s.a[layer - 1];
    product.in_pitch = i == 0 ? x.pitch : s.pitch;
    if (i == 0 && s.shared_sum != nullptr) {
      product.offset = s.shared_sum;
      product.offset_pitch = s.pitch;
    } else {
      product.bias = layers_[layer].biases;
    }
    product.out = given ? out.data : s.a[layer];
    product.out_pitch = given ? out.pitch : s.pitch;
    product.pixels = padded(pixels);
    product.epilogue = activated(i) ? Epilogue::leaky_relu : Epilogue::none;
    if (i + 1 == depth() && last_.bound > 0) {
      product.epilogue = Epilogue::bounded;
      product.bound = last_.bound;
    }
    multiply(product);
  }
}

void TileNetwork::backward(Scratch& s, int64_t pixels, const Sums& sums, bool want_x) const {
  const int64_t count = padded(pixels);
  if (activated(depth() - 1)) leaky_relu_backward(s.a.back(), s.g.back(), outputs(), s.pitch, count);
  if (last_.bound > 0) bounded_backward(s.a.back(), s.g.back(), outputs(), s.pitch, count, last_.bound);
  for (int64_t i = depth() - 1; i >= 0; --i) {
    const size_t layer = size_t(i);
    const int64_t inputs = forward_[layer].inputs, layer_outputs = layers_[layer].outputs;
    const float* below = i == 0 ? s.x : s.a[layer - 1];
    add_outer_product({s.g[layer], s.pitch, layer_outputs, below, s.pitch, inputs, count, sums.weights[layer],
                       layers_[layer].inputs});
    if (i > 0)
      add_row_sums(s.g[layer], s.pitch, layer_outputs, count, sums.biases[layer]);
    else
      add_rows(s.g[layer], layer_outputs, s.pitch, count, s.first_gradient);
    if (i == 0 && !want_x) break;
    TileProduct product;
    product.weights = &backward_[layer];
    product.in = s.g[layer];
    product.out = i == 0 ? s.x_gradient : s.g[layer - 1];
    product.in_pitch = product.out_pitch = s.pitch;
    product.pixels = count;
    if (i > 0) {
      product.activated = s.a[layer - 1];
      product.activated_pitch = s.pitch;
      product.epilogue = Epilogue::leaky_relu_backward;
    }
    multiply(product);
  }
}

void TileNetwork::end_tile(Scratch& s, int64_t pixels, const Sums& sums, bool want_shared) const {
  const Layer& first = layers_[0];
  const int64_t count = padded(pixels);
  add_row_sums(s.first_gradient, s.pitch, first.outputs, count, sums.biases[0]);
  if (shared_inputs() == 0) return;
  add_outer_product({s.first_gradient, s.pitch, first.outputs, s.shared, s.pitch, shared_inputs(), count,
                     sums.weights[0] + x_inputs_, first.inputs});
  if (!want_shared) return;
  TileProduct product;
  product.weights = &shared_[1];
  product.in = s.first_gradient;
  product.out = s.shared_gradient;
  product.in_pitch = product.out_pitch = s.pitch;
  product.pixels = count;
  multiply(product);
}

}  // namespace ld
