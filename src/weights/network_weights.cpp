#include "weights/network_weights.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <set>

#include "core/error.h"
#include "graph/extent.h"
#include "models/graphs/network_graph.h"
#include "weights/checkpoint_files.h"
#include "weights/weight_file.h"

namespace ld {
namespace {

graph::Graph graph_of(const SafetensorsFile& file, const NetworkConfig& config) {
  try {
    return network_graph(config);
  } catch (const UsageError& error) {  // nobody typed this network: the file is wrong
    fail("{}: metadata: network: {}", file.path().string(), error.what());
  }
}

void expect_parameters(const SafetensorsFile& file, const NetworkConfig& config, const graph::Graph& graph) {
  const int64_t expected = graph::parameter_count(graph);
  int64_t held = 0;
  std::vector<TensorView> tensors;  // scales of quantised ones aside
  std::copy_if(file.tensors().begin(), file.tensors().end(), std::back_inserter(tensors),
               [&](const TensorView& tensor) { return !is_scale(file, tensor); });
  for (const TensorView& tensor : tensors) held += tensor.numbers();
  if (held != expected)
    fail("{}: holds {} numbers, but the network of its metadata ('{}') has {}; the file is damaged",
         file.path().string(), held, config.name, expected);
  std::set<std::string> names;
  for (const graph::Parameter& parameter : graph::parameters(graph)) {
    const TensorView& stored = file.tensor(parameter.name);
    if (stored.shape != parameter.shape)
      fail("{}: tensor '{}' has the shape [{}]; its network config needs [{}]; the file is damaged",
           file.path().string(), parameter.name, fmt::join(stored.shape, ", "),
           fmt::join(parameter.shape, ", "));
    names.insert(parameter.name);
  }
  for (const TensorView& tensor : tensors)
    if (names.count(tensor.name) == 0)
      fail("{}: holds a tensor '{}' that its network config has no place for; the file is damaged",
           file.path().string(), tensor.name);
}

}  // namespace

NetworkWeights read_network_weights(const std::filesystem::path& model) {
  const std::filesystem::path path = resolve_model(model);
  if (exists(path.parent_path() / "checksums.json") && path.filename() == kCheckpointFiles[0])
    verify_checkpoint_file(path.parent_path(), kCheckpointFiles[0]);
  const SafetensorsFile file(path);
  NetworkWeights network;
  network.config = read_weights_header(file).network;
  network.graph = graph_of(file, network.config);
  expect_parameters(file, network.config, network.graph);
  network.weights = NamedWeights(file);
  return network;
}

}  // namespace ld
