// From the data: section of a configuration to what a training reads.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "dataset/training_set.h"
#include "training/run/config.h"

namespace ld {

/// The data sets of `path` or `paths`. Throws UsageError when there are none, both are given, or one stands
/// twice.
std::vector<DataSetConfig> data_sets(const DataConfig& config);

/// data.samples. Throws UsageError unless it holds no number, or two in ascending order.
SampleRange sample_range(const DataConfig& config);

/// How many samples of each frame validate, the first ones; 0: all.
int validation_samples(const DataConfig& config);

/// Adapts the settings that name features to features that were found in the data (kAutoFeatures): those not
/// found are no longer optional, and without an albedo there is no demodulation.
void fit_to_features(NetworkConfig& network);

/// Replaces `network.features: auto` by the list in the run's stored configuration, so that a run continues
/// with the features it began with, or, for a new run, by what varying_features() finds; logs what it left
/// out.
TrainConfig resolve_features(TrainConfig config, const std::filesystem::path& run);

/// With several processes, each reads its own part of every batch.
TrainingSet make_training_set(const TrainConfig& config, int rank = 0, int processes = 1);

/// The validation splits of those data sets that have one. Throws UsageError for a frame with fewer samples
/// than data.validation_samples, or, where that is 0, than data.samples asks for at least.
std::vector<std::unique_ptr<FrameStore>> make_validation_stores(const TrainConfig& config);

/// A checksum over the manifests of all data sets: it changes when the data does.
std::string manifests_checksum(const DataConfig& config);

}  // namespace ld
