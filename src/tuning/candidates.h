// The space that ld_tune searches: networks, their sizes, their kernels.
#pragma once

#include <string>
#include <vector>

#include "training/run/config.h"
#include "tuning/survey.h"

namespace ld {

struct Candidate {
  std::string name;     // "layer2_fast_k9": network, size, taps a side
  std::string network;  // "layer2"; candidates of one network differ in size and kernel alone
  std::string size;     // "fast"
  TrainConfig config;   // `init`: released weights to begin with; `run.minutes` and the like are a trial's
};

/// What one network sees and makes, in words: "two layers of samples".
std::string network_words(const std::string& network);

/// Every candidate for such data, in the order in which they deserve to be tried where there is no time for
/// all: each network at the middle size first, then the other sizes, then other kernels. `base` has all that
/// candidates share: loss, optimiser, crops; and of networks the initialisation and the like. They read
/// survey.used(), demodulate where there is an albedo, and begin with the released weights of their network
/// where there are some.
std::vector<Candidate> candidate_space(const TrainConfig& base, const DataSurvey& survey);

/// The same candidate with other features.
Candidate with_features(Candidate candidate, const std::vector<std::string>& features);

/// Features that tell of one thing and are dropped together to see whether they pay: a name in words, and
/// those of them that are in use. Radiance, normal, depth and albedo are not among them.
struct FeatureGroup {
  std::string words;
  std::vector<std::string> features;
};
std::vector<FeatureGroup> feature_groups(const std::vector<std::string>& used);

}  // namespace ld
