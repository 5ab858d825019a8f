// What `ld_bench loader` measures: how fast crops come from a data set, what making its cache costs, whether
// memory stays flat and how much of the files a crop touches.
#pragma once

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace ld {

struct LoaderBench {
  std::string data;                             // folder of the data set
  std::string training = "configs/quick.yaml";  // trained on it for some epochs
  std::string network = "configs/layer.yaml";   // one training step of it is what a batch is compared with
  int64_t crop = 128, batch = 4, workers = 2;   // as in the data: section of a config
  std::vector<int64_t> samples = {};            // data.samples of a config
  int64_t epochs = 4;                           // of each measurement, the first of them with an empty cache
};

/// {"data", "crop", "batch", "workers",
///  "loading": epochs without training, each {"batch_ms", "batch_cpu_ms", "mb_before", "mb_after",
///  "peak_mb"}:
///   time and processor time a batch, resident memory of the process before, after and at most;
///  "training": epochs with training, each {"seconds"};
///  "crop_pages": {"wanted_mb", "touched_mb", "frame_mb"} of samples: in a crop, in the pages that are read
///  for
///   it from a cold cache file, in its frame;
///  "step_ms": of one training step of `network` on such a batch}
/// The cache is made in a temporary folder. Throws Error for bad data, UsageError for a bad config.
nlohmann::ordered_json bench_loader(const LoaderBench& options);

std::string markdown_loader(const nlohmann::ordered_json& result);

}  // namespace ld
