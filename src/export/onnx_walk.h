// A walk over a network's graph (graph/graph.h) that adds to an ONNX graph what each node computes.
#pragma once

#include <limits>

#include "export/onnx_graph.h"
#include "graph/graph.h"
#include "ops/kernels/constants.h"

namespace ld {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
/// What logits are bounded by.
constexpr float kLargestLogit = -kLowestLogit;

/// The node that the walk has come to, and what the graph's values before it have become: [B, items, C, H,
/// W], or [B, C, H, W] for a picture. Either form of a picture is made from the other where a node reads it.
class OnnxWalk {
 public:
  OnnxWalk(OnnxGraph& onnx, const graph::Graph& network)
      : g(onnx), network_(network), made_(network.values.size()) {}

  OnnxGraph& g;
  Value valid;     // the model's input, [B, S, 1, H, W]
  Value exposure;  // [B, 1, 1, 1, 1]; none where the network sees radiance as it is

  /// Nodes to come get names after what this one makes.
  void enter(const graph::Node& node);

  bool exposed() const { return network_.exposed; }
  int64_t layers() const { return network_.layers; }
  size_t inputs() const { return node_->inputs.size(); }
  const graph::Value& in(size_t i) const { return network_[node_->inputs[i]]; }
  const graph::Value& out(size_t i = 0) const { return network_[node_->outputs[i]]; }

  /// Inputs [B, items, C, H, W] and [B, C, H, W]. Of a padded picture a node reads what it makes itself.
  Value read(size_t input);
  Value read_picture(size_t input);

  void make(Value value, size_t output = 0) { made_[node_->outputs[output]] = {std::move(value), false}; }
  void make_picture(Value value) { made_[node_->outputs[0]] = {std::move(value), true}; }

  /// The model's input `state<part>`: what the frame before has left [B, C, H, W], zeros at the first frame.
  Value state(size_t part);

  /// The network's result.
  Value picture(graph::ValueId id);

  // Sizes, int64 [1].
  Value batch() { return g.size_of(valid, 0); }
  Value height(const graph::Value& of) { return side(of, 3); }
  Value width(const graph::Value& of) { return side(of, 4); }
  Value cropped(const Value& picture, const graph::Value& to) {
    return g.slice(g.slice(picture, 2, 0, height(to)), 3, 0, width(to));
  }

 private:
  struct Made {
    Value value;
    bool is_picture = false;  // without an axis for its one item
  };
  const Made& made(graph::ValueId id) const;
  Value side(const graph::Value& of, int64_t axis);

  const graph::Graph& network_;
  const graph::Node* node_ = nullptr;
  std::vector<Made> made_;
};

/// ops/fully_connected.h, the first `outputs` of them: x [B, n, own, H, W] and `context` [B, Y, H, W] or
/// nothing -> [B, n, outputs, H, W].
Value onnx_fully_connected(OnnxGraph& g, const graph::FullyConnected& op, int64_t outputs, const Value& x,
                           int64_t own, const Value& context = {});

/// Mean over the valid items, [B, n, C, H, W] -> [B, 1, C, H, W]; 0 where none is.
Value onnx_masked_mean(OnnxGraph& g, const Value& values, const Value& valid);

/// Mean and population variance over the valid items, [B, n, C, H, W] -> [B, 1, 2 C, H, W].
Value onnx_statistics(OnnxGraph& g, const Value& values, const Value& valid);

/// The four pixels that become one, [B, N, C, H, W] -> [B, 4, N, C, ceil(H / 2), ceil(W / 2)]; `missing`
/// stands for those beyond an odd border.
Value onnx_four_pixels(OnnxGraph& g, const Value& planes, float missing);

/// core/tone_map.h for x >= 0, and back.
Value onnx_tone_mapped(OnnxGraph& g, const Value& x);
Value onnx_tone_map_inverse(OnnxGraph& g, const Value& mapped);

/// What each sample's radiance is divided by (models/demodulation.h), [B, S, 3, H, W]. First channels of the
/// features that are there, else -1.
Value onnx_demodulator(OnnxGraph& g, const Value& features, int64_t albedo, int64_t specular);

/// c x / (c + |x|) (ops/fully_connected.h).
Value onnx_bounded_softly(OnnxGraph& g, const Value& x, float c);

/// Leaky ReLU as everywhere in [MH20].
inline Value onnx_activated(OnnxGraph& g, const Value& x, double slope = kLeakySlope) {
  return g.op("LeakyRelu", {x}, {{"alpha", float(slope)}});
}

// Adds what an operator computes. One for each; files by kind, as in src/runtime/.
void to_onnx(const graph::Encode& op, OnnxWalk& at);
void to_onnx(const graph::MaskedMean& op, OnnxWalk& at);
void to_onnx(const graph::AnyValid& op, OnnxWalk& at);
void to_onnx(const graph::LogValid& op, OnnxWalk& at);
void to_onnx(const graph::FirstValid& op, OnnxWalk& at);
void to_onnx(const graph::Statistics& op, OnnxWalk& at);
void to_onnx(const graph::ToneMapped& op, OnnxWalk& at);
void to_onnx(const graph::FullyConnected& op, OnnxWalk& at);
void to_onnx(const graph::Pad& op, OnnxWalk& at);
void to_onnx(const graph::Convolution& op, OnnxWalk& at);
void to_onnx(const graph::EdgeConvolution& op, OnnxWalk& at);
void to_onnx(const graph::SpaceToDepth& op, OnnxWalk& at);
void to_onnx(const graph::DepthToSpace& op, OnnxWalk& at);
void to_onnx(const graph::HalveLight& op, OnnxWalk& at);
void to_onnx(const graph::Relight& op, OnnxWalk& at);
void to_onnx(const graph::Channels& op, OnnxWalk& at);
void to_onnx(const graph::Add& op, OnnxWalk& at);
void to_onnx(const graph::Reflectance& op, OnnxWalk& at);
void to_onnx(const graph::GatherTaps& op, OnnxWalk& at);
void to_onnx(const graph::MaxPool& op, OnnxWalk& at);
void to_onnx(const graph::Upsample& op, OnnxWalk& at);
void to_onnx(const graph::Halve& op, OnnxWalk& at);
void to_onnx(const graph::Received& op, OnnxWalk& at);
void to_onnx(const graph::BlendLevels& op, OnnxWalk& at);
void to_onnx(const graph::Demodulate& op, OnnxWalk& at);
void to_onnx(const graph::Partition& op, OnnxWalk& at);
void to_onnx(const graph::Reject& op, OnnxWalk& at);
void to_onnx(const graph::Splat& op, OnnxWalk& at);
void to_onnx(const graph::Gather& op, OnnxWalk& at);
void to_onnx(const graph::Blur& op, OnnxWalk& at);
void to_onnx(const graph::Mix& op, OnnxWalk& at);
void to_onnx(const graph::Composite& op, OnnxWalk& at);
void to_onnx(const graph::ModulationFactors& op, OnnxWalk& at);
void to_onnx(const graph::Modulate& op, OnnxWalk& at);
void to_onnx(const graph::LayerIdentity& op, OnnxWalk& at);
void to_onnx(const graph::TakeRoots& op, OnnxWalk& at);
void to_onnx(const graph::RaiseRoots& op, OnnxWalk& at);
void to_onnx(const graph::RecallPart& op, OnnxWalk& at);
void to_onnx(const graph::Recall& op, OnnxWalk& at);
void to_onnx(const graph::Compare& op, OnnxWalk& at);
void to_onnx(const graph::Remember& op, OnnxWalk& at);

}  // namespace ld
