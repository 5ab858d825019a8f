// Which channels of a file hold which feature of which sample.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "frame/exr_reader.h"
#include "import/file_views.h"
#include "import/mapping.h"

namespace ld {

struct SourceChannel {
  int part = 0;
  std::string name;
};

struct SourceFeature {
  const FeatureMapping* mapping = nullptr;
  std::vector<SourceChannel> channels;  // a channel for each component
};

struct SourceSample {
  std::vector<SourceFeature> features;  // in the order of the schema; radiance is there
  SourceFeature alpha;                  // without a mapping where there is none
};

/// What is looked for in a file.
enum class Wanted {
  all,
  per_sample,  // not what serves all samples, which the first file of a frame holds
  picture,     // radiance and alpha
};

/// "B, G, R; Z": the channels of all parts, for complaints; not more of them than fit a few lines.
std::string channels_of_parts(const ExrReader& exr);
/// Sample number (-1: of all samples) to channel.
using FoundChannels = std::map<int, SourceChannel>;

/// The channels of the first alternative of a pattern that fits any, in parts of such a pattern. Throws Error
/// where it fits two of one sample.
FoundChannels find_channels(const ExrReader& exr, const FileViews& views, const ImportMapping& mapping,
                            const std::string& part, const std::string& pattern);

/// The numbers of the samples of plan_samples(), in its order.
std::vector<int> sample_numbers(const ExrReader& exr, const ImportMapping& mapping);

/// Whether the file has a channel for each component of the mapping's radiance.
bool holds_radiance(const ExrReader& exr, const ImportMapping& mapping);

/// The samples of one file, in the order of their numbers; one where the mapping has no {sample}. Features
/// that are not there are left out. Throws Error: no radiance, patterns that fit several channels, a feature
/// of which some components or some samples are missing.
std::vector<SourceSample> plan_samples(const ExrReader& exr, const ImportMapping& mapping, Wanted wanted);

}  // namespace ld
