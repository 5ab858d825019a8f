#include "training/training_data.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "core/checksum.h"
#include "core/error.h"
#include "core/log.h"
#include "dataset/shot.h"
#include "dataset/varying_features.h"
#include "frame/frame_file.h"
#include "frame/schema.h"
#include "training/optimizer/stage_scheme.h"
#include "weights/network_weights.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

constexpr uint64_t kMegabyte = uint64_t{1} << 20;
constexpr uint64_t kValidationMemory = 256 * kMegabyte;  // where no cache file can be written

/// Frames of one of the sets, which a store is made of.
std::vector<ManifestFrame> frames_of(const DataConfig& config, const std::string& path,
                                     const std::string& split) {
  if (!config.sample_targets()) return frames_of_split(path, split);
  return of_split(frames_of_shot(path, static_cast<int>(config.held_out)), split);
}

/// The network of `init` without those of its optional features that some frame lacks.
NetworkConfig network_of_init(const TrainConfig& config) {
  if (config.init.empty())
    fail_usage(
        "network.name is '{}', the network of the weights to begin with, but init is empty; say "
        "init=FILE_OR_NAME, released weights for instance, or name a network",
        kNetworkOfInit);
  NetworkConfig network = read_network_weights(config.init).config;
  std::vector<std::string> left_out;
  for (const DataSetConfig& set : data_sets(config.data))
    for (const ManifestFrame& frame : frames_of(config.data, set.path, "train")) {
      const std::vector<std::string> held = read_frame_header(frame_path(set.path, frame.name)).features;
      for (const std::string& name : network.optional)
        if (std::find(held.begin(), held.end(), name) == held.end() &&
            std::find(left_out.begin(), left_out.end(), name) == left_out.end())
          left_out.push_back(name);
    }
  const auto is_out = [&](const std::string& name) {
    return std::find(left_out.begin(), left_out.end(), name) != left_out.end();
  };
  for (std::vector<std::string>* names : {&network.features, &network.optional})
    names->erase(std::remove_if(names->begin(), names->end(), is_out), names->end());
  spdlog::info("network of {}: '{}' of {}; its features that the frames lack: {}", config.init, network.name,
               fmt::join(network.features, ", "),
               left_out.empty() ? "none" : fmt::format("{}", fmt::join(left_out, ", ")));
  return network;
}

/// Crops at full resolution, of whose light some is at half of it.
int crop_multiple(const NetworkConfig& network) {
  return static_cast<int>(network_traits(network.name).upscaling);
}

std::vector<std::string> found_features(const DataConfig& config) {
  std::vector<fs::path> folders;
  for (const DataSetConfig& set : data_sets(config)) folders.emplace_back(set.path);
  spdlog::info("looking for features that vary in the training split ...");
  const std::vector<std::string> features =
      varying_features(folders, "train", static_cast<int>(torch::get_num_threads()));
  std::vector<std::string> left_out;
  for (const std::string& name : mh20_feature_names())
    if (std::find(features.begin(), features.end(), name) == features.end()) left_out.push_back(name);
  spdlog::info("network.features=auto: {}; left out: {}", fmt::join(features, ", "),
               left_out.empty() ? "nothing" : fmt::format("{}", fmt::join(left_out, ", ")));
  return features;
}

}  // namespace

std::vector<DataSetConfig> data_sets(const DataConfig& config) {
  if (config.path.empty() && config.paths.empty())
    fail_usage("data.path is empty; say data.path=FOLDER, a data set that ld_render or ld_import wrote");
  if (!config.path.empty() && !config.paths.empty())
    fail_usage("data.path and data.paths are both given; list all data sets in data.paths, or use data.path");
  if (config.paths.empty()) return {{config.path, 1}};
  std::set<fs::path> seen;
  for (size_t i = 0; i < config.paths.size(); ++i) {
    const std::string& path = config.paths[i].path;
    if (path.empty()) fail_usage("data.paths[{}].path is empty; expected the folder of a data set", i);
    if (!seen.insert(fs::weakly_canonical(fs::absolute(path))).second)
      fail_usage("data.paths[{}]: {} stands twice; give it a larger weight instead", i, path);
  }
  return config.paths;
}

SampleRange sample_range(const DataConfig& config) {
  const std::vector<int64_t>& samples = config.samples;
  if (samples.empty()) return {};
  if (samples.size() != 2 || samples[0] > samples[1])
    fail_usage(
        "data.samples: [{}]; expected [LEAST, MOST], the fewest and the most samples of a batch, or [] for "
        "all "
        "samples of the frames",
        fmt::join(samples, ", "));
  return {static_cast<int>(samples[0]), static_cast<int>(samples[1])};
}

ValidationSamples validation_samples(const DataConfig& config) {
  const auto asked = static_cast<int>(config.validation_samples);
  if (asked > 0 || config.sample_targets()) return {asked, config.sample_targets()};
  return {sample_range(config).most, false};
}

