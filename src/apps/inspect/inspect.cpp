#include "apps/inspect/inspect.h"

#include "core/error.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

void inspect_folder(Report& report, const InspectOptions& options) {
  const fs::path folder = report.path;
  const auto has = [&](const char* name) { return fs::exists(folder / name); };
  if (has("manifest.json")) {
    inspect_dataset(report, options);
  } else if (has("weights.safetensors") || has("state.json") || has("checksums.json")) {
    inspect_checkpoint(report);
  } else if (has("config.yaml") || has("checkpoints")) {
    inspect_run(report);
  } else {
    report.problems.push_back(
        "not a data set (no manifest.json), not a checkpoint (no weights.safetensors), not a run (no "
        "config.yaml); give "
        "the folder that holds one of them");
  }
}

}  // namespace

Report inspect(const fs::path& path, const InspectOptions& options) {
  if (!fs::exists(path)) fail("no such path: {}; check it for typing errors", path.string());
  Report report;
  report.path = path.string();
  const std::string extension = path.extension().string();
  if (fs::is_directory(path)) {
    inspect_folder(report, options);
  } else if (path.filename() == "manifest.json") {
    report.path = path.has_parent_path() ? path.parent_path().string() : ".";
    inspect_dataset(report, options);
  } else if (extension == ".exr") {
    inspect_exr(report);
  } else if (extension == ".safetensors") {
    inspect_tensors(report);
  } else if (extension == ".onnx") {
    inspect_onnx(report);
  } else if (extension == ".yaml" || extension == ".yml") {
    inspect_config(report);
  } else {
    report.problems.push_back(
        fmt::format("unknown extension '{}'; expected a .exr, .safetensors, .onnx or .yaml file, or a folder",
                    extension));
  }
  return report;
}

}  // namespace ld
