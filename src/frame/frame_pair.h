// A frame of a data set together with its reference, if it has one: what training and evaluation both read.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "frame/frame.h"
#include "frame/manifest.h"
#include "frame/picture_place.h"

namespace ld {

struct FramePair {
  Frame frame;
  Faults faults;  // of the frame
  PicturePlace place;
  Reference reference;  // an image of no pixels where the entry has none
};

/// Of the frame only the first `samples` samples; 0: all. Throws Error: a missing or damaged file, a missing
/// feature, too few samples, a reference that does not show the frame (cut_to), a checksum that does not
/// match.
FramePair read_frame_pair(const std::filesystem::path& folder, const ManifestFrame& entry,
                          const std::vector<std::string>& features, int samples = 0);

/// Logs a warning that names the file and the counts, if there are any.
void warn_about_faults(const std::filesystem::path& path, const Faults& faults);
void warn_about_faults(const std::filesystem::path& folder, const ManifestFrame& entry,
                       const FramePair& pair);

}  // namespace ld
