// What ld_bench network shows beside its rows, of networks in the runtime: time by the number of samples,
// multiply-adds by the number of samples ([MH20] figure 10), time by stage ([MH20] table 3).
#pragma once

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

#include "benchmark/workloads.h"
#include "plot/svg_plot.h"

namespace ld {

/// The layer network's time of inference.
struct SampleTime {
  int64_t spp;
  double ms, ratio;  // to the time at 8 spp
};
std::vector<SampleTime> time_by_samples(const BenchSizes& sizes, const std::vector<int64_t>& spp,
                                        int repeats);

/// Multiply-adds a pixel of a network (models/graphs/network_cost.h) at each number of samples.
struct NetworkCosts {
  std::string network;
  std::vector<double> per_pixel;
};
std::vector<NetworkCosts> cost_by_samples(const BenchSizes& sizes, const std::vector<int64_t>& spp);

/// Time of one stage of a network with layers, and its part of the multiply-adds a pixel. The reducer's has
/// the encoding of features, the U-net's the mean of the embeddings, the partitioner's the sums of layers.
struct StageTime {
  std::string stage;
  double ms, multiply_adds;
};
struct NetworkStages {
  std::string network;
  std::vector<StageTime> stages;  // reducer, U-net, partitioner, layer filtering
};
std::vector<NetworkStages> time_by_stage(const BenchSizes& sizes, int repeats);

/// What the network of a training configuration costs: {"config", "parameters", "multiply_adds_per_pixel",
/// "inference_ms", "inference_peak_mb", "training_ms", "training_peak_mb"}.
nlohmann::ordered_json measure_network(const std::string& file, const BenchSizes& sizes, int repeats);

/// The sweeps as text tables, figures and JSON.
std::string markdown(const std::vector<SampleTime>& times);
std::string markdown(const std::vector<NetworkCosts>& costs, const std::vector<int64_t>& spp);
std::string markdown(const std::vector<NetworkStages>& stages);
LinePlot figure(const std::vector<SampleTime>& times);
LinePlot figure(const std::vector<NetworkCosts>& costs, const std::vector<int64_t>& spp);
BarPlot figure(const std::vector<NetworkStages>& stages);
nlohmann::ordered_json to_json(const std::vector<SampleTime>& times);
nlohmann::ordered_json to_json(const std::vector<NetworkCosts>& costs, const std::vector<int64_t>& spp);
nlohmann::ordered_json to_json(const std::vector<NetworkStages>& stages);

}  // namespace ld
