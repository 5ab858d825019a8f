// A data set: a folder of frames, their references and manifest.json (docs/data_format.md).
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace ld {

struct ManifestFrame {
  std::string name;   // "frame_000012": NAME.exr holds the samples, NAME.reference.exr the reference
  std::string split;  // "train", "validation" or "test"
  int64_t index = 0;  // frame of the recipe
  std::string checksum, reference_checksum;  // core/checksum.h; empty: not checked (hand-written manifests)
  // of frames that follow one another: which sequence, where in it
  std::optional<int64_t> sequence = {}, position = {};
  bool has_reference = true;  // false: there is none, or it is not to be read
};

struct Manifest {
  std::string recipe;  // the resolved recipe as YAML text; empty for frames from elsewhere
  uint64_t seed = 0;
  std::vector<ManifestFrame> frames;  // ordered by name
};

std::filesystem::path frame_path(const std::filesystem::path& folder, const std::string& name);
std::filesystem::path reference_path(const std::filesystem::path& folder, const std::string& name);

/// Throws Error for a name that is none inside the data set's folder, and for an unknown split; `where`
/// begins the complaint.
void check_entry(const ManifestFrame& frame, const std::string& where);

/// Throws Error: missing, not JSON, wrong version, missing or ill-typed entry, duplicate or escaping ("..")
/// names.
Manifest read_manifest(const std::filesystem::path& folder);

/// Adds frames to the folder's manifest, or makes it; frames of the same name are replaced. Safe against
/// other processes that add frames of the same data set at the same time. Throws Error when the folder holds
/// another recipe.
void add_to_manifest(const std::filesystem::path& folder, const Manifest& addition);

/// The frames of one split. Throws Error naming the folder and the splits it has when there are none.
std::vector<ManifestFrame> frames_of_split(const std::filesystem::path& folder, const std::string& split);

/// Throws Error when a file of the frame is missing or differs from its checksum (when it has one).
void verify_frame(const std::filesystem::path& folder, const ManifestFrame& frame);

}  // namespace ld
