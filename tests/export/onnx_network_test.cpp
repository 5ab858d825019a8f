#include "export/onnx_network.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <set>

#include "export/onnx_evaluator.h"
#include "export/onnx_file.h"
#include "graph/extent.h"
#include "models/check_network.h"
#include "models/graphs/network_graph.h"
#include "models/graphs/shared_graph.h"
#include "tests/models/small_network.h"
#include "tests/support/expect_error.h"

namespace ld {
namespace {

/// Zeros for all that a graph reads.
struct ZeroWeights {
  std::deque<std::vector<float>> data;
  std::vector<TensorView> views;

  explicit ZeroWeights(const graph::Graph& graph) {
    for (const graph::Parameter& parameter : graph::parameters(graph)) {
      size_t count = 1;
      for (const int64_t side : parameter.shape) count *= size_t(side);
      const std::vector<float>& zeros = data.emplace_back(count, 0.0F);
      views.push_back(
          {parameter.name, DType::f32, parameter.shape, zeros.data(), zeros.size() * sizeof(float)});
    }
  }
};

/// Every network with every choice that its graph depends on.
std::vector<NetworkConfig> configs_of_all_choices() {
  std::vector<NetworkConfig> configs;
  for (NetworkConfig config : every_config())
    for (int choices = 0; choices < 16; ++choices) {
      config.exposure_normalisation = (choices & 1) != 0 && may_be_exposed(config);
      config.means = (choices & 2) != 0 && works_on_pixels(config);
      config.unet.upsampling = (choices & 4) != 0 ? "nearest" : "bilinear";
      if (has_layers(config)) config.layers = (choices & 8) != 0 ? 1 : 3;
      if (network_traits(config.name).has_levels) config.levels = (choices & 8) != 0 ? 1 : 3;
      configs.push_back(config);
    }
  return configs;
}

TEST(OnnxNetwork, EveryOperatorOfEveryGraphIsTranslated) {
  std::set<size_t> translated;
  for (const NetworkConfig& config : configs_of_all_choices()) {
    const graph::Graph graph = network_graph(config);
    for (const graph::Node& node : graph.nodes) translated.insert(node.op.index());
    const ZeroWeights weights(graph);
    // Runs ONNX's own checker and its strict shape inference.
    const onnx::ModelProto model = parse_onnx(onnx_bytes(onnx_model(config, weights.views)), title(config));
    std::set<std::string> read;
    for (const onnx::ValueInfoProto& output : model.graph().output()) read.insert(output.name());
    for (const onnx::NodeProto& node : model.graph().node())
      read.insert(node.input().begin(), node.input().end());
    for (const onnx::NodeProto& node : model.graph().node())
      EXPECT_TRUE(std::any_of(node.output().begin(), node.output().end(),
                              [&](const std::string& output) { return read.count(output) == 1; }))
          << title(config) << " makes for nothing " << node.name();
    EXPECT_EQ(size_t(model.graph().input_size()), 3 + graph.state.size());
  }
  // A recurrent network has its state as inputs and outputs.
  const NetworkConfig recurrent = small_recurrent_config();
  const graph::Graph graph = network_graph(recurrent);
  for (const graph::Node& node : graph.nodes) translated.insert(node.op.index());
  const ZeroWeights weights(graph);
  const onnx::ModelProto model =
      parse_onnx(onnx_bytes(onnx_model(recurrent, weights.views)), title(recurrent));
  EXPECT_EQ(size_t(model.graph().input_size()), 3 + graph.state.size());
  EXPECT_EQ(size_t(model.graph().output_size()), 1 + graph.state.size());
  // Layers' identity is of views of layers, which are no networks; the next test has it.
  translated.insert(graph::Operator(graph::LayerIdentity{}).index());
  EXPECT_EQ(translated.size(), std::variant_size_v<graph::Operator>);
}

TEST(OnnxNetwork, ALayersIdentityIsOneInItsOwnChannel) {
  graph::Graph graph;
  graph.layers = 4;
  const NetworkConfig config = small_config();
  add_input(graph, config);
  const graph::ValueId identity =
      graph.add(graph::LayerIdentity{}, {}, {"identity", graph::Items::layers, 4});
  graph.output = graph.add(graph::Composite{}, {identity}, {"picture", graph::Items::picture, 3});
  const OnnxEvaluator evaluator(parse_onnx(onnx_bytes(onnx_model(graph, {})), "identity"));
  const torch::Tensor image = evaluator.forward(random_input(config, 2, 3, 5, 4, torch::kFloat32));
  EXPECT_EQ(image.sizes(), (std::vector<int64_t>{2, 3, 5, 4}));
  // The first layer lets nothing of the others through.
  EXPECT_TRUE(image.equal(torch::tensor({1.0F, 0.0F, 0.0F}).view({1, 3, 1, 1}).expand({2, 3, 5, 4})));
}

TEST(OnnxNetwork, WeightsThatAreMissingOrTooManyAreNamed) {
  const graph::Graph graph = network_graph(small_config());
  ZeroWeights weights(graph);
  const std::string last = weights.views.back().name;
  weights.views.push_back(weights.views.back());
  weights.views.back().name = "unknown.weight";
  EXPECT_ERROR(onnx_model(small_config(), weights.views), "leaves out its weight 'unknown.weight'");
  weights.views.resize(weights.views.size() - 2);
  EXPECT_ERROR(onnx_model(small_config(), weights.views), "no weight '" + last + "'");
}

}  // namespace
}  // namespace ld
