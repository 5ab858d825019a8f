// What ld_bench times: operators as the networks of [MH20] call them, and whole networks.
#pragma once

#include <torch/torch.h>

#include <functional>
#include <string>
#include <vector>

#include "benchmark/measure.h"
#include "models/network.h"

namespace ld {

struct PictureSize {
  int64_t width, height;
};

struct BenchSizes {
  std::string configs = "configs";  // folder of the YAML files that hold the networks' sizes
  bool quick = false;               // the small networks of quick*.yaml
  int64_t inference = 256;          // side of the picture, pixels; for operators too
  int64_t training = 128;
  int64_t spp = 8;
  std::vector<PictureSize> pictures = {{128, 128}, {1280, 720}, {1920, 1080}};  // for the runtime
};

/// A row that has not been set up yet: `make` allocates its input.
struct RowSpec {
  std::string name;
  std::function<Workload()> make;
};

/// The network of a training configuration. Throws Error when the file is missing, UsageError when it is
/// none.
NetworkConfig read_network_config(const std::string& file);

/// The network's sizes: of CONFIGS/NAME.yaml; when quick, of quick_NAME.yaml (quick.yaml for the layer
/// network).
NetworkConfig bench_config(const BenchSizes& sizes, const std::string& network);

/// Random numbers as of a frame in which every sample is valid; float32, batch 1.
NetworkInput bench_input(const NetworkConfig& config, int64_t spp, int64_t side);

/// A network with Xavier weights.
std::shared_ptr<Network> bench_network(const NetworkConfig& config);

/// A frame through the runtime, whose composition is the LibTorch network without gradients; and a forward
/// pass of the LibTorch network with the SMAPE loss and the gradients of all weights, without the optimiser's
/// step, whose composition takes a slice of the logits for each tap, as the published code does. Pictures of
/// side x side pixels.
Workload inference_workload(const NetworkConfig& config, int64_t spp, int64_t side);
Workload training_workload(const NetworkConfig& config, int64_t spp, int64_t side);

/// reducer_, partition_, splat17_, gather17_ with _forward and _train. The operators have the sizes of the
/// layer network; _train is a forward pass that keeps what it needs, and the backward pass.
std::vector<RowSpec> operator_rows(const BenchSizes& sizes);

/// Inference of every network, layer_infer_256 and so on; training of those with layers.
std::vector<RowSpec> network_rows(const BenchSizes& sizes);

}  // namespace ld
