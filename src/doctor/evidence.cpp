#include "doctor/evidence.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "core/checksum.h"
#include "core/error.h"
#include "frame/exr_reader.h"
#include "frame/picture_place.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

/// Which features the NaNs and infinities stand in. A sample that was never drawn has NaN in R, G and B.
std::map<std::string, int64_t> count_not_finite(const fs::path& path, const Frame& frame) {
  std::map<std::string, int64_t> counts;
  const ExrReader exr(path);
  std::vector<float> values(frame.plane_size() * 3);
  for (int part = 0; part < exr.parts(); ++part) {
    if (sample_number(exr.part_name(part)) < 0) continue;
    for (const std::string& feature_name : frame.features) {
      const Feature& feature = find_feature(feature_name);
      std::vector<ExrPlane> planes;
      bool there = true;
      for (size_t c = 0; c < static_cast<size_t>(feature.channels); ++c) {
        there = there && exr.has_channel(part, feature.exr_channels[c]);
        planes.push_back(
            {feature.exr_channels[c], values.data() + c * frame.plane_size(), frame.plane_size()});
      }
      if (!there) continue;
      exr.read(part, planes);
      for (size_t p = 0; p < frame.plane_size(); ++p) {
        bool finite = true;
        for (size_t c = 0; c < planes.size(); ++c) finite = finite && std::isfinite(planes[c].pixels[p]);
        if (!finite) ++counts[feature_name];
      }
    }
  }
  return counts;
}

Evidence read_files(const fs::path& frame_file, const fs::path& reference_file, bool reference_needed) {
  Evidence evidence;
  evidence.path = frame_file;
  evidence.frame = read_frame(frame_file, {}, evidence.faults);
  if (evidence.faults.not_finite + evidence.faults.guides > 0)
    evidence.not_finite = count_not_finite(frame_file, evidence.frame);
  if (reference_needed || fs::exists(reference_file)) {
    Reference reference = read_reference(reference_file, read_place(frame_file), frame_file.string());
    evidence.reference = std::move(reference.image);
    evidence.bad_reference_values = reference.bad_values;
    evidence.reference_checksum = file_checksum(reference_file);
  }
  complete(evidence);
  return evidence;
}

}  // namespace

std::optional<double> field_of_view(const std::string& camera) {
  const std::string key = "vertical fov ";
  const size_t at = camera.find(key);
  if (at == std::string::npos) return std::nullopt;
  const double angle = std::strtod(camera.c_str() + at + key.size(), nullptr);
  if (!(angle > 0 && angle < 3.14)) return std::nullopt;
  return angle;
}

void complete(Evidence& evidence) {
  const Frame& frame = evidence.frame;
  const size_t pixels = frame.plane_size();
  if (const auto angle = field_of_view(frame.info.camera))
    evidence.focal_pixels = 0.5 * frame.height / std::tan(0.5 * *angle);
  evidence.brightness.assign(pixels * static_cast<size_t>(frame.spp), 0.0F);
  evidence.mean_brightness.assign(pixels, 0.0F);
  for (size_t p = 0; p < pixels; ++p) {
    double sum = 0;
    int count = 0;
    for (int s = 0; s < frame.spp; ++s) {
      if (frame.valid_plane(s)[p] == 0) continue;
      const float value = (frame.plane(s, 0)[p] + frame.plane(s, 1)[p] + frame.plane(s, 2)[p]) / 3;
      evidence.brightness[static_cast<size_t>(s) * pixels + p] = value;
      sum += static_cast<double>(value);
      ++count;
    }
    if (count > 0) evidence.mean_brightness[p] = static_cast<float>(sum / count);
  }
  if (evidence.reference) {
    const Image& image = *evidence.reference;
    evidence.reference_brightness.resize(pixels);
    for (size_t p = 0; p < pixels; ++p)
      evidence.reference_brightness[p] = (image.plane(0)[p] + image.plane(1)[p] + image.plane(2)[p]) / 3;
  }
}

Evidence read_evidence(const fs::path& folder, const ManifestFrame& entry) {
  Evidence evidence = read_files(frame_path(folder, entry.name), reference_path(folder, entry.name), true);
  evidence.name = entry.name;
  evidence.split = entry.split;
  return evidence;
}

Evidence read_evidence(const fs::path& frame_file) {
  fs::path reference = frame_file;
  reference.replace_extension(".reference.exr");
  Evidence evidence = read_files(frame_file, reference, false);
  evidence.name = frame_file.stem().string();
  return evidence;
}

}  // namespace ld
