#include "tests/stability/operator_cases.h"

#include <cmath>
#include <limits>

#include "ops/fully_connected.h"
#include "ops/generated_filter.h"
#include "ops/kernel_gather.h"
#include "ops/kernel_splat.h"
#include "ops/partition.h"
#include "ops/tone_map_tensor.h"
#include "ops/weighted_sum.h"
#include "tests/support/tensors.h"

namespace ld {
namespace {

using torch::Tensor;
using Tensors = std::vector<Tensor>;

constexpr int64_t kHeight = 11, kWidth = 9, kSamples = 3, kLayers = 2, kTaps = 25, kEmbedding = 6,
                  kContext = 4;
constexpr double kHalf = 65504;  // what the networks clamp features to
constexpr double kLargest = 3.4e38;

Tensor normal(torch::IntArrayRef sizes, uint32_t seed) {
  return random_normal(sizes, seed).to(torch::kFloat32);
}

Tensor uniform(torch::IntArrayRef sizes, uint32_t seed, double high = 1) {
  return random_uniform(sizes, seed, 0, high).to(torch::kFloat32);
}

Tensor flat(const Tensors& results) {
  Tensors parts;
  for (const Tensor& result : results) parts.push_back(result.flatten());
  return at::cat(parts);
}

/// A network of two layers, its weights as four of the case's inputs from `first` on.
FullyConnectedWeights weights_from(const Tensors& inputs, size_t first) {
  return {{inputs[first], inputs[first + 1]}, {inputs[first + 2], inputs[first + 3]}};
}

void add_network(OperatorCase& operation, int64_t inputs, int64_t outputs) {
  operation.inputs.push_back({"weight 0", 0.3 * normal({8, inputs}, 31), false, 100});
  operation.inputs.push_back({"weight 1", 0.3 * normal({outputs, 8}, 32), false, 100});
  operation.inputs.push_back({"bias 0", normal({8}, 33), false, 100});
  operation.inputs.push_back({"bias 1", normal({outputs}, 34), false, 100});
}

OperatorCase fully_connected_case() {
  OperatorCase operation{
      "fully_connected",
      {{"x", normal({1, kSamples, kEmbedding, kHeight, kWidth}, 1), false, 1e30},
       {"shared", normal({1, kContext, kHeight, kWidth}, 2), false, 1e30}},
      [](const Tensors& v) { return fully_connected(v[0], v[1], weights_from(v, 2), true); }};
  add_network(operation, kEmbedding + kContext, 5);
  return operation;
}

using Splat = Tensor (*)(const Tensor&, const Tensor&, const Tensor&);

OperatorCase splat_case(const std::string& name, Splat splat) {
  return {name,
          {{"logits", 3 * normal({1, kLayers, kTaps, kHeight, kWidth}, 3), true, kLargest},
           {"log_n", uniform({1, kLayers, kHeight, kWidth}, 4).log(), true, kLargest},
           {"values", uniform({1, kLayers, 4, kHeight, kWidth}, 5), true, kLargest}},
          [splat](const Tensors& v) { return splat(v[0], v[1], v[2]); }};
}

OperatorCase gather_case() {
  return {"kernel_gather",
          {{"logits", 3 * normal({1, kTaps, kHeight, kWidth}, 6), true, kLargest},
           {"values", uniform({1, 3, kHeight, kWidth}, 7), true, kLargest}},
          [](const Tensors& v) {
            Tensor log_n = torch::zeros({1, kHeight, kWidth}, v[0].options().requires_grad(false));
            log_n[0][3].fill_(-std::numeric_limits<float>::infinity());  // a row that gives nothing
            return kernel_gather(v[0], log_n, v[1]);
          }};
}

using GeneratedSplat = Tensor (*)(const FullyConnectedWeights&, const Tensor&, const Tensor&, const Tensor&,
                                  const Tensor&);

OperatorCase generated_splat_case(const std::string& name, GeneratedSplat splat) {
  OperatorCase operation{
      name,
      {{"x", normal({1, kLayers, kEmbedding, kHeight, kWidth}, 8), false, kHalf},
       {"shared", normal({1, kContext, kHeight, kWidth}, 9), false, kHalf},
       {"log_n", uniform({1, kLayers, kHeight, kWidth}, 10).log(), true, kLargest},
       {"values", uniform({1, kLayers, 4, kHeight, kWidth}, 11), true, kLargest}},
      [splat](const Tensors& v) { return splat(weights_from(v, 4), v[0], v[1], v[2], v[3]); }};
  add_network(operation, kEmbedding + kContext, kTaps);
  return operation;
}

OperatorCase generated_gather_case() {
  OperatorCase operation{"generated_gather",
                         {{"x", normal({1, 1, kEmbedding, kHeight, kWidth}, 12), false, kHalf},
                          {"shared", normal({1, kContext, kHeight, kWidth}, 13), false, kHalf},
                          {"values", uniform({1, 3, kHeight, kWidth}, 14), true, kLargest}},
                         [](const Tensors& v) {
                           return generated_gather(
                               weights_from(v, 3), v[0], v[1],
                               torch::zeros({1, kHeight, kWidth}, v[0].options().requires_grad(false)), v[2]);
                         }};
  add_network(operation, kEmbedding + kContext, kTaps);
  return operation;
}

Tensor some_valid(torch::ScalarType type) {
  return random_valid(1, kSamples, kHeight, kWidth, 15).to(type);
}

OperatorCase partition_case(const std::string& name, Compositing compositing) {
  return {name,
          {{"logits", 3 * normal({1, kSamples, kLayers, kHeight, kWidth}, 16), true, kLargest},
           {"radiance", uniform({1, kSamples, 3, kHeight, kWidth}, 17), true, kLargest},
           {"embedding", normal({1, kSamples, kEmbedding, kHeight, kWidth}, 18), false, kHalf}},
          [compositing](const Tensors& v) {
            const Partition p = partition(v[0], some_valid(v[0].scalar_type()), v[1], v[2], compositing);
            const Tensor nothing = p.log_n.lt(-1e30);
            Tensors results = {p.log_n.masked_fill(nothing, 0), p.radiance, p.opacity, p.embedding};
            if (p.transmittance.defined()) results.push_back(p.transmittance);
            return flat(results);
          }};
}

}  // namespace

std::vector<OperatorCase> operator_cases() {
  return {
      fully_connected_case(),
      splat_case("kernel_splat", kernel_splat),
      splat_case("kernel_splat_joint", kernel_splat_joint),
      gather_case(),
      generated_splat_case("generated_splat", generated_splat),
      generated_splat_case("generated_splat_joint", generated_splat_joint),
      generated_gather_case(),
      partition_case("partition, alpha", Compositing::alpha),
      partition_case("partition, weighted", Compositing::weighted),
      {"weighted_sum",
       {{"weights", uniform({1, kSamples, kLayers, kHeight, kWidth}, 19), false, 1},
        {"values", normal({1, kSamples, 4, kHeight, kWidth}, 20), false, 1e38}},
       [](const Tensors& v) { return weighted_sum(v[0], v[1]); }},
      {"masked_mean",
       {{"values", normal({1, kSamples, 4, kHeight, kWidth}, 21), false, 3e38}},
       [](const Tensors& v) { return masked_mean(v[0], some_valid(v[0].scalar_type())); }},
      {"tone_map",
       {{"linear", uniform({1, 3, kHeight, kWidth}, 22, 4), false, kLargest}},
       [](const Tensors& v) { return tone_map(v[0]); }},
  };
}

const std::vector<float>& extreme_numbers() {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  static const std::vector<float> numbers = {
      0,        1e-40F,   1e-38F,  65504,  1e30F,
      3e38F,    -100,     -1e-40F, -3e38F, std::numeric_limits<float>::quiet_NaN(),
      infinity, -infinity};
  return numbers;
}

Tensor sprinkle(const Tensor& ordinary, float number, uint32_t seed) {
  return ordinary.masked_fill(random_uniform(ordinary.sizes(), seed).lt(0.2), double(number));
}

}  // namespace ld
