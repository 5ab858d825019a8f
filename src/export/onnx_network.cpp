#include "export/onnx_network.h"

#include <algorithm>

#include "core/error.h"
#include "export/onnx_walk.h"
#include "models/graphs/network_graph.h"

namespace ld {

void OnnxWalk::enter(const graph::Node& node) {
  node_ = &node;
  std::string scope = out().name;
  std::replace(scope.begin(), scope.end(), '.', '/');  // which viewers fold
  if (out().level > 0 && !out().padded) scope += "/level" + std::to_string(out().level);
  g.enter(std::move(scope));
}

const OnnxWalk::Made& OnnxWalk::made(graph::ValueId id) const {
  if (made_[id].value.name.empty()) fail("ONNX: nothing makes the graph's value '{}'", network_[id].name);
  return made_[id];
}

Value OnnxWalk::picture(graph::ValueId id) {
  const Made& from = made(id);
  return from.is_picture ? from.value : g.squeeze(from.value, 1);
}

Value OnnxWalk::read_picture(size_t input) {
  const Value whole = picture(node_->inputs[input]);
  return in(input).padded && !out().padded ? cropped(whole, out()) : whole;
}

Value OnnxWalk::read(size_t input) {
  const Made& from = made(node_->inputs[input]);
  return from.is_picture ? g.unsqueeze(read_picture(input), 1) : from.value;
}

Value OnnxWalk::side(const graph::Value& of, int64_t axis) {
  const Value pixels = g.size_of(valid, axis);
  const auto parts = [&](int64_t of_so_many) {  // rounded up
    return g.div(g.add(pixels, g.whole({of_so_many - 1})), g.whole({of_so_many}));
  };
  const int64_t scale = int64_t{1} << of.level;
  if (of.padded) return g.mul(parts(network_.multiple), g.whole({network_.multiple / scale}));
  return scale == 1 ? pixels : parts(scale);
}

namespace {

/// Of a value of the state, for people: "H" and "W" are those of the frame.
std::vector<std::string> sizes_of_state(const graph::Value& value) {
  const std::string scale =
      value.padded || value.level > 0 ? "padded/" + std::to_string(int64_t{1} << value.level) : "";
  const auto side = [&](const char* name) { return scale.empty() ? name : name + ("_" + scale); };
  return {"B", std::to_string(value.channels), side("H"), side("W")};
}

}  // namespace

std::string onnx_state(size_t part) {
  return "state" + std::to_string(part);
}

std::string onnx_next_state(size_t part) {
  return "next_" + onnx_state(part);
}

Value OnnxWalk::state(size_t part) {
  return g.input(onnx_state(part), sizes_of_state(network_[network_.state[part]]));
}

onnx::ModelProto onnx_model(const graph::Graph& network, const std::vector<TensorView>& weights) {
  OnnxGraph g(weights);
  OnnxWalk walk(g, network);
  for (const graph::Node& node : network.nodes) {
    walk.enter(node);
    std::visit([&](const auto& op) { to_onnx(op, walk); }, node.op);
  }
  g.output(walk.picture(network.output), "image", {"B", "3", "H", "W"});
  for (size_t part = 0; part < network.state.size(); ++part)
    g.output(walk.picture(network.state[part]), onnx_next_state(part),
             sizes_of_state(network[network.state[part]]));
  return g.model();
}

onnx::ModelProto onnx_model(const NetworkConfig& config, const std::vector<TensorView>& weights) {
  return onnx_model(network_graph(config), weights);
}

}  // namespace ld
