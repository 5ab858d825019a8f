#include "benchmark/loader.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <time.h>
#include <torch/torch.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "benchmark/measure.h"
#include "benchmark/peak_memory.h"
#include "core/error.h"
#include "core/file_io.h"
#include "core/log.h"
#include "core/process/process_memory.h"
#include "core/text_table.h"
#include "losses/loss.h"
#include "models/initialise.h"
#include "training/run/config_file.h"
#include "training/trainer.h"
#include "training/training_data.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (fs::temp_directory_path() / "ld_bench_XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr)
      fail("cannot make a folder in {}", fs::temp_directory_path().string());
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;  // what is left behind in /tmp harms nothing
    fs::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

double wall_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Of all threads of this process.
double cpu_seconds() {
  timespec now = {};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

TrainConfig config_of(const LoaderBench& options, const std::string& file, const fs::path& cache) {
  TrainConfig config = read_train_config(file);
  config.data.path = options.data;
  config.data.cache = cache.string();
  config.data.batch = options.batch;
  config.data.workers = options.workers;
  config.data.samples = options.samples;
  return config;
}

/// Epochs of batches that nobody trains on.
nlohmann::ordered_json load_epochs(const TrainConfig& config, int64_t epochs) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  TrainingSet set = make_training_set(config);
  int64_t step = 0;
  for (int64_t epoch = 0; epoch < epochs; ++epoch) {
    const double mb_before = double(resident_bytes()) / 1e6, wall = wall_seconds(), cpu = cpu_seconds();
    const double rise = peak_memory_mb([&] {
      for (int64_t i = 0; i < set.batches_per_epoch(); ++i) set.batch(step++);
    });
    const auto steps = static_cast<double>(set.batches_per_epoch());
    rows.push_back({{"batch_ms", 1e3 * (wall_seconds() - wall) / steps},
                    {"batch_cpu_ms", 1e3 * (cpu_seconds() - cpu) / steps},
                    {"mb_before", mb_before},
                    {"mb_after", double(resident_bytes()) / 1e6},
                    {"peak_mb", mb_before + rise}});
  }
  return rows;
}

/// Forgets the cached pages of all files below the folder, so that what is read afterwards can be seen.
void drop_pages(const fs::path& folder) {
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    const int descriptor = open(entry.path().c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor < 0) fail("cannot open {}", entry.path().string());
    const int error = posix_fadvise(descriptor, 0, 0, POSIX_FADV_DONTNEED);
    close(descriptor);
    if (error != 0) fail("cannot drop the pages of {}", entry.path().string());
  }
}

/// Bytes of the memory that lie in pages which are resident, wherever they came from.
double resident_bytes(const void* data, size_t bytes) {
  const auto page = static_cast<uintptr_t>(sysconf(_SC_PAGESIZE));
  const size_t offset = reinterpret_cast<uintptr_t>(data) % page;  // of the data in its first page
  const char* begin = static_cast<const char*>(data) - offset;
  const size_t pages = (offset + bytes + page - 1) / page;
  std::vector<unsigned char> resident(pages);
  if (mincore(const_cast<char*>(begin), pages * page, resident.data()) != 0)
    fail("mincore() does not say which pages are resident");
  size_t count = 0;
  for (const unsigned char one : resident) count += one & 1;
  return static_cast<double>(count * page);
}

/// What one crop of each frame reads of its file's samples, from cold files; means.
nlohmann::ordered_json touch_pages(const TrainConfig& config) {
  FrameStore store(config.data.path, "train", config.network.features, {config.data.cache, 0});
  AugmentationOptions augmentation;
  augmentation.crop = static_cast<int>(config.data.crop);
  double wanted = 0, touched = 0, whole = 0;
  for (size_t i = 0; i < store.size(); ++i) {
    drop_pages(config.data.cache);
    const std::shared_ptr<const PackedFrame> frame = store.get(i);
    RandomStream stream(config.seed, RandomPurpose::test, static_cast<uint32_t>(i));
    const Augmentation crop = random_augmentation(stream, {frame.get()}, augmentation);
    const SampleRange range = sample_range(config.data);
    const SampleList samples =
        range.all() ? SampleList() : draw_samples(stream, frame->spp, draw_sample_count(stream, range));
    const FrameCrop drawn = {store.get_intact(i, frame, crop.tiles(), samples), crop, samples};
    make_batch({drawn}, config.network.features);
    const size_t bytes = 2 * frame->tiles() * frame->tile_samples();
    wanted += 2.0 * crop.width * crop.height * static_cast<double>(drawn.sample_count()) * frame->channels();
    touched += resident_bytes(frame->samples, bytes);
    whole += static_cast<double>(bytes);
  }
  const auto count = static_cast<double>(store.size());
  return {{"wanted_mb", wanted / count / 1e6},
          {"touched_mb", touched / count / 1e6},
          {"frame_mb", whole / count / 1e6}};
}

