// One frame of a data set, read once, as all checks see it.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "frame/frame_file.h"
#include "frame/manifest.h"

namespace ld {

struct Evidence {
  std::string name, split;
  std::filesystem::path path;
  Frame frame;  // sanitised, as networks get it
  Faults faults;
  std::map<std::string, int64_t> not_finite;  // samples with NaN or infinity by feature; read only when
                                              // faults say that there are some
  std::optional<Image> reference;             // [3, H, W]
  int64_t bad_reference_values = 0;           // NaN, infinite or negative, read as 0
  std::string reference_checksum;             // empty without a reference
  std::optional<double> focal_pixels;         // pixels that one unit at depth 1 covers; from ldCamera

  /// [spp][pixel]: mean of R, G and B; 0 where masked.
  std::vector<float> brightness;
  const float* brightness_of(int sample) const {
    return brightness.data() + static_cast<size_t>(sample) * frame.plane_size();
  }
  /// [pixel]: means over the valid samples and of the reference's three channels (empty without one).
  std::vector<float> mean_brightness, reference_brightness;
};

/// Reads a frame of a data set and its reference. Throws Error when one of them is missing or damaged, has no
/// samples, or when their sizes differ.
Evidence read_evidence(const std::filesystem::path& folder, const ManifestFrame& entry);

/// A frame by itself; with NAME.reference.exr beside it if that is there.
Evidence read_evidence(const std::filesystem::path& frame_file);

/// The same from a frame in memory; for tests and for what reads frames in another way.
void complete(Evidence& evidence);

/// The vertical field of view in radians from the text of ldCamera ("...; vertical fov 0.77 rad; ...").
std::optional<double> field_of_view(const std::string& camera);

}  // namespace ld
