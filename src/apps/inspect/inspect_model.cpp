#include <cmath>
#include <cstring>
#include <set>

#include "apps/inspect/inspect.h"
#include "core/error.h"
#include "core/file_io.h"
#include "core/json_text.h"
#include "weights/checkpoint_files.h"
#include "weights/weight_file.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

/// NaNs and infinities; files from elsewhere need not be aligned, hence the copies.
template <class Number, class IsFinite>
int64_t count_not_finite(const TensorView& tensor, IsFinite is_finite) {
  int64_t count = 0;
  for (size_t at = 0; at + sizeof(Number) <= tensor.bytes; at += sizeof(Number)) {
    Number value;
    std::memcpy(&value, static_cast<const char*>(tensor.data) + at, sizeof value);
    count += is_finite(value) ? 0 : 1;
  }
  return count;
}

int64_t not_finite(const TensorView& tensor) {
  switch (tensor.type) {
    case DType::f16:  // all bits of the exponent set
      return count_not_finite<uint16_t>(tensor, [](uint16_t bits) { return (bits & 0x7c00) != 0x7c00; });
    case DType::f32:
      return count_not_finite<float>(tensor, [](float value) { return std::isfinite(value); });
    case DType::f64:
      return count_not_finite<double>(tensor, [](double value) { return std::isfinite(value); });
    case DType::i64:
    case DType::i8:
    case DType::u8:
      return 0;
  }
  return 0;
}

const char* type_name(DType type) {
  switch (type) {
    case DType::f16:
      return "float16";
    case DType::f32:
      return "float32";
    case DType::f64:
      return "float64";
    case DType::i64:
      return "int64";
    case DType::i8:
      return "int8";
    case DType::u8:
      return "uint8";
  }
  return "";
}

void add_tensors(Report& report, nlohmann::ordered_json& facts, const SafetensorsFile& file) {
  int64_t count = 0;
  std::set<std::string> types;
  for (const TensorView& tensor : file.tensors()) {
    count += tensor.numbers();
    types.insert(type_name(tensor.type));
    if (const int64_t bad = not_finite(tensor); bad > 0)
      report.problems.push_back(fmt::format("{}: tensor \"{}\": {} of {} numbers are NaN or infinite",
                                            file.path().string(), tensor.name, bad, tensor.numbers()));
  }
  facts["tensors"] = file.tensors().size();
  facts["parameters"] = count;
  facts["types"] = types;
}

void add_weights(Report& report, nlohmann::ordered_json& facts, const SafetensorsFile& file) {
  const WeightsHeader header = read_weights_header(file);
  const NetworkConfig& network = header.network;
  facts["network"] = network.name;
  facts["layers"] = network.layers;
  facts["kernel_size"] = network.kernel_size;
  facts["compositing"] = network.compositing;
  facts["sample_reducer"] = network.sample_reducer;
  facts["unet_encoder"] = network.unet.encoder;
  facts["context"] = network.unet.context;
  facts["features"] = network.features;
  add_tensors(report, facts, file);
  if (file.tensors().empty()) report.problems.push_back(file.path().string() + ": holds no tensors");
  if (!header.provenance.empty())
    facts["provenance"] =
        nlohmann::ordered_json::parse(header.provenance);  // read_weights_header() has parsed it
}

/// The checkpoint that a link of a run names, in the facts under `name`.
void add_linked_checkpoint(Report& report, const fs::path& link, const std::string& name) {
  if (!fs::exists(link)) {
    if (fs::is_symlink(link))
      report.problems.push_back(fmt::format("{}: points at {}, which is not there", link.string(),
                                            fs::read_symlink(link).string()));
    return;
  }
  Report checkpoint;
  checkpoint.path = link.string();
  inspect_checkpoint(checkpoint);
  nlohmann::ordered_json facts = {{"folder", fs::canonical(link).filename().string()}};
  if (checkpoint.facts.contains("state")) facts["state"] = checkpoint.facts["state"];
  report.facts[name] = facts;
  report.problems.insert(report.problems.end(), checkpoint.problems.begin(), checkpoint.problems.end());
}

}  // namespace

void inspect_tensors(Report& report) {
  report.kind = "safetensors file";
  report.attempt([&] {
    const SafetensorsFile file(report.path);
    report.facts["bytes"] = fs::file_size(report.path);
    const auto format = file.metadata().find("format");
    if (format != file.metadata().end() && format->second == "ld-weights") {
      report.kind = "weights";
      add_weights(report, report.facts, file);
      return;
    }
    add_tensors(report, report.facts, file);
    report.facts["metadata"] = file.metadata();
    report.warnings.emplace_back(
        "not the weights of a network of this project: its metadata does not say so");
  });
}

void inspect_checkpoint(Report& report) {
  report.kind = "checkpoint";
  const fs::path folder = report.path;
  report.attempt([&] {
    for (const char* name : kCheckpointFiles) verify_checkpoint_file(folder, name);
  });
  report.attempt([&] {
    const fs::path path = folder / "state.json";
    const std::string text = read_file(path, 1 << 20);
    if (!parse_json(text, path.string()).is_object()) fail("{}: expected a JSON object", path.string());
    report.facts["state"] = nlohmann::ordered_json::parse(text);
    report.facts["state"].erase("watch");  // losses that only the trainer has a use for
  });
  report.attempt([&] {
    const SafetensorsFile file(folder / "weights.safetensors");
    nlohmann::ordered_json facts;
    add_weights(report, facts, file);
    report.facts["weights"] = facts;
  });
  report.attempt([&] {
    const SafetensorsFile file(folder / "optimizer.safetensors");
    nlohmann::ordered_json facts;
    add_tensors(report, facts, file);
    report.facts["optimizer"] = facts;
  });
}

void inspect_run(Report& report) {
  report.kind = "run";
  const fs::path folder = report.path;
  Report config;
  config.path = (folder / "config.yaml").string();
  inspect_config(config);
  report.facts["config"] = config.facts;
  report.problems = config.problems;

  const fs::path checkpoints = folder / "checkpoints";
  add_linked_checkpoint(report, checkpoints / "last", "last");
  add_linked_checkpoint(report, checkpoints / "best", "best");
  if (!report.facts.contains("last") && !report.facts.contains("best"))
    report.warnings.push_back(
        fmt::format("{} has no checkpoint yet; ld_train writes one at every `run.checkpoint_every` steps",
                    folder.string()));

  report.attempt([&] {
    const fs::path metrics = folder / "metrics.csv";
    if (!fs::exists(metrics)) return;
    std::string text = read_file(metrics);
    text.erase(text.find_last_not_of('\n') + 1);
    report.facts["metrics_columns"] = text.substr(0, text.find('\n'));
    report.facts["last_metrics"] = text.substr(text.rfind('\n') + 1);
  });
}

}  // namespace ld
