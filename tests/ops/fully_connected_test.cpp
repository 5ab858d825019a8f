#include "ops/fully_connected.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/error.h"
#include "tests/support/gradient_check.h"
#include "tests/support/scalar_reference.h"

namespace ld {
namespace {

using torch::Tensor;

struct Sizes {
  int64_t b, s, x, shared, h, w;
  std::vector<int64_t> widths;
  bool activate_last;
};

// The last spans several tiles; it is linear, as some pixel's leaky ReLU would bend within a finite
// difference.
const std::vector<Sizes> kLayerSizes = {
    {1, 1, 3, 0, 1, 1, {4}, false},       {2, 3, 5, 4, 1, 2, {6, 3}, true},
    {1, 8, 2, 3, 5, 7, {4, 4, 2}, false}, {2, 2, 20, 0, 3, 1, {32, 32, 32}, true},
    {1, 2, 3, 7, 23, 41, {289}, false},
};

struct LayersProblem {
  Tensor x, shared;
  FullyConnectedWeights weights;
  reference::Parameters parameters;

  explicit LayersProblem(const Sizes& sizes) {
    x = random_normal({sizes.b, sizes.s, sizes.x, sizes.h, sizes.w}, 1);
    if (sizes.shared > 0) shared = random_normal({sizes.b, sizes.shared, sizes.h, sizes.w}, 2);
    int64_t inputs = sizes.x + sizes.shared;
    for (size_t i = 0; i < sizes.widths.size(); ++i) {
      const int64_t outputs = sizes.widths[i];
      weights.weights.push_back(random_normal({outputs, inputs}, uint32_t(10 + i), 0.5));
      weights.biases.push_back(random_normal({outputs}, uint32_t(20 + i), 0.5));
      inputs = outputs;
      const auto parameter = [](const Tensor& t) {
        return reference::Parameter{t.sizes().vec(),
                                    {t.data_ptr<double>(), t.data_ptr<double>() + t.numel()}};
      };
      parameters[std::to_string(i) + ".weight"] = parameter(weights.weights.back());
      parameters[std::to_string(i) + ".bias"] = parameter(weights.biases.back());
    }
  }
  Tensor expected(bool activate_last) const {
    return to_tensor(reference::fully_connected(
        to_grid(x), shared.defined() ? to_grid(shared) : reference::Grid(), parameters, "", activate_last));
  }
};

TEST(FullyConnected, AgreesWithTheScalarReference) {
  for (const Sizes& sizes : kLayerSizes) {
    const LayersProblem p(sizes);
    const Tensor expected = p.expected(sizes.activate_last);
    expect_near(fully_connected(p.x, p.shared, p.weights, sizes.activate_last), expected, 1e-12);

    FullyConnectedWeights single;
    for (const Tensor& w : p.weights.weights) single.weights.push_back(w.to(torch::kFloat32));
    for (const Tensor& b : p.weights.biases) single.biases.push_back(b.to(torch::kFloat32));
    const Tensor shared = p.shared.defined() ? p.shared.to(torch::kFloat32) : Tensor();
    expect_near(fully_connected(p.x.to(torch::kFloat32), shared, single, sizes.activate_last), expected,
                1e-4);
  }
}

TEST(FullyConnected, GradientsAgreeWithFiniteDifferences) {
  for (const Sizes& sizes : kLayerSizes) {
    const LayersProblem p(sizes);
    const size_t layers = sizes.widths.size();
    std::vector<Tensor> inputs;
    // Not {variable(p.x)}: of a list that begins with one element GCC 14 warns, wrongly, that it is left.
    inputs.reserve(2 + 2 * layers);
    inputs.push_back(variable(p.x));
    if (p.shared.defined()) inputs.push_back(variable(p.shared));
    for (const Tensor& w : p.weights.weights) inputs.push_back(variable(w));
    for (const Tensor& b : p.weights.biases) inputs.push_back(variable(b));
    const size_t first = inputs.size() - 2 * layers;
    const bool large = sizes.h > 10;
    expect_gradients(
        [&](const std::vector<Tensor>& in) {
          const FullyConnectedWeights weights{
              {in.begin() + int64_t(first), in.begin() + int64_t(first + layers)},
              {in.begin() + int64_t(first + layers), in.end()}};
          const Tensor out =
              fully_connected(in[0], first == 2 ? in[1] : Tensor(), weights, sizes.activate_last);
          return large ? out / 100 : out;  // keeps the rounding of the long sum out of the differences
        },
        inputs, large ? 4 : 60);
  }
}

// c x / (c + |x|) of the last layer, forward and backward, in double and on the kernels.
TEST(FullyConnected, TheBoundOfTheLastLayerAgreesWithItsFormula) {
  for (const double c : {0.5, 4.0}) {
    LayersProblem p(kLayerSizes[2]);
    const Tensor x = p.expected(false);
    p.weights.bound = c;
    const Tensor expected = c * x / (c + x.abs());
    expect_near(fully_connected(p.x, p.shared, p.weights, false), expected, 1e-12);
    FullyConnectedWeights single;
    single.bound = c;
    for (const Tensor& w : p.weights.weights) single.weights.push_back(variable(w.to(torch::kFloat32)));
    for (const Tensor& b : p.weights.biases) single.biases.push_back(variable(b.to(torch::kFloat32)));
    const Tensor out = fully_connected(p.x.to(torch::kFloat32), p.shared.to(torch::kFloat32), single, false);
    expect_near(out, expected, 2e-6 * c);
    EXPECT_LT(out.abs().max().item<double>(), c);

    const Tensor w = variable(p.weights.weights.back());
    p.weights.weights.back() = w;
    const Tensor gradient = random_normal(expected.sizes(), 5);
    fully_connected(p.x, p.shared, p.weights, false).backward(gradient);
    out.backward(gradient.to(torch::kFloat32));
    expect_near(single.weights.back().grad(), w.grad(), 1e-4);
    expect_gradients(
        [&](const std::vector<Tensor>& in) {
          FullyConnectedWeights weights = p.weights;
          weights.weights.back() = in[0];
          return fully_connected(p.x, p.shared, weights, false);
        },
        {variable(w)}, 20);
  }
}

TEST(FullyConnected, TheBoundHoldsAtTheExtremes) {
  for (const float value :
       {0.0F, 1e-45F, 1e-38F, 65504.0F, 3e38F, -3e38F, std::numeric_limits<float>::infinity()}) {
    FullyConnectedWeights identity{{variable(torch::ones({1, 1}))}, {variable(torch::zeros({1}))}, 6};
    const Tensor x = torch::full({1, 1, 1, 2, 3}, value);
    const Tensor out = fully_connected(x, {}, identity, false);
    EXPECT_TRUE(out.isfinite().all().item<bool>()) << value;
    EXPECT_LE(out.abs().max().item<double>(), 6) << value;
    if (std::abs(value) < 1) {
      EXPECT_NEAR(out.max().item<double>(), value, 1e-6);
    }
    out.sum().backward();
    EXPECT_FALSE(identity.biases[0].grad().isnan().any().item<bool>()) << value;
  }
}

TEST(FullyConnected, ThreadsChangeNoBit) {
  const LayersProblem p({2, 2, 3, 7, 23, 41, {40, 289}, false});
  const int threads = at::get_num_threads();
  std::vector<Tensor> results;
  for (const int count : {1, 2, 2}) {
    at::set_num_threads(count);
    const Tensor x = variable(p.x.to(torch::kFloat32)),
                 w = variable(p.weights.weights[0].to(torch::kFloat32));
    const Tensor out =
        fully_connected(x, p.shared.to(torch::kFloat32),
                        {{w, p.weights.weights[1].to(torch::kFloat32)},
                         {p.weights.biases[0].to(torch::kFloat32), p.weights.biases[1].to(torch::kFloat32)}},
                        false);
    out.square().sum().backward();
    results.insert(results.end(), {out, x.grad(), w.grad()});
  }
  at::set_num_threads(threads);
  for (size_t i = 3; i < results.size(); ++i) EXPECT_TRUE(results[i].equal(results[i % 3])) << i;
}

TEST(FullyConnected, InferenceModeGivesTheSameBits) {
  const LayersProblem p(kLayerSizes[2]);
  const Tensor expected = fully_connected(p.x, p.shared, p.weights, false);
  const c10::InferenceMode guard;
  EXPECT_TRUE(fully_connected(p.x, p.shared, p.weights, false).equal(expected));
}

TEST(FullyConnected, BadShapesAreErrors) {
  const LayersProblem p(kLayerSizes[1]);
  EXPECT_THROW(fully_connected(p.x[0], p.shared, p.weights, false), Error);
  EXPECT_THROW(fully_connected(p.x, {}, p.weights, false), Error);
  EXPECT_THROW(fully_connected(p.x, p.shared.narrow(3, 0, 1), p.weights, false), Error);
  EXPECT_THROW(fully_connected(p.x, p.shared.to(torch::kFloat32), p.weights, false), Error);
  EXPECT_THROW(fully_connected(p.x, p.shared, {}, false), Error);
  FullyConnectedWeights both = p.weights;
  both.bound = 1;
  EXPECT_THROW(fully_connected(p.x, p.shared, both, true), Error);
  try {
    fully_connected(p.x.narrow(2, 0, 4), p.shared, p.weights, false);
    FAIL() << "accepted 8 inputs for 9";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(),
                 "fully_connected: weights has shape [6, 9], expected [outputs, inputs] = [any, 8]");
  }
}

}  // namespace
}  // namespace ld
