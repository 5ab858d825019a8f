// The files of a checkpoint folder and their checksums, which the trainer writes and checks and ld_inspect
// checks.
#pragma once

#include <array>
#include <filesystem>
#include <string>

namespace ld {

inline constexpr std::array<const char*, 3> kCheckpointFiles = {"weights.safetensors",
                                                                "optimizer.safetensors", "state.json"};

/// Writes checksums.json, atomically: {"files": {name: checksum}} of kCheckpointFiles, all of which must be
/// there.
void write_checkpoint_checksums(const std::filesystem::path& folder);

/// Throws Error when the file is missing, is not listed in checksums.json or differs from what is listed
/// there.
void verify_checkpoint_file(const std::filesystem::path& folder, const std::string& name);

}  // namespace ld
