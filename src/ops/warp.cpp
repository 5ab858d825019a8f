#include "ops/warp.h"

#include <ATen/Parallel.h>

#include <cmath>

#include "core/error.h"
#include "ops/expect_tensor.h"
#include "ops/pictures.h"

namespace ld {
namespace {

using torch::Tensor;
using torch::autograd::AutogradContext;
using torch::autograd::variable_list;

constexpr double kLeastWeight = 0.01;  // of the taps that count; less is a corner of a pixel

/// The 2x2 pixels around a place, of which some count; weights of the others are 0.
template <class T>
struct Footprint {
  int64_t x = 0, y = 0;  // of the upper left one, from -1
  T weights[4] = {0, 0, 0, 0};
  bool valid = false;
};

/// `counts` says of each pixel of the previous frame whether it does.
template <class T>
Footprint<T> footprint(T x, T y, int64_t width, int64_t height, const bool* counts) {
  Footprint<T> at;
  // Written so that NaN is outside too, and no number is converted that an integer cannot hold.
  if (!(x > -1 && x < static_cast<T>(width) && y > -1 && y < static_cast<T>(height))) return at;
  const T left = std::floor(x), top = std::floor(y), fx = x - left, fy = y - top;
  at.x = static_cast<int64_t>(left);
  at.y = static_cast<int64_t>(top);
  const T shares[4] = {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy};
  T sum = 0;
  for (int i = 0; i < 4; ++i) {
    const int64_t column = at.x + i % 2, row = at.y + i / 2;
    if (column < 0 || column >= width || row < 0 || row >= height || !counts[row * width + column]) continue;
    at.weights[i] = shares[i];
    sum += shares[i];
  }
  at.valid = sum >= static_cast<T>(kLeastWeight);
  for (T& weight : at.weights) weight = at.valid ? weight / sum : 0;
  return at;
}

/// Calls body(pixel, place in the previous frame, weight) for every tap that counts.
template <class T, class Body>
void for_each_tap(const T* flow, const bool* counts, int64_t width, int64_t height, int64_t row, Body body) {
  const T* const flow_y = flow + width * height;
  for (int64_t column = 0; column < width; ++column) {
    const int64_t pixel = row * width + column;
    const Footprint<T> at = footprint(static_cast<T>(column) + flow[pixel],
                                      static_cast<T>(row) + flow_y[pixel], width, height, counts);
    for (int i = 0; i < 4; ++i)
      if (at.weights[i] > 0) body(pixel, (at.y + i / 2) * width + at.x + i % 2, at.weights[i]);
  }
}

/// Pixels of the previous frame that are valid and finite in all channels.
Tensor counted(const Tensor& values, const Tensor& valid) {
  return values.isfinite().all(1, true).logical_and(valid.ne(0)).contiguous();
}

class Warp : public torch::autograd::Function<Warp> {
 public:
  static variable_list forward(AutogradContext* context, const Tensor& values, const Tensor& flow,
                               const Tensor& valid) {
    const Tensor v = values.contiguous(), f = flow.contiguous(), counts = counted(v, valid);
    context->save_for_backward({f, counts});
    const int64_t batch = v.size(0), channels = v.size(1), height = v.size(2), width = v.size(3);
    Tensor out = at::zeros_like(v), out_valid = at::zeros({batch, 1, height, width}, v.options());
    AT_DISPATCH_FLOATING_TYPES(v.scalar_type(), "warp", [&] {
      const Pictures<scalar_t> from(v), moves(f), to(out), known(out_valid);
      const bool* const counted_data = counts.data_ptr<bool>();
      const int64_t plane = height * width;
      at::parallel_for(0, batch * height, 1, [&](int64_t first, int64_t last) {
        for (int64_t i = first; i < last; ++i) {
          const int64_t b = i / height;
          for_each_tap(moves[b], counted_data + b * plane, width, height, i % height,
                       [&](int64_t pixel, int64_t source, scalar_t weight) {
                         known[b][pixel] = 1;
                         for (int64_t c = 0; c < channels; ++c)
                           to[b][c * plane + pixel] += weight * from[b][c * plane + source];
                       });
        }
      });
    });
    context->mark_non_differentiable({out_valid});
    return {out, out_valid};
  }

  static variable_list backward(AutogradContext* context, variable_list gradients) {
    const variable_list saved = context->get_saved_variables();
    const Tensor &f = saved[0], &counts = saved[1];
    const Tensor gradient = gradients[0].contiguous();
    const int64_t batch = gradient.size(0), channels = gradient.size(1), height = gradient.size(2),
                  width = gradient.size(3), plane = height * width;
    Tensor out = at::zeros_like(gradient);
    AT_DISPATCH_FLOATING_TYPES(gradient.scalar_type(), "warp_backward", [&] {
      const Pictures<scalar_t> from(gradient), moves(f), to(out);
      const bool* const counted_data = counts.data_ptr<bool>();
      // Several pixels send to one: a thread has whole planes, so that the order of the sums is always the
      // same.
      at::parallel_for(0, batch * channels, 1, [&](int64_t first, int64_t last) {
        for (int64_t i = first; i < last; ++i) {
          const int64_t b = i / channels, c = i % channels;
          for (int64_t row = 0; row < height; ++row)
            for_each_tap(moves[b], counted_data + b * plane, width, height, row,
                         [&](int64_t pixel, int64_t source, scalar_t weight) {
                           to[b][c * plane + source] += weight * from[b][c * plane + pixel];
                         });
        }
      });
    });
    return {out, Tensor(), Tensor()};
  }
};

}  // namespace

Warped warp(const Tensor& values, const Tensor& flow, const Tensor& valid) {
  const torch::ScalarType type = floating_type("warp: values", values);
  expect_tensor("warp: values", "[B, C, H, W]", values, {kAnySize, kAnySize, kAnySize, kAnySize}, type);
  const int64_t batch = values.size(0), height = values.size(2), width = values.size(3);
  expect_tensor("warp: flow", "[B, 2, H, W]", flow, {batch, 2, height, width}, type);
  expect_tensor("warp: valid", "[B, 1, H, W]", valid, {batch, 1, height, width}, type);
  for (const Tensor* tensor : {&values, &flow, &valid})
    if (!tensor->is_cpu())
      fail(
          "warp: a tensor is on the device {}, expected the CPU, the only one that it runs on; move it there",
          tensor->device().str());
  const variable_list result = Warp::apply(values, flow.detach(), valid.detach());
  return {result[0], result[1]};
}

}  // namespace ld
