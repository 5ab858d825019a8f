#include "ops/fully_connected.h"

#include <ATen/Parallel.h>

#include <algorithm>

#include "core/error.h"
#include "ops/check.h"
#include "ops/composition.h"

namespace ld {
namespace {

using torch::Tensor;
using torch::autograd::AutogradContext;
using torch::autograd::variable_list;

constexpr double kSlope = 0.01;  // of the leaky ReLU below 0 ([MH20] appendix B)
constexpr int64_t kTileFloats =
    131072;  // activations of a tile, all layers together: a quarter of the L2 cache
constexpr int64_t kGroups =
    16;  // partial sums of the weights' gradient; fixed, so that threads change no bit

/// The arguments of fully_connected with pixels flattened: x [B, S, X, P], shared [B, Y, P].
struct Problem {
  Tensor x, shared;
  variable_list weights, biases;
  bool activate_last = false;
  int64_t tile = 0, tiles = 0;

  Problem(Tensor x_in, Tensor shared_in, variable_list w, variable_list b, bool activate)
      : x(std::move(x_in)),
        shared(std::move(shared_in)),
        weights(std::move(w)),
        biases(std::move(b)),
        activate_last(activate) {
    int64_t widths = weights[0].size(1);
    for (const Tensor& weight : weights) widths += weight.size(0);
    // A multiple of 64 pixels keeps the rows of a tile on cache lines.
    tile = std::min(std::max<int64_t>(kTileFloats / widths / 64 * 64, 64), x.size(3));
    tiles = (x.size(3) + tile - 1) / tile;
  }
  int64_t items() const { return x.size(0) * tiles; }
  int64_t layers() const { return int64_t(weights.size()); }
  bool activated(int64_t layer) const { return layer + 1 < layers() || activate_last; }
  Tensor x_weight() const { return weights[0].narrow(1, 0, x.size(2)); }
  Tensor shared_weight() const { return weights[0].narrow(1, x.size(2), weights[0].size(1) - x.size(2)); }
};

/// The pixels of one item of work: the tensors below are views of this tile.
struct Tile {
  int64_t b, begin, count;
  Tile(const Problem& problem, int64_t item)
      : b(item / problem.tiles),
        begin(item % problem.tiles * problem.tile),
        count(std::min(problem.tile, problem.x.size(3) - begin)) {}
  Tensor of(const Tensor& planes) const {
    return planes.select(0, b).narrow(1, begin, count);
  }                                                   // of [B, C, P]
  Tensor of(const Tensor& planes, int64_t s) const {  // of [B, S, C, P]
    return planes.select(0, b).select(0, s).narrow(1, begin, count);
  }
};

/// The first layer's part that all samples share: shared_weight * shared + bias, [outputs, count].
Tensor shared_part(const Problem& problem, const Tile& tile) {
  const Tensor bias = problem.biases[0].unsqueeze(1);
  if (!problem.shared.defined()) return bias.expand({bias.size(0), tile.count});
  return at::addmm(bias, problem.shared_weight(), tile.of(problem.shared));
}

/// One sample's activations in every layer; the last one is written to `out` where that is defined.
variable_list activations(const Problem& problem, const Tensor& x, const Tensor& first_part, Tensor out) {
  variable_list a;
  for (int64_t i = 0; i < problem.layers(); ++i) {
    const bool last = i + 1 == problem.layers();
    const Tensor offset = i == 0 ? first_part : problem.biases[i].unsqueeze(1);
    const Tensor weight = i == 0 ? problem.x_weight() : problem.weights[i];
    Tensor result = last && out.defined() ? out : at::empty({weight.size(0), x.size(1)}, x.options());
    at::addmm_out(result, offset, weight, i == 0 ? x : a.back());
    if (problem.activated(i)) at::leaky_relu_(result, kSlope);
    a.push_back(result);
  }
  return a;
}

/// Sums of one group of tiles towards the gradients of the weights.
struct Gradients {
  variable_list weights, biases;
  Gradients() = default;
  explicit Gradients(const Problem& problem) {
    for (const Tensor& w : problem.weights) weights.push_back(at::zeros(w.sizes(), w.options()));
    for (const Tensor& b : problem.biases) biases.push_back(at::zeros(b.sizes(), b.options()));
  }
};

/// Backward through all samples of a tile; x_gradient and shared_gradient may be undefined where not needed.
void tile_backward(const Problem& problem, const Tile& tile, const Tensor& gradient, const Tensor& x_gradient,
                   const Tensor& shared_gradient, Gradients& sums) {
  const Tensor first_part = shared_part(problem, tile);
  Tensor first_gradient = at::zeros({problem.weights[0].size(0), tile.count}, gradient.options());
  for (int64_t s = 0; s < problem.x.size(1); ++s) {
    const Tensor x = tile.of(problem.x, s);
    const variable_list a = activations(problem, x, first_part, Tensor());
    Tensor g = tile.of(gradient, s);
    for (int64_t i = problem.layers() - 1; i > 0; --i) {
      if (problem.activated(i)) g = at::leaky_relu_backward(g, a[i], kSlope, /*self_is_result=*/true);
      sums.weights[i].addmm_(g, a[i - 1].t());
      sums.biases[i].add_(g.sum(1));
      g = at::mm(problem.weights[i].t(), g);
    }
    if (problem.activated(0)) g = at::leaky_relu_backward(g, a[0], kSlope, /*self_is_result=*/true);
    sums.weights[0].narrow(1, 0, x.size(0)).addmm_(g, x.t());
    first_gradient.add_(g);
    if (x_gradient.defined()) {
      Tensor out = tile.of(x_gradient, s);
      at::mm_out(out, problem.x_weight().t(), g);
    }
  }
  sums.biases[0].add_(first_gradient.sum(1));
  if (!problem.shared.defined()) return;
  sums.weights[0]
      .narrow(1, problem.x.size(2), problem.shared.size(1))
      .addmm_(first_gradient, tile.of(problem.shared).t());
  if (shared_gradient.defined()) {
    Tensor out = tile.of(shared_gradient);
    at::mm_out(out, problem.shared_weight().t(), first_gradient);
  }
}

class FullyConnected : public torch::autograd::Function<FullyConnected> {
 public:
  static Tensor forward(AutogradContext* context, const Tensor& x, const c10::optional<Tensor>& shared,
                        at::TensorList weights, at::TensorList biases, bool activate_last) {
    variable_list to_save = {x, shared.value_or(Tensor())};
    to_save.insert(to_save.end(), weights.begin(), weights.end());
    to_save.insert(to_save.end(), biases.begin(), biases.end());
    context->save_for_backward(to_save);
    context->saved_data["activate_last"] = activate_last;
    const Problem problem(x, shared.value_or(Tensor()), weights.vec(), biases.vec(), activate_last);
    const Tensor out =
        at::empty({x.size(0), x.size(1), problem.weights.back().size(0), x.size(3)}, x.options());
    at::parallel_for(0, problem.items(), 1, [&](int64_t first, int64_t last) {
      at::AutoDispatchBelowADInplaceOrView
          plain;  // worker threads do not inherit the caller's autograd state
      for (int64_t item = first; item < last; ++item) {
        const Tile tile(problem, item);
        const Tensor first_part = shared_part(problem, tile);
        for (int64_t s = 0; s < x.size(1); ++s)
          activations(problem, tile.of(problem.x, s), first_part, tile.of(out, s));
      }
    });
    return out;
  }