void fit_to_features(NetworkConfig& network) {
  const auto held = [&](const std::string& name) { return first_channel(network.features, name) >= 0; };
  network.optional.erase(std::remove_if(network.optional.begin(), network.optional.end(),
                                        [&](const std::string& name) { return !held(name); }),
                         network.optional.end());
  if (network.demodulation == "none" || held("albedo")) return;
  spdlog::info("network.demodulation=none: no albedo varies in the data");
  network.demodulation = "none";
}

TrainConfig resolve_network(TrainConfig config, const fs::path& run) {
  const fs::path stored = run / "config.yaml";
  if (fs::exists(stored) && (config.network.of_init() || config.network.auto_features())) {
    const NetworkConfig begun = config_from_tree<TrainConfig>(read_config(stored)).network;
    if (config.network.of_init()) config.network = begun;
    config.network.features = begun.features;
    return config;
  }
  if (config.network.of_init()) config.network = network_of_init(config);
  if (config.network.auto_features()) config.network.features = found_features(config.data);
  return config;
}

Noisy noisy_beside(const NetworkConfig& network) {
  if (network_traits(network.name).upscaling == 1) return Noisy::none;
  return first_channel(network.features, "half_radiance") >= 0 ? Noisy::same : Noisy::others;
}

TrainingSet make_training_set(const TrainConfig& config, int rank, int processes) {
  const DataConfig& data = config.data;
  if (config.optimizer.scheme != "end_to_end" && network_traits(config.network.name).upscaling == 1)
    fail_usage(
        "optimizer.scheme is '{}', but network '{}' has one stage, which learns as a whole; leave it out or "
        "use "
        "'espcn_kpcn'",
        config.optimizer.scheme, config.network.name);
  const std::vector<DataSetConfig> sets = data_sets(data);
  const CacheOptions cache = {data.cache,
                              static_cast<uint64_t>(data.cache_megabytes) * kMegabyte / sets.size()};
  std::vector<WeightedStore> stores;
  for (const DataSetConfig& set : sets)
    stores.push_back({std::make_unique<FrameStore>(set.path, frames_of(data, set.path, "train"),
                                                   config.network.features, cache),
                      set.weight});
  TrainingSetOptions options;
  options.augmentation = {static_cast<int>(data.crop),
                          data.flips,
                          data.rotations,
                          static_cast<int>(data.difficulty),
                          static_cast<float>(data.exposure),
                          data.colours,
                          data.reversal,
                          static_cast<float>(data.tint),
                          static_cast<float>(data.stop),
                          static_cast<float>(data.freeze),
                          crop_multiple(config.network)};
  options.samples = sample_range(data);
  options.sample_targets = data.sample_targets();
  if (needs_noisy(config.optimizer)) options.noisy = noisy_beside(config.network);
  options.drop = data.drop;
  options.optional = config.network.optional;
  options.clip = static_cast<int>(data.clip);
  options.batch = data.batch;
  options.accumulate = config.optimizer.accumulate;
  options.seed = config.seed;
  options.workers = static_cast<int>(data.workers);
  options.rank = rank;
  options.processes = processes;
  return TrainingSet(std::move(stores), config.network.features, options);
}

std::vector<std::unique_ptr<FrameStore>> make_validation_stores(const TrainConfig& config) {
  const int asked = static_cast<int>(config.data.validation_samples),
            least = asked > 0 ? asked : sample_range(config.data).least;
  std::vector<std::unique_ptr<FrameStore>> stores;
  for (const DataSetConfig& set : data_sets(config.data)) {
    std::vector<ManifestFrame> frames = config.data.sample_targets()
                                            ? frames_of(config.data, set.path, "validation")
                                            : of_split(read_manifest(set.path).frames, "validation");
    if (!frames.empty())
      stores.push_back(std::make_unique<FrameStore>(set.path, std::move(frames), config.network.features,
                                                    CacheOptions{config.data.cache, kValidationMemory}));
  }
  for (const std::unique_ptr<FrameStore>& store : stores)
    for (size_t i = 0; i < store->size(); ++i)
      if (store->spp(i) < least)
        fail_usage(
            "{}: the validation frame {} has {} samples a pixel, fewer than {}; render more, or set it to {} "
            "or less",
            asked > 0 ? "data.validation_samples" : "data.samples", store->name(i), store->spp(i), least,
            store->spp(i));
  return stores;
}

std::string data_checksum(const DataConfig& config) {
  std::vector<std::string> checksums;
  for (const DataSetConfig& set : data_sets(config))
    checksums.push_back(config.sample_targets() ? shot_state(set.path)
                                                : file_checksum(fs::path(set.path) / "manifest.json"));
  return fmt::format("{}", fmt::join(checksums, "+"));
}

}  // namespace ld
