// The `sequence` section of recipes.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/config_visitor.h"

namespace ld {

/// Consecutive frames of one scene: frame i belongs to sequence i / length.
struct SequenceConfig {
  int64_t length = 1;           // frames; 1: every frame its own scene
  double shutter = 0.5;         // share of the time between frames that the shutter is open; 0: an instant
  double speed = 1;             // of camera and objects; 0: all stand still
  int64_t noise_instances = 1;  // independent sets of samples a frame
  std::vector<std::string> kinds = {"fly"};  // what happens: sequence i is of kind i % kinds

  bool used() const { return length > 1; }
  const std::string& kind_of(int64_t sequence) const {
    return kinds[static_cast<size_t>(sequence) % kinds.size()];
  }

  template <class Visitor>
  void visit(Visitor& v) {
    v.field("length", length, Range{1, 100000});
    v.field("shutter", shutter, Range{0, 1});
    v.field("speed", speed, Range{0, 10});
    v.field("noise_instances", noise_instances, Range{1, 16});
    v.field("kinds", kinds, kind_names());
  }

  /// render/recipe/shots.h says what they are.
  static std::vector<std::string> kind_names();
};

}  // namespace ld
