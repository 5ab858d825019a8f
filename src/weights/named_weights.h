// The weights of a network by the names of its parameters, as float32.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "weights/safetensors.h"

namespace ld {

/// A weight whose first dimension is that of its outputs, in 8 bits. In a file it is an I8 tensor NAME beside
/// F32 tensors NAME.scale [outputs] and NAME.input_range [1].
struct Quantised {
  std::vector<int8_t> levels;  // values are these times the scale of their output
  std::vector<float> scales;   // of each output
  float input_range = 1;       // of what they are multiplied with (ops/kernels/quantised_convolution.h)
};

struct NamedWeight {
  std::vector<int64_t> shape;
  std::vector<float> values;
  std::optional<Quantised> quantised = std::nullopt;
};

/// The weight in 8 bits: of each output the largest value is +-127 levels. Its values become those that the
/// levels stand for.
NamedWeight quantised(const NamedWeight& weight, float input_range);

/// Whether a tensor of the file is one of the scales of an I8 tensor there.
bool is_scale(const SafetensorsFile& file, const TensorView& tensor);

class NamedWeights {
 public:
  NamedWeights() = default;
  /// All tensors of a file, quantised ones with their scales. Throws Error for one that holds no floats or 8
  /// bits, for one that is not finite, and for a scale that is missing, of another shape or no positive
  /// number.
  explicit NamedWeights(const SafetensorsFile& file);

  void add(const std::string& name, NamedWeight weight) { weights_[name] = std::move(weight); }
  /// Throws Error when there is no such weight.
  const NamedWeight& at(const std::string& name) const;

 private:
  std::map<std::string, NamedWeight> weights_;
};

}  // namespace ld
