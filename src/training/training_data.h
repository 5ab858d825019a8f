// From the data: section of a configuration to what a training reads.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "dataset/training_set.h"
#include "training/run/config.h"
#include "training/validation.h"

namespace ld {

/// The data sets of `path` or `paths`. Throws UsageError when there are none, both are given, or one stands
/// twice.
std::vector<DataSetConfig> data_sets(const DataConfig& config);

/// data.samples. Throws UsageError unless it holds no number, or two in ascending order.
SampleRange sample_range(const DataConfig& config);

/// How many samples of each frame validate, the first ones, and against what.
ValidationSamples validation_samples(const DataConfig& config);

/// Adapts the settings that name features to features that were found in the data (kAutoFeatures): those not
/// found are no longer optional, and without an albedo there is no demodulation.
void fit_to_features(NetworkConfig& network);

/// Replaces what only weights and data can tell about the network (kNetworkOfInit, kAutoFeatures): by what
/// the run's stored configuration says, so that a run continues with the network that it began with; for a
/// new run by the network of `init`, and by what varying_features() finds; logs what it left out. Throws
/// UsageError where there is no `init`.
TrainConfig resolve_network(TrainConfig config, const std::filesystem::path& run);

/// What stands beside the crops of a network in two stages: samples that it does not see, or, where the
/// frames bring their light at half resolution, the samples themselves; nothing for networks of one stage.
Noisy noisy_beside(const NetworkConfig& network);

/// With several processes, each reads its own part of every batch.
TrainingSet make_training_set(const TrainConfig& config, int rank = 0, int processes = 1);

/// The validation splits of those data sets that have one. Throws UsageError for a frame with fewer samples
/// than data.validation_samples, or, where that is 0, than data.samples asks for at least.
std::vector<std::unique_ptr<FrameStore>> make_validation_stores(const TrainConfig& config);

/// A checksum over the manifests of all data sets (of a shot without one, over its files' names and sizes):
/// it changes when the data does.
std::string data_checksum(const DataConfig& config);

}  // namespace ld
