// Training sets over tiny data sets.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "dataset/training_set.h"
#include "tests/support/tiny_dataset.h"

namespace ld {

inline const std::vector<std::string> kFeatures = {"normal", "radiance"};

inline std::unique_ptr<FrameStore> store(const std::filesystem::path& folder,
                                         const CacheOptions& cache = {}) {
  return std::make_unique<FrameStore>(folder, "train", kFeatures, cache);
}

inline TrainingSetOptions options(int crop, int64_t batch, int workers = 0, uint64_t seed = 1) {
  TrainingSetOptions options;
  options.augmentation.crop = crop;
  options.batch = batch;
  options.workers = workers;
  options.seed = seed;
  return options;
}

inline TrainingSet training_set(const std::filesystem::path& folder, const TrainingSetOptions& options,
                                const CacheOptions& cache = {}) {
  std::vector<WeightedStore> sets;
  sets.push_back({store(folder, cache), 1});
  return TrainingSet(std::move(sets), kFeatures, options);
}

}  // namespace ld
