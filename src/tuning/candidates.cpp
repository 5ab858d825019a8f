#include "tuning/candidates.h"

#include <fmt/format.h>

#include <algorithm>

#include "tuning/released_start.h"

namespace ld {
namespace {

struct Network {
  const char* key;
  const char* words;
  const char* name;  // models/networks.def
  int64_t layers;    // of networks that have them
  bool means;
  bool rejects;     // sends what can count less
  bool needs_many;  // has nothing of its own at one sample a pixel
  double rate;      // of the learning rate; pixel_splat collapses at that of layers
};
constexpr int64_t kNoLayers = 2;  // NetworkConfig's own, which networks without layers must keep
constexpr Network kNetworks[] = {
    {"layer2", "two layers of samples", "layer", 2, false, true, true, 1},
    {"pixel", "mean and variance of a pixel's samples", "pixel_splat", kNoLayers, false, true, true, 0.5},
    {"pyramid", "mean and variance of pixels, at three resolutions", "pixel_pyramid", kNoLayers, false, true,
     true, 0.5},
    {"means", "the mean of a pixel's samples", "pixel_gather", kNoLayers, true, false, false, 1},
    {"layer1", "one layer of samples", "layer", 1, false, true, true, 1},
    {"sample", "each sample by itself", "sample_splat", kNoLayers, false, true, true, 1},
    {"layer3", "three layers of samples", "layer", 3, false, true, true, 1},
};

/// Widths, depth and the kernels' taps a side. They are those of the released networks.
struct Size {
  const char* key;
  std::vector<int64_t> kernels;
  std::vector<int64_t> reducer, partitioner, generator;
  std::vector<std::vector<int64_t>> encoder;
  std::vector<int64_t> bottleneck;
  std::vector<std::vector<int64_t>> decoder;
  int64_t context;
  double rate;
};
const std::vector<Size>& sizes() {
  static const std::vector<Size> kSizes = {
      {"fast",
       {9, 5, 13},
       {16, 16, 16},
       {16, 16},
       {32, 32},
       {{16, 16}, {32}, {48}},
       {64},
       {{48, 48}, {32, 32}, {32, 32}},
       32,
       1},
      {"small", {9, 5}, {8, 8}, {8}, {16}, {{8, 8}, {16}}, {24}, {{16, 16}, {16}}, 16, 1},
      {"fine",
       {9},
       {24, 24, 24},
       {24, 16},
       {48, 48},
       {{32, 32}, {64}, {96}},
       {128},
       {{96, 96}, {64, 64}, {48, 48}},
       48,
       0.75},
      {"tiny", {5}, {6}, {6}, {8}, {{6}, {8}}, {12}, {{8}, {8}}, 8, 1},
  };
  return kSizes;
}

Candidate make(const TrainConfig& base, const DataSurvey& survey, const Network& network, const Size& size,
               int64_t kernel) {
  Candidate candidate{fmt::format("{}_{}_k{}", network.key, size.key, kernel), network.key, size.key, base};
  TrainConfig& config = candidate.config;
  config.optimizer.learning_rate *= network.rate * size.rate;
  NetworkConfig& made = config.network;
  made.name = network.name;
  made.layers = network.layers;
  made.means = network.means;
  made.rejection = network.rejects && made.rejection;
  made.kernel_size = kernel;
  made.sample_reducer = size.reducer;
  made.sample_partitioner = size.partitioner;
  made.kernel_generator = size.generator;
  made.unet.encoder = size.encoder;
  made.unet.bottleneck = size.bottleneck;
  made.unet.decoder = size.decoder;
  made.unet.context = size.context;
  candidate = with_features(std::move(candidate), survey.used());
  candidate.config.init = released_start(made);
  return candidate;
}

}  // namespace

std::string network_words(const std::string& network) {
  const auto* found = std::find_if(std::begin(kNetworks), std::end(kNetworks),
                                   [&](const Network& n) { return network == n.key; });
  return found == std::end(kNetworks) ? network : found->words;
}

std::vector<Candidate> candidate_space(const TrainConfig& base, const DataSurvey& survey) {
  std::vector<Candidate> space;
  const auto add_all = [&](const Size& size, int64_t kernel) {
    for (const Network& network : kNetworks)
      if (survey.samples > 1 || !network.needs_many)
        space.push_back(make(base, survey, network, size, kernel));
  };
  for (const Size& size : sizes()) add_all(size, size.kernels.front());
  for (const Size& size : sizes())
    for (size_t k = 1; k < size.kernels.size(); ++k) add_all(size, size.kernels[k]);
  return space;
}

Candidate with_features(Candidate candidate, const std::vector<std::string>& features) {
  NetworkConfig& network = candidate.config.network;
  network.features = features;
  network.optional.clear();
  if (std::find(features.begin(), features.end(), "albedo") == features.end()) network.demodulation = "none";
  return candidate;
}

std::vector<FeatureGroup> feature_groups(const std::vector<std::string>& used) {
  const std::vector<FeatureGroup> all = {{"place on the lens and circle of confusion", {"coc", "lens"}},
                                         {"movement and time", {"motion", "time", "flow"}},
                                         {"roughness", {"roughness"}},
                                         {"specular colour", {"specular"}}};
  std::vector<FeatureGroup> groups;
  for (const FeatureGroup& group : all) {
    FeatureGroup held{group.words, {}};
    for (const std::string& feature : group.features)
      if (std::find(used.begin(), used.end(), feature) != used.end()) held.features.push_back(feature);
    if (!held.features.empty()) groups.push_back(held);
  }
  return groups;
}

}  // namespace ld
