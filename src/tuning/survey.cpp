#include "tuning/survey.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <map>

#include "core/error.h"
#include "core/progress.h"
#include "core/signals.h"
#include "dataset/varying_features.h"
#include "frame/frame_file.h"
#include "frame/manifest.h"

namespace ld {
namespace {

/// So many frames are looked at, whatever the first of them say.
constexpr int64_t kFewestLookedAt = 8;

/// Counts pixels whose samples differ in a feature.
struct WithinPixels {
  int64_t pixels = 0, differ = 0;

  void add(const Frame& frame, const Feature& feature) {
    for (size_t p = 0; p < frame.plane_size(); ++p) {
      int valid = 0;
      FeatureRange range;
      for (int s = 0; s < frame.spp; ++s) {
        if (frame.valid_plane(s)[p] == 0) continue;
        ++valid;
        for (int c = 0; c < feature.channels; ++c) {
          const float value = frame.plane(s, feature.offset + c)[p];
          range.low[c] = std::min(range.low[c], value);
          range.high[c] = std::max(range.high[c], value);
        }
      }
      if (valid < 2) continue;
      ++pixels;
      for (int c = 0; c < feature.channels; ++c)
        if (wider_than_rounding(feature.name, range.low[c], range.high[c])) {
          ++differ;
          break;
        }
    }
  }
  double share() const { return pixels == 0 ? 0.0 : double(differ) / double(pixels); }
};

int fewest_samples(const std::filesystem::path& folder, const std::vector<ManifestFrame>& frames, int wanted,
                   const std::function<void(const FrameHeader&)>& see) {
  int fewest = std::numeric_limits<int>::max();
  for (const ManifestFrame& frame : frames) {
    const std::filesystem::path path = frame_path(folder, frame.name);
    const FrameHeader header = read_frame_header(path);
    if (header.spp < std::max(wanted, 1))
      fail(
          "{} has {} samples a pixel, expected at least {}; give a smaller --samples, or leave the frame out",
          path.string(), header.spp, std::max(wanted, 1));
    fewest = std::min(fewest, header.spp);
    see(header);
  }
  return fewest;
}

}  // namespace

std::vector<std::string> DataSurvey::used() const {
  std::vector<std::string> names;
  for (const SurveyedFeature& feature : features)
    if (feature.held()) names.push_back(feature.name);
  return names;
}

bool DataSurvey::uses(const std::string& feature) const {
  return std::any_of(features.begin(), features.end(),
                     [&](const SurveyedFeature& f) { return f.name == feature && f.held(); });
}

DataSurvey survey_data(const std::filesystem::path& folder, int samples, int threads) {
  const std::vector<ManifestFrame> training = frames_of_split(folder, "train"),
                                   validation = frames_of_split(folder, "validation");
  DataSurvey survey;
  survey.frames = int64_t(training.size());
  survey.validation_frames = int64_t(validation.size());
  std::map<std::string, int64_t> holders;  // frames that hold a feature
  const int in_training = fewest_samples(folder, training, samples, [&](const FrameHeader& header) {
    for (const std::string& feature : header.features) ++holders[feature];
  });
  const int in_validation = fewest_samples(folder, validation, samples, [](const FrameHeader&) {});
  survey.samples = samples > 0 ? samples : std::min(in_training, in_validation);
  std::vector<std::string> held;
  for (const std::string& feature : auto_feature_names())
    if (holders[feature] == survey.frames) held.push_back(feature);

  FeatureVariation variation;
  std::map<std::string, WithinPixels> within;
  Progress progress("frames to survey", survey.frames);
  for (const ManifestFrame& entry : training) {
    if (stop_requested()) return survey;
    if (variation.settled() && survey.looked_at >= kFewestLookedAt) break;
    Faults faults;
    Frame frame = read_frame(frame_path(folder, entry.name), held, faults, survey.samples, threads);
    frame.features = held;
    if (survey.looked_at == 0) {
      survey.width = frame.width;
      survey.height = frame.height;
    }
    variation.add(frame);
    if (survey.looked_at < kFewestLookedAt)
      for (const std::string& feature : held) within[feature].add(frame, find_feature(feature));
    ++survey.looked_at;
    progress.advance();
  }
  for (const FeatureRange& range : variation.ranges()) {
    const int64_t holding = holders[range.name];
    std::string reason = variation.reason(range.name);
    if (holding > 0 && holding < survey.frames)
      reason = fmt::format("only {} of {} frames hold it", holding, survey.frames);
    survey.features.push_back({range.name, reason, within[range.name].share()});
  }
  return survey;
}

std::vector<std::string> sentences(const DataSurvey& survey) {
  std::vector<std::string> texts;
  for (const SurveyedFeature& feature : survey.features)
    if (!feature.held()) texts.push_back(fmt::format("{}: dropped, {}.", feature.name, feature.reason));
  const std::vector<std::string> used = survey.used();
  texts.push_back(
      fmt::format("{} frames of {}: kept are {}.", survey.looked_at, survey.frames, fmt::join(used, ", ")));
  double most = 0;
  std::string where;
  for (const SurveyedFeature& feature : survey.features)
    if (feature.held() && feature.name != "radiance" && feature.within > most) {
      most = feature.within;
      where = feature.name;
    }
  if (survey.samples == 1)
    texts.emplace_back(
        "One sample a pixel: its mean is all there is, so networks on samples, on layers of them and on "
        "their "
        "variance are dropped.");
  else if (where.empty())
    texts.emplace_back("The samples of a pixel differ in radiance alone.");
  else
    texts.push_back(fmt::format(
        "The samples of a pixel differ in {} in {:.1f} % of the pixels, more often than in any other guide.",
        where, 100 * most));
  return texts;
}

}  // namespace ld
