// What a data set holds, before any network is chosen for it: which features say anything, and whether the
// samples of a pixel differ in them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace ld {

struct SurveyedFeature {
  std::string name;
  std::string reason;  // why it is left out, for people; "": it varies
  double within = 0;   // share of the pixels whose samples differ in it by more than rounding does
  bool held() const { return reason.empty(); }
};

struct DataSurvey {
  int64_t frames = 0;         // of the training split, all of whose headers were read
  int64_t looked_at = 0;      // of these, whose pixels were read
  int width = 0, height = 0;  // of the first frame
  int samples = 0;            // that every frame of the training and validation splits has
  int64_t validation_frames = 0;
  std::vector<SurveyedFeature> features;  // in the order of the schema, radiance first

  /// The features that a network has something to learn from (FeatureVariation::used).
  std::vector<std::string> used() const;
  bool uses(const std::string& feature) const;
};

/// Reads frames of the training split in their order until no further one could change what is used, the
/// first eight at least. `samples`: as many of each frame as networks will see; 0: as many as all have.
/// Throws Error: no data set, no training or no validation split, frames that have fewer samples, damage.
DataSurvey survey_data(const std::filesystem::path& folder, int samples, int threads);

/// A sentence for each thing that was decided by looking.
std::vector<std::string> sentences(const DataSurvey& survey);

}  // namespace ld
