// What a network does to a frame at inference: typed operators between values whose height, width and number
// of samples are open. Free of LibTorch. models/graphs/ describes networks so; the runtime runs it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "graph/operators.h"

namespace ld::graph {

/// What is filtered beside a frame's radiance, with the weights of that: kernels are weights, so that what
/// adds up before them does so behind them.
struct LightParts {
  int64_t colours = 0;  // the first so many of Frame::parts
  bool alpha = false;   // Frame::alpha
  int64_t channels() const { return 3 * colours + (alpha ? 1 : 0); }
  bool operator==(const LightParts& other) const { return colours == other.colours && alpha == other.alpha; }
};

/// What a value has one of, at each of its pixels.
enum class Items { picture, samples, layers };

/// [items, channels, ceil(H / 2^level), ceil(W / 2^level)], H and W those of the frame, or of its padded
/// picture.
struct Value {
  std::string name;  // for people
  Items items = Items::picture;
  int64_t channels = 0;
  int level = 0;
  bool padded = false;  // of the picture whose sides are padded to Graph::multiple
  int64_t parts = 0;    // its last so many channels are of LightParts: nothing else depends on them
};

/// A value by its place in Graph::values.
using ValueId = size_t;

struct Node {
  Operator op;
  std::vector<ValueId> inputs, outputs;
};

struct Graph {
  int64_t layers = 0;    // items of values with layers
  int64_t multiple = 1;  // of which the sides of padded pictures are a multiple
  bool exposed = false;  // radiance is seen times the frame's exposure (models/exposure.h)
  LightParts parts;
  std::vector<Value> values;
  std::vector<Node> nodes;       // each behind those that it reads
  ValueId output = 0;            // [1, 3 + parts, H, W], linear radiance
  std::vector<ValueId> further;  // outputs beside it, of full resolution
  /// What the next frame reads, or nothing: light, frames and surface for Recall, or the parts of RecallPart,
  /// which may be of any resolution.
  std::vector<ValueId> state;

  /// The picture and further ones: of full resolution.
  std::vector<ValueId> outputs() const;

  ValueId add_value(Value value);
  /// A node with one output.
  ValueId add(Operator op, std::vector<ValueId> inputs, Value output);
  const Value& operator[](ValueId id) const { return values[id]; }
};

}  // namespace ld::graph
