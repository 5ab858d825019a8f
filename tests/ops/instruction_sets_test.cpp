// Every SIMD kernel on every instruction set that this machine has, forward and backward, against the
// composition of the same maths in double, over widths around the vectors' and heights around a strip's.
#include "ops/kernels/instruction_sets.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "ops/fully_connected.h"
#include "ops/generated_filter.h"
#include "ops/kernel_gather.h"
#include "ops/kernel_splat.h"
#include "ops/partition.h"
#include "tests/support/gradient_check.h"
#include "tests/support/tensors.h"

namespace ld {
namespace {

using torch::Tensor;
using Tensors = std::vector<Tensor>;

struct Size {
  int64_t h, w;
};

/// Widths 1, 3, 7 and those around 4, 8 and 16 lanes and a stretch of 144; heights around a strip of 32.
const std::vector<Size> kSizes = {{1, 1},  {2, 3},  {3, 4},  {2, 5},  {5, 7},  {3, 8},  {2, 9},
                                  {1, 15}, {4, 16}, {3, 17}, {33, 5}, {70, 3}, {2, 150}};

/// An operator as a function of its differentiable inputs, which are given in double.
struct Case {
  std::string name;
  Tensors inputs;
  std::function<Tensors(const Tensors&)> run;
};

FullyConnectedWeights weights_of(const Tensors& v, size_t first, size_t layers) {
  FullyConnectedWeights network;
  for (size_t i = 0; i < layers; ++i) {
    network.weights.push_back(v[first + 2 * i]);
    network.biases.push_back(v[first + 2 * i + 1]);
  }
  return network;
}

void add_weights(Tensors& inputs, const std::vector<int64_t>& widths) {
  for (size_t i = 0; i + 1 < widths.size(); ++i) {
    const double deviation = 1 / std::sqrt(double(widths[i]));
    inputs.push_back(random_normal({widths[i + 1], widths[i]}, uint32_t(50 + i), deviation));
    inputs.push_back(random_normal({widths[i + 1]}, uint32_t(60 + i)));
  }
}

Case fully_connected_case(const Size& at, bool shared) {
  Case c{shared ? "fully_connected with shared" : "fully_connected", {}, {}};
  c.inputs = {random_normal({2, 3, 5, at.h, at.w}, 1)};
  if (shared) c.inputs.push_back(random_normal({2, 7, at.h, at.w}, 2));
  add_weights(c.inputs, {shared ? 12 : 5, 11, 6, 3});
  c.run = [shared](const Tensors& v) -> Tensors {
    return {fully_connected(v[0], shared ? v[1] : Tensor(), weights_of(v, shared ? 2 : 1, 3), !shared)};
  };
  return c;
}

Case splat_case(const Size& at, int64_t kernel, int64_t layers, int64_t channels, bool joint) {
  const Tensor log_n = random_normal({2, layers, at.h, at.w}, 3);
  log_n.flatten()[0] = -std::numeric_limits<double>::infinity();  // a pixel that sends nothing
  return {joint ? "kernel_splat_joint" : "kernel_splat",
          {random_normal({2, layers, kernel * kernel, at.h, at.w}, 1, 2), log_n,
           random_uniform({2, layers, channels, at.h, at.w}, 2, 0, 4)},
          [joint](const Tensors& v) -> Tensors {
            return {joint ? kernel_splat_joint(v[0], v[1], v[2]) : kernel_splat(v[0], v[1], v[2])};
          }};
}

Case gather_case(const Size& at, int64_t kernel) {
  const Tensor log_n = at::zeros({2, at.h, at.w}, torch::kFloat64);
  if (at.w > 1) log_n.select(2, 1).fill_(-std::numeric_limits<double>::infinity());
  return {
      "kernel_gather",
      {random_normal({2, kernel * kernel, at.h, at.w}, 1, 2), random_uniform({2, 3, at.h, at.w}, 2, 0, 4)},
      [log_n](const Tensors& v) -> Tensors {
        return {kernel_gather(v[0], log_n.to(v[0].scalar_type()), v[1])};
      }};
}

Case partition_case(const Size& at, int64_t layers, Compositing compositing) {
  const Tensor valid = random_valid(2, 3, at.h, at.w, 4);
  return {compositing == Compositing::alpha ? "partition" : "partition weighted",
          {random_normal({2, 3, layers, at.h, at.w}, 1, 2),
           random_uniform({2, 3, 3, at.h, at.w}, 2, 0, 4) * valid,
           random_normal({2, 3, 5, at.h, at.w}, 3) * valid},
          [valid, compositing](const Tensors& v) -> Tensors {
            const Partition p = partition(v[0], valid.to(v[0].scalar_type()), v[1], v[2], compositing);
            // Finite where a pixel has no samples, so that its projection is.
            Tensors out = {p.log_n.masked_fill(p.log_n.isinf(), 0), p.radiance, p.opacity, p.embedding};
            if (p.transmittance.defined()) out.push_back(p.transmittance);
            return out;
          }};
}

std::vector<Case> cases(const Size& at) {
  return {fully_connected_case(at, false),
          fully_connected_case(at, true),
          splat_case(at, 1, 1, 1, false),
          splat_case(at, 3, 2, 4, false),
          splat_case(at, 5, 3, 5, false),
          splat_case(at, 5, 2, 3, true),
          gather_case(at, 1),
          gather_case(at, 5),
          partition_case(at, 1, Compositing::alpha),
          partition_case(at, 3, Compositing::alpha),
          partition_case(at, 2, Compositing::weighted)};
}

/// The outputs, and the gradients of a fixed random projection of them.
Tensors outputs_and_gradients(const Case& c, torch::ScalarType type) {
  Tensors inputs;
  for (const Tensor& input : c.inputs) inputs.push_back(input.to(type).detach().clone().requires_grad_(true));
  Tensors results = c.run(inputs);
  Tensor projection = torch::zeros({}, type);
  for (size_t i = 0; i < results.size(); ++i)
    projection =
        projection + (results[i] * random_normal(results[i].sizes(), uint32_t(70 + i)).to(type)).sum();
  projection.backward();
  for (const Tensor& input : inputs) results.push_back(input.grad());
  return results;
}

class InstructionSets : public testing::Test {
 protected:
  ~InstructionSets() override { use_instruction_set(""); }
};

TEST_F(InstructionSets, AgreeWithTheCompositionInDouble) {
  for (const Size& at : kSizes) {
    std::vector<Tensors> expected;
    for (const Case& c : cases(at)) expected.push_back(outputs_and_gradients(c, torch::kFloat64));
    for (const std::string& set : instruction_sets()) {
      use_instruction_set(set);
      for (size_t i = 0; i < cases(at).size(); ++i) {
        const Case c = cases(at)[i];
        const Tensors actual = outputs_and_gradients(c, torch::kFloat32);
        for (size_t k = 0; k < actual.size(); ++k) {
          ASSERT_TRUE(all_finite(actual[k])) << c.name << " " << set << " " << k;
          // Exponents of up to 20 err by 2^-23 of that, sums of up to 500 terms by their square root.
          const double scale = 1 + expected[i][k].abs().max().item<double>();
          EXPECT_LE(largest_difference(actual[k], expected[i][k]), 2e-5 * scale)
              << c.name << " on " << set << ", " << at.h << "x" << at.w << ", result " << k;
        }
      }
    }
  }
}

TEST_F(InstructionSets, GeneratedFiltersAgreeWithTheCompositionInDouble) {
  for (const Size& at : {Size{1, 1}, Size{5, 7}, Size{3, 17}, Size{40, 150}})
    for (const int64_t kernel : {3, 7}) {
      Tensors v = {random_normal({2, 2, 6, at.h, at.w}, 1), random_normal({2, 5, at.h, at.w}, 2),
                   random_normal({2, 2, at.h, at.w}, 3), random_uniform({2, 2, 4, at.h, at.w}, 4, 0, 4)};
      add_weights(v, {11, 8, kernel * kernel});
      const auto run = [](const Tensors& t) -> Tensors {
        const c10::InferenceMode no_graph;
        const FullyConnectedWeights network = weights_of(t, 4, 2);
        return {generated_splat(network, t[0], t[1], t[2], t[3]),
                generated_splat_joint(network, t[0], t[1], t[2], t[3]),
                generated_gather(network, t[0].narrow(1, 0, 1), t[1], t[2].select(1, 0), t[3].select(1, 0))};
      };
      const Tensors expected = run(v);
      for (Tensor& t : v) t = t.to(torch::kFloat32);
      for (const std::string& set : instruction_sets()) {
        use_instruction_set(set);
        const Tensors actual = run(v);
        for (size_t k = 0; k < actual.size(); ++k) expect_near(actual[k], expected[k], 2e-5);
      }
    }
}

TEST_F(InstructionSets, AnUnknownOneIsAnError) {
  EXPECT_FALSE(instruction_sets().empty());
  EXPECT_THROW(use_instruction_set("AVX9"), Error);
}

TEST_F(InstructionSets, ThreadsChangeNoBit) {
  const int threads = at::get_num_threads();
  for (const Case& c : cases({70, 37})) {
    at::set_num_threads(1);
    const Tensors one = outputs_and_gradients(c, torch::kFloat32);
    at::set_num_threads(2);
    const Tensors two = outputs_and_gradients(c, torch::kFloat32);
    for (size_t k = 0; k < one.size(); ++k) EXPECT_TRUE(one[k].equal(two[k])) << c.name << " " << k;
  }
  at::set_num_threads(threads);
}

}  // namespace
}  // namespace ld
