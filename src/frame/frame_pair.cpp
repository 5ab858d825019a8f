#include "frame/frame_pair.h"

#include "core/error.h"
#include "core/log.h"
#include "frame/frame_file.h"

namespace ld {

FramePair read_frame_pair(const std::filesystem::path& folder, const ManifestFrame& entry,
                          const std::vector<std::string>& features, int samples) {
  const std::filesystem::path path = frame_path(folder, entry.name);
  FramePair pair;
  pair.frame = read_frame(path, features, pair.faults, samples);
  pair.place = read_place(path);
  if (entry.has_reference)
    pair.reference = read_reference(reference_path(folder, entry.name), pair.place, path.string());
  // After the complaints above, which say more than that a checksum differs.
  verify_frame(folder, entry);
  return pair;
}

void warn_about_faults(const std::filesystem::path& path, const Faults& faults) {
  if (faults.not_finite + faults.negative > 0)
    spdlog::warn("{}: {} samples with NaN or infinity masked out, {} negative radiance values set to 0",
                 path.string(), faults.not_finite, faults.negative);
  if (faults.guides > 0)
    spdlog::warn(
        "{}: {} guides of samples that are NaN or infinite count as those of rays that escaped; the light is "
        "kept",
        path.string(), faults.guides);
  if (faults.parts > 0)
    spdlog::warn(
        "{}: {} colours of light parts are NaN or infinite in samples whose radiance is not; they count as "
        "0, "
        "so the parts do not sum to the picture there",
        path.string(), faults.parts);
}

void warn_about_faults(const std::filesystem::path& folder, const ManifestFrame& entry,
                       const FramePair& pair) {
  warn_about_faults(frame_path(folder, entry.name), pair.faults);
  if (pair.reference.other_colours)
    spdlog::warn(
        "{}: its chromaticities are others than its samples'; nothing was converted, so scores against it "
        "are doubtful",
        reference_path(folder, entry.name).string());
  if (pair.reference.bad_values > 0)
    spdlog::warn(
        "{}: {} NaN, infinite or negative values set to 0; losses and scores against it are doubtful",
        reference_path(folder, entry.name).string(), pair.reference.bad_values);
}

}  // namespace ld
