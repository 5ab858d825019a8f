// The frames of a shot that a network adapts to without references: which of them it learns from, and which
// are held out to judge what it learnt.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "frame/manifest.h"

namespace ld {

/// The frames of a folder, none with its reference, each in the split "train" or "validation".
/// - With a manifest: those of its splits "train" and "validation"; of its test split nothing is read.
/// - Without one: every NAME.exr in the order of the names, but for NAME.reference.exr.
/// Where no frame is for validation, the middle one of every `held_out` in a row is, or of all where there
/// are fewer. Throws UsageError for a folder that is missing or has fewer than two frames, Error for a
/// manifest that is damaged.
std::vector<ManifestFrame> frames_of_shot(const std::filesystem::path& folder, int held_out);

/// Of these frames, those of one split.
std::vector<ManifestFrame> of_split(const std::vector<ManifestFrame>& frames, const std::string& split);

/// The text whose checksum changes when frames are added to or taken from the shot, or replaced.
std::string shot_state(const std::filesystem::path& folder);

}  // namespace ld
