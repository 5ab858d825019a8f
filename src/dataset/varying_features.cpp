#include "dataset/varying_features.h"

#include <algorithm>
#include <cmath>
#include <mutex>

#include "core/error.h"
#include "core/threads.h"
#include "frame/frame_file.h"
#include "frame/manifest.h"

namespace ld {
namespace {

/// A range below this is rounding: of values near 1 for colours, directions and times, of a pixel for motion
/// and circle of confusion, of the depth itself for depths. Half floats round at 1/2048.
constexpr float kRounding = 1e-3F;

void widen(FeatureRange& range, const Frame& frame, const Feature& feature) {
  for (int c = 0; c < feature.channels; ++c) {
    float& low = range.low[c];
    float& high = range.high[c];
    for (int s = 0; s < frame.spp; ++s) {
      const float* plane = frame.plane(s, feature.offset + c);
      const uint8_t* valid = frame.valid_plane(s);
      for (size_t p = 0; p < frame.plane_size(); ++p) {
        if (valid[p] == 0) continue;
        low = std::min(low, plane[p]);
        high = std::max(high, plane[p]);
      }
    }
    range.varies = range.varies || wider_than_rounding(feature.name, low, high);
  }
}

bool all_zero(const FeatureRange& range) {
  for (int c = 0; c < find_feature(range.name).channels; ++c)
    if (range.low[c] < -kRounding || range.high[c] > kRounding) return false;
  return true;
}

/// The feature without which a random number of the camera leaves no trace in the picture; "" for others.
std::string effect_of(const std::string& feature) {
  if (feature == "lens") return "coc";
  if (feature == "time") return "motion";
  return "";
}

}  // namespace

bool wider_than_rounding(const std::string& feature, float low, float high) {
  const float unit = feature == "depth" ? std::max(std::fabs(low), std::fabs(high)) : 1.0F;
  return high - low > kRounding * unit;
}

FeatureVariation::FeatureVariation() {
  for (const std::string& feature : auto_feature_names()) {
    FeatureRange range;
    range.name = feature;
    ranges_.push_back(range);
  }
}

void FeatureVariation::add(const Frame& frame) {
  ++frames_;
  for (FeatureRange& range : ranges_) {
    if (!frame.holds(range.name)) continue;
    widen(range, frame, find_feature(range.name));
    ++range.frames;
  }
}

std::string FeatureVariation::reason(const std::string& feature) const {
  const auto range_of = [&](const std::string& name) {
    return std::find_if(ranges_.begin(), ranges_.end(),
                        [&](const FeatureRange& range) { return range.name == name; });
  };
  find_feature(feature);
  const FeatureRange& range = *range_of(feature);
  if (range.frames == 0) return "no frame holds it";
  if (range.frames < frames_) return fmt::format("only {} of {} frames hold it", range.frames, frames_);
  if (feature == "radiance") return "";
  if (range.low[0] > range.high[0]) return "no frame has a valid sample";
  if (!range.varies) return fmt::format("it is {:g} everywhere", range.low[0]);
  const std::string effect = effect_of(feature);
  if (!effect.empty() && range_of(effect)->frames == frames_ && all_zero(*range_of(effect)))
    return fmt::format("{} is 0 everywhere", effect);
  return "";
}

std::vector<std::string> FeatureVariation::used() const {
  std::vector<std::string> names;
  for (const FeatureRange& range : ranges_)
    if (range.name == "radiance" || reason(range.name).empty()) names.push_back(range.name);
  return names;
}

bool FeatureVariation::settled() const {
  return frames_ > 0 && std::all_of(ranges_.begin(), ranges_.end(), [&](const FeatureRange& range) {
           return range.frames < frames_ || reason(range.name).empty();
         });
}

std::vector<std::string> varying_features(const std::vector<std::filesystem::path>& folders,
                                          const std::string& split, int threads) {
  std::vector<std::filesystem::path> paths;
  for (const std::filesystem::path& folder : folders)
    for (const ManifestFrame& frame : frames_of_split(folder, split))
      paths.push_back(frame_path(folder, frame.name));

  // Headers say which features all frames hold: cheap, and pixels need not be read for the others.
  FeatureVariation variation;
  std::vector<std::string> held = auto_feature_names();
  for (const std::filesystem::path& path : paths) {
    const std::vector<std::string> here = read_frame_header(path).features;
    held.erase(std::remove_if(held.begin(), held.end(),
                              [&](const std::string& name) {
                                return std::find(here.begin(), here.end(), name) == here.end();
                              }),
               held.end());
  }
  std::mutex mutex;
  parallel_for(static_cast<int64_t>(paths.size()), threads, [&](int64_t i) {
    {
      const std::lock_guard<std::mutex> lock(mutex);
      if (variation.settled()) return;
    }
    Faults faults;
    Frame frame = read_frame(paths[static_cast<size_t>(i)], held, faults);
    frame.features = held;
    const std::lock_guard<std::mutex> lock(mutex);
    variation.add(frame);
  });
  return variation.used();
}

}  // namespace ld
