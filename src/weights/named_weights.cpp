#include "weights/named_weights.h"

#include <half.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/error.h"

namespace ld {
namespace {

std::vector<float> as_floats(const TensorView& tensor, const std::string& file) {
  const size_t count = tensor.bytes / dtype_bytes(tensor.type);
  std::vector<float> values(count);
  switch (tensor.type) {
    case DType::f32:
      if (count > 0) std::memcpy(values.data(), tensor.data, tensor.bytes);
      return values;
    case DType::f16: {
      const auto* bits = static_cast<const unsigned short*>(tensor.data);
      for (size_t i = 0; i < count; ++i) {
        half value;
        value.setBits(bits[i]);
        values[i] = value;
      }
      return values;
    }
    case DType::f64: {
      const auto* doubles = static_cast<const double*>(tensor.data);
      std::transform(doubles, doubles + count, values.begin(), [](double v) { return float(v); });
      return values;
    }
    default:
      fail("{}: tensor '{}' holds no floats, expected weights", file, tensor.name);
  }
}

constexpr const char* kScale = ".scale";
constexpr const char* kInputRange = ".input_range";

/// The tensor whose scale this would be; "" for another name.
std::string scaled_tensor(const std::string& name) {
  for (const std::string ending : {kScale, kInputRange})
    if (name.size() > ending.size() && name.compare(name.size() - ending.size(), ending.size(), ending) == 0)
      return name.substr(0, name.size() - ending.size());
  return "";
}

std::vector<float> scales_of(const SafetensorsFile& file, const std::string& name, int64_t count) {
  // Beyond this their products and inverses would leave float32.
  constexpr float kLeast = 1e-15F, kMost = 1e15F;
  const TensorView& tensor = file.tensor(name);
  if (tensor.type != DType::f32 || tensor.shape != std::vector<int64_t>{count})
    fail("{}: tensor '{}' is not [{}] of F32, which an I8 tensor needs; the file is damaged",
         file.path().string(), name, count);
  std::vector<float> scales = as_floats(tensor, file.path().string());
  for (const float scale : scales)
    if (!(scale >= kLeast && scale <= kMost))
      fail("{}: tensor '{}' holds {}, expected scales from {} to {}; the file is damaged",
           file.path().string(), name, scale, kLeast, kMost);
  return scales;
}

void set_values(NamedWeight& weight) {
  const Quantised& q = *weight.quantised;
  weight.values.resize(q.levels.size());
  const size_t row = q.levels.size() / q.scales.size();
  for (size_t i = 0; i < q.levels.size(); ++i) weight.values[i] = float(q.levels[i]) * q.scales[i / row];
}

NamedWeight read_quantised(const SafetensorsFile& file, const TensorView& tensor) {
  if (tensor.shape.empty() || tensor.bytes == 0)
    fail("{}: tensor '{}' is an I8 tensor without outputs; the file is damaged", file.path().string(),
         tensor.name);
  NamedWeight weight = {tensor.shape, {}, Quantised()};
  Quantised& q = *weight.quantised;
  const auto* levels = static_cast<const int8_t*>(tensor.data);
  q.levels.assign(levels, levels + tensor.bytes);
  q.scales = scales_of(file, tensor.name + kScale, tensor.shape[0]);
  q.input_range = scales_of(file, tensor.name + kInputRange, 1)[0];
  set_values(weight);
  return weight;
}

}  // namespace

NamedWeight quantised(const NamedWeight& weight, float input_range) {
  constexpr float kLevels = 127, kLeastScale = 1e-12F;
  const auto outputs = size_t(weight.shape[0]);
  const size_t row = weight.values.size() / outputs;
  NamedWeight made = {weight.shape, {}, Quantised()};
  Quantised& q = *made.quantised;
  q.input_range = input_range;
  for (size_t o = 0; o < outputs; ++o) {
    const auto* values = weight.values.data() + o * row;
    float most = 0;
    for (size_t i = 0; i < row; ++i) most = std::max(most, std::abs(values[i]));
    q.scales.push_back(std::max(most / kLevels, kLeastScale));
    for (size_t i = 0; i < row; ++i) q.levels.push_back(int8_t(std::lround(values[i] / q.scales[o])));
  }
  set_values(made);
  return made;
}

bool is_scale(const SafetensorsFile& file, const TensorView& tensor) {
  const std::string scaled = scaled_tensor(tensor.name);
  return !scaled.empty() &&
         std::any_of(file.tensors().begin(), file.tensors().end(),
                     [&](const TensorView& t) { return t.name == scaled && t.type == DType::i8; });
}

NamedWeights::NamedWeights(const SafetensorsFile& file) {
  for (const TensorView& tensor : file.tensors()) {
    if (is_scale(file, tensor)) continue;
    NamedWeight& weight = weights_[tensor.name] =
        tensor.type == DType::i8 ? read_quantised(file, tensor)
                                 : NamedWeight{tensor.shape, as_floats(tensor, file.path().string())};
    if (!std::all_of(weight.values.begin(), weight.values.end(), [](float v) { return std::isfinite(v); }))
      fail("{}: tensor '{}' holds NaN or infinity; the training diverged or the file is damaged",
           file.path().string(), tensor.name);
  }
}

const NamedWeight& NamedWeights::at(const std::string& name) const {
  const auto found = weights_.find(name);
  if (found == weights_.end()) fail("the weights have no '{}', which the network needs", name);
  return found->second;
}

}  // namespace ld
