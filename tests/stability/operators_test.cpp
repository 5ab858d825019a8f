// Every operator at every extreme: results and gradients are finite.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/tone_map.h"
#include "ops/composition.h"
#include "ops/tone_map_tensor.h"
#include "tests/stability/operator_cases.h"
#include "tests/support/gradient_check.h"

namespace ld {
namespace {

using torch::Tensor;
using Tensors = std::vector<Tensor>;

bool admits(const OperatorInput& input, float number) {
  return std::isfinite(number) ? std::abs(double(number)) <= input.largest : input.any_number;
}

Tensors variables(const Tensors& values) {
  Tensors result;
  for (const Tensor& value : values) result.push_back(variable(value));
  return result;
}

void expect_finite(const OperatorCase& operation, const Tensors& values, const std::string& where) {
  const Tensors inputs = variables(values);
  const Tensor result = operation.run(inputs);
  EXPECT_TRUE(all_finite(result)) << operation.name << ": result, " << where;
  const Tensors gradients = torch::autograd::grad({result}, inputs, {torch::ones_like(result)});
  for (size_t i = 0; i < gradients.size(); ++i)
    EXPECT_TRUE(all_finite(gradients[i]))
        << operation.name << ": gradient of " << operation.inputs[i].name << ", " << where;
}

Tensors ordinary_inputs(const OperatorCase& operation, torch::ScalarType type = torch::kFloat32) {
  Tensors values;
  for (const OperatorInput& input : operation.inputs) values.push_back(input.ordinary.to(type));
  return values;
}

void sweep(const OperatorCase& operation, torch::ScalarType type) {
  expect_finite(operation, ordinary_inputs(operation, type), "ordinary numbers");
  for (const float number : extreme_numbers()) {
    Tensors together = ordinary_inputs(operation, type);
    for (size_t i = 0; i < operation.inputs.size(); ++i) {
      const OperatorInput& input = operation.inputs[i];
      if (!admits(input, number)) continue;
      const std::string where = fmt::format("{:g} in {}", number, input.name);
      Tensors values = ordinary_inputs(operation, type);
      values[i] = sprinkle(values[i], number, uint32_t(40 + i));
      together[i] = values[i];
      expect_finite(operation, values, "some " + where);
      values[i] = torch::full_like(values[i], double(number));
      expect_finite(operation, values, "nothing but " + where);
    }
    expect_finite(operation, together, fmt::format("{:g} in all inputs", number));
  }
}

TEST(Operators, StayFiniteAtEveryExtreme) {
  for (const OperatorCase& operation : operator_cases()) sweep(operation, torch::kFloat32);
}

TEST(Operators, StayFiniteAtEveryExtremeInDouble) {
  for (const OperatorCase& operation : operator_cases()) sweep(operation, torch::kFloat64);
}

// A NaN must not only vanish from the result, it must mean what the headers say: with NaN or an infinity here
// and there, the operators that admit them agree with their double compositions.
TEST(Operators, BadNumbersMeanTheSameInFloatAndInDouble) {
  for (const OperatorCase& operation : operator_cases())
    for (size_t i = 0; i < operation.inputs.size(); ++i) {
      if (!operation.inputs[i].any_number) continue;
      for (const float number : extreme_numbers()) {
        if (std::isfinite(number)) continue;
        Tensors single = ordinary_inputs(operation), twice;
        single[i] = sprinkle(single[i], number, 50);
        for (const Tensor& value : single) twice.push_back(value.to(torch::kFloat64));
        SCOPED_TRACE(operation.name + ": " + std::to_string(number) + " in " + operation.inputs[i].name);
        expect_near(operation.run(single), operation.run(twice), 2e-5);
      }
    }
}

TEST(Operators, ToneMapIsAccurateInTheDark) {
  const std::vector<double> dark = {1e-30, 1e-20, 1e-10, 1e-7, 1e-5, 1e-3, 0.1, 1, 65504};
  const Tensor x = torch::tensor(dark, torch::kFloat32).set_requires_grad(true);
  const Tensor y = tone_map(x);
  y.sum().backward();
  for (size_t i = 0; i < dark.size(); ++i) {
    const double exact = x.detach()[int64_t(i)].item<double>();
    EXPECT_NEAR(y[int64_t(i)].item<double>() / tone_map(exact), 1, 1e-6) << dark[i];
    EXPECT_NEAR(x.grad()[int64_t(i)].item<double>() / tone_map_slope(exact), 1, 1e-6) << dark[i];
  }
}

}  // namespace
}  // namespace ld
