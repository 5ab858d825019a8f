#include "training/run_log.h"

#include "core/error.h"
#include "core/log.h"
#include "metrics/metric.h"

namespace ld {
namespace {

std::vector<std::string> metric_columns(int64_t layers, bool sequences) {
  std::vector<std::string> columns = {"epoch", "learning_rate", "train_loss", "skipped", "validation_loss"};
  for (const Metric& metric : metrics()) columns.push_back(metric.name);
  columns.insert(columns.end(), {"rollbacks", "kernel_entropy", "kernel_centre_share"});
  for (int64_t layer = 1; layer <= layers; ++layer)
    columns.push_back(fmt::format("kernel_layer_share_{}", layer));
  if (sequences)
    for (const Metric& measure : sequence_measures()) columns.push_back(measure.name);
  return columns;
}

/// TensorBoard groups by what stands before the slash.
std::string tag_of(const std::string& column) {
  if (column == "epoch" || column == "learning_rate" || column == "skipped" || column == "rollbacks")
    return "training/" + column;
  const std::string kernels = "kernel_";
  if (column.rfind(kernels, 0) == 0) return "kernels/" + column.substr(kernels.size());
  if (column == "train_loss") return "training/loss";
  return "validation/" + (column == "validation_loss" ? "loss" : column);
}

}  // namespace

RunLog::RunLog(const std::filesystem::path& run, int64_t step, int64_t layers, bool sequences)
    : metrics_(run / "metrics.csv", metric_columns(layers, sequences), step),
      timing_(run / "timing.csv", {"seconds_per_step"}, step),
      board_(run / "tensorboard", step) {}

/// The pictures and curves are worth less than the run: when they cannot be written it goes on without.
template <class Write>
void RunLog::show(const Write& write) {
  try {
    write();
    board_reported_ = false;
  } catch (const Error& error) {
    if (!board_reported_) spdlog::warn("{}; TensorBoard will lack these values", error.what());
    board_reported_ = true;
  }
}

void RunLog::row(int64_t step, const std::map<std::string, double>& values, double seconds_per_step) {
  metrics_.write(step, values);
  timing_.write(step, {{"seconds_per_step", seconds_per_step}});
  show([&] {
    for (const auto& [column, value] : values) board_.scalar(step, tag_of(column), value);
    board_.scalar(step, "training/seconds_per_step", seconds_per_step);
  });
}

void RunLog::pictures(int64_t step, const std::vector<ValidationPicture>& pictures) {
  show([&] {
    for (const ValidationPicture& picture : pictures) {
      board_.image(step, picture.name + "/denoised", picture.denoised);
      if (inputs_shown_) continue;  // they stay as they are
      board_.image(step, picture.name + "/noisy", picture.noisy);
      board_.image(step, picture.name + "/reference", picture.reference);
    }
    inputs_shown_ = true;
  });
}

void RunLog::strip(int64_t step, const SequenceStrip& strip) {
  show([&] { board_.image(step, strip.name + "/sequence", strip.image); });
}

void RunLog::flush() {
  metrics_.flush();
  timing_.flush();
}

}  // namespace ld