  static variable_list backward(AutogradContext* context, variable_list gradients) {
    const variable_list saved = context->get_saved_variables();
    const auto count = int64_t(saved.size() - 2) / 2;
    const variable_list weights(saved.begin() + 2, saved.begin() + 2 + count);
    const variable_list biases(saved.begin() + 2 + count, saved.end());
    const Problem problem(saved[0], saved[1], weights, biases, context->saved_data["activate_last"].toBool());
    const Tensor gradient = gradients[0].contiguous();
    Tensor x_gradient, shared_gradient;
    if (problem.x.requires_grad()) x_gradient = at::empty_like(problem.x);
    if (problem.shared.defined() && problem.shared.requires_grad())
      shared_gradient = at::empty_like(problem.shared);

    const int64_t groups = std::min(problem.items(), kGroups);
    std::vector<Gradients> sums(static_cast<size_t>(groups));
    at::parallel_for(0, groups, 1, [&](int64_t first, int64_t last) {
      at::AutoDispatchBelowADInplaceOrView plain;
      for (int64_t group = first; group < last; ++group) {
        sums[size_t(group)] = Gradients(problem);
        for (int64_t item = problem.items() * group / groups; item < problem.items() * (group + 1) / groups;
             ++item)
          tile_backward(problem, Tile(problem, item), gradient, x_gradient, shared_gradient,
                        sums[size_t(group)]);
      }
    });
    for (size_t group = 1; group < sums.size(); ++group)
      for (size_t i = 0; i < size_t(count); ++i) {
        sums[0].weights[i].add_(sums[group].weights[i]);
        sums[0].biases[i].add_(sums[group].biases[i]);
      }

    variable_list result = {x_gradient, shared_gradient};
    result.insert(result.end(), sums[0].weights.begin(), sums[0].weights.end());
    result.insert(result.end(), sums[0].biases.begin(), sums[0].biases.end());
    result.emplace_back();  // activate_last
    return result;
  }
};

}  // namespace

Tensor fully_connected(const Tensor& x, const Tensor& shared, const FullyConnectedWeights& network,
                       bool activate_last) {
  const auto type = floating_type("fully_connected: x", x);
  expect_tensor("fully_connected: x", "[B, S, X, H, W]", x,
                {kAnySize, kAnySize, kAnySize, kAnySize, kAnySize}, type);
  int64_t inputs = x.size(2);
  if (shared.defined()) {
    expect_tensor("fully_connected: shared", "[B, Y, H, W]", shared,
                  {x.size(0), kAnySize, x.size(3), x.size(4)}, type);
    inputs += shared.size(1);
  }
  if (network.weights.empty() || network.weights.size() != network.biases.size())
    fail("fully_connected: {} weights and {} biases, expected as many of both and at least one",
         network.weights.size(), network.biases.size());
  for (size_t i = 0; i < network.weights.size(); ++i) {
    expect_tensor("fully_connected: weights", "[outputs, inputs]", network.weights[i], {kAnySize, inputs},
                  type);
    inputs = network.weights[i].size(0);
    expect_tensor("fully_connected: biases", "[outputs]", network.biases[i], {inputs}, type);
  }
  if (runs_composed(x)) return composed::fully_connected(x, shared, network, activate_last);
  const c10::optional<Tensor> flat_shared =
      shared.defined() ? c10::optional<Tensor>(shared.contiguous().flatten(2)) : c10::nullopt;
  return FullyConnected::apply(x.contiguous().flatten(3), flat_shared, at::TensorList(network.weights),
                               at::TensorList(network.biases), activate_last)
      .view({x.size(0), x.size(1), inputs, x.size(3), x.size(4)});
}

}  // namespace ld
