#include "dataset/shot.h"

#include <algorithm>

#include "core/checksum.h"
#include "core/error.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

bool has_manifest(const fs::path& folder) {
  return fs::exists(folder / "manifest.json");
}

std::vector<ManifestFrame> listed_frames(const fs::path& folder) {
  if (!fs::is_directory(folder))
    fail_usage("{}: no such folder; expected one of frames, NAME.exr with sample parts (docs/data_format.md)",
               folder.string());
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const fs::path name = entry.path().filename();
    if (name.extension() == ".exr" && name.stem().extension() != ".reference")
      names.push_back(name.stem().string());
  }
  std::sort(names.begin(), names.end());
  std::vector<ManifestFrame> frames;
  for (const std::string& name : names) {
    ManifestFrame frame;
    frame.name = name;
    frame.index = static_cast<int64_t>(frames.size());
    frames.push_back(std::move(frame));
  }
  return frames;
}

void hold_out(std::vector<ManifestFrame>& frames, size_t every) {
  if (frames.size() < every) every = frames.size();
  for (size_t i = 0; i < frames.size(); ++i)
    frames[i].split = i % every == every / 2 ? "validation" : "train";
}

}  // namespace

std::vector<ManifestFrame> frames_of_shot(const fs::path& folder, int held_out) {
  const auto is_for = [](const char* split) {
    return [split](const ManifestFrame& frame) { return frame.split == split; };
  };
  std::vector<ManifestFrame> frames =
      has_manifest(folder) ? read_manifest(folder).frames : listed_frames(folder);
  frames.erase(std::remove_if(frames.begin(), frames.end(), is_for("test")), frames.end());
  if (frames.size() < 2)
    fail_usage(
        "{}: {} frames to learn from; expected at least two, one of which is held out to judge the others' "
        "lesson",
        folder.string(), frames.size());
  for (ManifestFrame& frame : frames) frame.has_reference = false;
  if (std::none_of(frames.begin(), frames.end(), is_for("validation")))
    hold_out(frames, static_cast<size_t>(held_out));
  return frames;
}

std::vector<ManifestFrame> of_split(const std::vector<ManifestFrame>& frames, const std::string& split) {
  std::vector<ManifestFrame> chosen;
  std::copy_if(frames.begin(), frames.end(), std::back_inserter(chosen),
               [&](const ManifestFrame& frame) { return frame.split == split; });
  return chosen;
}

std::string shot_state(const fs::path& folder) {
  if (has_manifest(folder)) return file_checksum(folder / "manifest.json");
  std::string state;
  for (const ManifestFrame& frame : listed_frames(folder))
    state += fmt::format("{} of {} bytes\n", frame.name, fs::file_size(frame_path(folder, frame.name)));
  return checksum_text(state.data(), state.size());
}

}  // namespace ld
