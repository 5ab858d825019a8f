#include "ops/warp.h"

#include <ATen/Parallel.h>

#include <vector>

#include "core/error.h"
#include "ops/expect_tensor.h"
#include "ops/kernels/warp_taps.h"
#include "ops/pictures.h"

namespace ld {
namespace {

using torch::Tensor;
using torch::autograd::AutogradContext;
using torch::autograd::variable_list;

/// Of one picture: planes of H x W.
template <class T>
struct Guides {
  const T *now, *before;  // 4 planes each, or null

  static GuideSurface<T> at(const T* planes, int64_t plane, int64_t pixel) {
    return {planes[pixel], planes[plane + pixel], planes[2 * plane + pixel], planes[3 * plane + pixel]};
  }
};

/// Calls body(pixel, place in the previous frame, weight) for every tap that counts.
template <class T, class Body>
void for_each_tap(const T* flow, const bool* counts, const Guides<T>& guides, int64_t width, int64_t height,
                  int64_t row, Body body) {
  const int64_t plane = width * height;
  for (int64_t column = 0; column < width; ++column) {
    const int64_t pixel = row * width + column;
    GuideSurface<T> now;
    if (guides.now != nullptr) now = Guides<T>::at(guides.now, plane, pixel);
    const auto tap_counts = [&](int64_t x, int64_t y) {
      const int64_t source = y * width + x;
      return counts[source] &&
             (guides.now == nullptr || may_be_same_surface(now, Guides<T>::at(guides.before, plane, source)));
    };
    const WarpTaps<T> at = warp_taps(static_cast<T>(column) + flow[pixel],
                                     static_cast<T>(row) + flow[plane + pixel], width, height, tap_counts);
    for (int i = 0; i < 4; ++i)
      if (at.weights[i] > 0) body(pixel, at.row(i) * width + at.column(i), at.weights[i]);
  }
}

/// Pixels of the previous frame that are valid and finite in all channels.
Tensor counted(const Tensor& values, const Tensor& valid) {
  return values.isfinite().all(1, true).logical_and(valid.ne(0)).contiguous();
}

/// Autograd functions take no undefined tensors: an empty one stands for guides that there are not.
Tensor given(const Tensor& surfaces) {
  return surfaces.numel() > 0 ? surfaces : Tensor();
}

class Warp : public torch::autograd::Function<Warp> {
 public:
  static variable_list forward(AutogradContext* context, const Tensor& values, const Tensor& flow,
                               const Tensor& valid, const Tensor& now, const Tensor& before) {
    const Tensor v = values.contiguous(), f = flow.contiguous(), counts = counted(v, valid);
    context->save_for_backward({f, counts, now, before});
    const int64_t batch = v.size(0), channels = v.size(1), height = v.size(2), width = v.size(3);
    Tensor out = at::zeros_like(v), out_valid = at::zeros({batch, 1, height, width}, v.options());
    AT_DISPATCH_FLOATING_TYPES(v.scalar_type(), "warp", [&] {
      const Pictures<scalar_t> from(v), moves(f), to(out), known(out_valid), shown(given(now)),
          seen(given(before));
      const bool* const counted_data = counts.data_ptr<bool>();
      const int64_t plane = height * width;
      at::parallel_for(0, batch * height, 1, [&](int64_t first, int64_t last) {
        for (int64_t i = first; i < last; ++i) {
          const int64_t b = i / height;
          for_each_tap(moves[b], counted_data + b * plane, {shown[b], seen[b]}, width, height, i % height,
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
    const Tensor &f = saved[0], &counts = saved[1], &now = saved[2], &before = saved[3];
    const Tensor gradient = gradients[0].contiguous();
    const int64_t batch = gradient.size(0), channels = gradient.size(1), height = gradient.size(2),
                  width = gradient.size(3), plane = height * width;
    Tensor out = at::zeros_like(gradient);
    AT_DISPATCH_FLOATING_TYPES(gradient.scalar_type(), "warp_backward", [&] {
      const Pictures<scalar_t> from(gradient), moves(f), to(out), shown(given(now)), seen(given(before));
      const bool* const counted_data = counts.data_ptr<bool>();
      // Several pixels send to one: a thread has whole planes, so that the order of the sums is always the
      // same.
      at::parallel_for(0, batch * channels, 1, [&](int64_t first, int64_t last) {
        for (int64_t i = first; i < last; ++i) {
          const int64_t b = i / channels, c = i % channels;
          for (int64_t row = 0; row < height; ++row)
            for_each_tap(moves[b], counted_data + b * plane, {shown[b], seen[b]}, width, height, row,
                         [&](int64_t pixel, int64_t source, scalar_t weight) {
                           to[b][c * plane + source] += weight * from[b][c * plane + pixel];
                         });
        }
      });
    });
    return {out, Tensor(), Tensor(), Tensor(), Tensor()};
  }
};

}  // namespace

Warped warp(const Tensor& values, const Tensor& flow, const Tensor& valid, const WarpGuides& guides) {
  const torch::ScalarType type = floating_type("warp: values", values);
  expect_tensor("warp: values", "[B, C, H, W]", values, {kAnySize, kAnySize, kAnySize, kAnySize}, type);
  const int64_t batch = values.size(0), height = values.size(2), width = values.size(3);
  expect_tensor("warp: flow", "[B, 2, H, W]", flow, {batch, 2, height, width}, type);
  expect_tensor("warp: valid", "[B, 1, H, W]", valid, {batch, 1, height, width}, type);
  std::vector<Tensor> tensors = {values, flow, valid};
  if (guides.now.defined() || guides.before.defined())
    for (const Tensor& surfaces : {guides.now, guides.before}) {
      expect_tensor("warp: guides", "[B, 4, H, W]", surfaces, {batch, 4, height, width}, type);
      tensors.push_back(surfaces);
    }
  for (const Tensor& tensor : tensors)
    if (!tensor.is_cpu())
      fail(
          "warp: a tensor is on the device {}, expected the CPU, the only one that it runs on; move it there",
          tensor.device().str());
  const auto held = [&](const Tensor& surfaces) {
    return surfaces.defined() ? surfaces.detach().contiguous() : at::empty({0}, values.options());
  };
  const variable_list result =
      Warp::apply(values, flow.detach(), valid.detach(), held(guides.now), held(guides.before));
  return {result[0], result[1]};
}

}  // namespace ld
