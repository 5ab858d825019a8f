// The weights of a network by the names of its parameters, as float32.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "weights/safetensors.h"

namespace ld {

struct NamedWeight {
  std::vector<int64_t> shape;
  std::vector<float> values;
};

class NamedWeights {
 public:
  NamedWeights() = default;
  /// All tensors of a file. Throws Error for one that holds no floats, or one that is not finite.
  explicit NamedWeights(const SafetensorsFile& file);

  void add(const std::string& name, NamedWeight weight) { weights_[name] = std::move(weight); }
  /// Throws Error when there is no such weight.
  const NamedWeight& at(const std::string& name) const;

 private:
  std::map<std::string, NamedWeight> weights_;
};

}  // namespace ld