/// One training step of a network on a batch of the data: forward, loss, backward.
double step_ms(const LoaderBench& options, const fs::path& cache) {
  TrainConfig config = config_of(options, options.network, cache);
  config.data.crop = options.crop;
  const Batch batch = make_training_set(config).batch(0);
  const std::shared_ptr<Network> network = make_network(config.network);
  initialise(*network, config.seed);
  const Loss loss = make_loss(config.loss);
  return median_ms([&] { loss(network->forward(batch.input), batch.reference).backward(); }, 2);
}

/// Seconds of each epoch of a training, from the log that the trainer writes.
nlohmann::ordered_json train_epochs(TrainConfig config, int64_t epochs, const fs::path& run) {
  const int64_t steps = make_training_set(config).batches_per_epoch();
  config.run = {epochs * steps, steps, epochs * steps, epochs * steps};
  Trainer(config, run).train();
  std::istringstream lines(read_file(run / "timing.csv"));
  std::string line;
  std::getline(lines, line);  // step,seconds_per_step
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  // The last epoch's row includes a validation.
  for (int64_t epoch = 0; epoch + 1 < epochs && std::getline(lines, line); ++epoch) {
    std::istringstream cells(line);
    for (int cell = 0; cell < 2; ++cell) std::getline(cells, line, ',');
    rows.push_back({{"seconds", std::stod(line) * static_cast<double>(steps)}});
  }
  return rows;
}

}  // namespace

nlohmann::ordered_json bench_loader(const LoaderBench& options) {
  const TemporaryFolder folder;
  TrainConfig config = config_of(options, options.training, folder.path() / "cache");
  const nlohmann::ordered_json training = train_epochs(config, options.epochs + 1, folder.path() / "run");
  fs::remove_all(folder.path() / "cache");
  config.data.crop = options.crop;
  nlohmann::ordered_json result = {{"data", options.data},
                                   {"crop", options.crop},
                                   {"batch", options.batch},
                                   {"workers", options.workers},
                                   {"loading", load_epochs(config, options.epochs)},
                                   {"training", training},
                                   {"crop_pages", touch_pages(config)}};
  result["step_ms"] = step_ms(options, folder.path() / "cache");
  return result;
}

std::string markdown_loader(const nlohmann::ordered_json& result) {
  std::vector<TableRow> rows = {{"epoch", "ms a batch", "processor ms a batch", "MB before", "MB after",
                                 "MB at most", "s with training"}};
  for (size_t i = 0; i < result.at("loading").size(); ++i) {
    const auto& row = result["loading"][i];
    const auto number = [&](const char* key) { return fmt::format("{:.1f}", row.at(key).get<double>()); };
    rows.push_back({fmt::format("{}{}", i + 1, i == 0 ? ", cache made" : ""), number("batch_ms"),
                    number("batch_cpu_ms"), number("mb_before"), number("mb_after"), number("peak_mb"),
                    fmt::format("{:.2f}", result["training"][i].at("seconds").get<double>())});
  }
  const double batch_ms = result["loading"].back().at("batch_ms"), step_ms = result.at("step_ms");
  const auto& pages = result.at("crop_pages");
  return markdown_table(rows, 1) +
         fmt::format(
             "\nA training step on such a batch takes {:.0f} ms, {:.0f} times as long as loading it. A "
             "crop's "
             "samples are {:.2f} MB; {:.2f} of the {:.2f} MB of its frame are read for them.\n",
             step_ms, step_ms / batch_ms, pages.at("wanted_mb").get<double>(),
             pages.at("touched_mb").get<double>(), pages.at("frame_mb").get<double>());
}

}  // namespace ld
