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

}  // namespace

NamedWeights::NamedWeights(const SafetensorsFile& file) {
  for (const TensorView& tensor : file.tensors()) {
    NamedWeight& weight = weights_[tensor.name] = {tensor.shape, as_floats(tensor, file.path().string())};
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
