#include "training/checkpoint.h"

#include <cmath>

#include "core/error.h"
#include "core/file_io.h"
#include "core/json_text.h"
#include "training/adam_state.h"
#include "weights/checkpoint_files.h"
#include "weights/model_file.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

std::string state_json(const TrainingState& state) {
  nlohmann::ordered_json json;
  json["step"] = state.step;
  json["optimizer_steps"] = state.optimizer_steps;
  json["best_score"] = std::isfinite(state.best_score) ? nlohmann::ordered_json(state.best_score) : nullptr;
  json["best_step"] = state.best_step;
  json["dataset"] = state.dataset;
  return json.dump(2) + "\n";
}

TrainingState parse_state(const fs::path& path) {
  try {
    const auto json = parse_json(read_file(path, 1 << 20), path.string());
    TrainingState state;
    state.step = json.at("step");
    state.optimizer_steps = json.at("optimizer_steps");
    if (!json.at("best_score").is_null()) state.best_score = json.at("best_score");
    state.best_step = json.at("best_step");
    state.dataset = json.at("dataset");
    return state;
  } catch (const nlohmann::json::exception& error) {
    fail("{}: not the state of a training run: {}", path.string(), error.what());
  }
}

/// Points the link at the checkpoint, in one step: a reader sees the old one or the new one.
void set_link(const fs::path& link, const std::string& target) {
  const fs::path temporary = link.string() + ".partial";
  fs::remove(temporary);
  fs::create_symlink(target, temporary);
  fs::rename(temporary, link);
}

std::string link_target(const fs::path& link) {
  return fs::is_symlink(link) ? fs::read_symlink(link).string() : "";
}

}  // namespace

CheckpointFolder::CheckpointFolder(fs::path run) : folder_(std::move(run) / "checkpoints") {}

std::optional<fs::path> CheckpointFolder::last() const {
  const std::string target = link_target(folder_ / "last");
  if (target.empty()) return std::nullopt;
  return folder_ / target;
}

void CheckpointFolder::write(const TrainingState& state, const Network& network,
                             torch::optim::Adam& optimizer, bool best) {
  make_folder(folder_);
  const std::string name = fmt::format("step_{:08}", state.step);
  const fs::path partial = folder_ / ("." + name + ".partial");
  fs::remove_all(partial);
  make_folder(partial);

  nlohmann::ordered_json provenance = {
      {"steps", state.step}, {"dataset", state.dataset}, {"program", "ld_train " LD_VERSION}};
  save_model(partial / kCheckpointFiles[0], network, provenance.dump(), DType::f32);
  write_tensors(partial / kCheckpointFiles[1], adam_state(optimizer, network), {{"format", "ld-optimizer"}});
  write_file_atomically(partial / kCheckpointFiles[2], state_json(state));
  write_checkpoint_checksums(partial);

  flush_to_disk(partial);
  fs::remove_all(folder_ / name);  // of a run that was killed between renaming and linking
  fs::rename(partial, folder_ / name);
  set_link(folder_ / "last", name);
  if (best) set_link(folder_ / "best", name);
  flush_to_disk(folder_);

  const std::string best_name = link_target(folder_ / "best");
  std::vector<fs::path> surplus;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_)) {
    const std::string found = entry.path().filename().string();
    if (found.rfind("step_", 0) == 0 && found != name && found != best_name) surplus.push_back(entry.path());
  }
  for (const fs::path& path : surplus) fs::remove_all(path);
}

TrainingState read_checkpoint(const fs::path& checkpoint, Network& network, torch::optim::Adam& optimizer) {
  for (const char* name : kCheckpointFiles) verify_checkpoint_file(checkpoint, name);
  const TrainingState state = parse_state(checkpoint / kCheckpointFiles[2]);
  const std::shared_ptr<Network> stored = load_model(checkpoint / kCheckpointFiles[0]);
  const torch::NoGradGuard no_grad;
  const auto source = stored->named_parameters();
  for (auto& parameter : network.named_parameters()) {
    const torch::Tensor* value = source.find(parameter.key());
    if (value == nullptr || value->sizes() != parameter.value().sizes())
      fail("{}: its network is not the one of this run; use another --out", checkpoint.string());
    parameter.value().copy_(*value);
  }
  if (state.optimizer_steps > 0)
    set_adam_state(optimizer, network, SafetensorsFile(checkpoint / kCheckpointFiles[1]),
                   state.optimizer_steps);
  return state;
}

}  // namespace ld
