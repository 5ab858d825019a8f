#include "import/source_plan.h"

#include <ImfChannelList.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>

#include "core/error.h"
#include "core/shown_text.h"
#include "frame/schema.h"
#include "import/channel_pattern.h"

namespace ld {
namespace {

std::string place(const ExrReader& exr, const SourceChannel& channel) {
  const std::string part = exr.part_name(channel.part);
  return part.empty() ? fmt::format("'{}'", channel.name)
                      : fmt::format("'{}' of part '{}'", channel.name, part);
}

/// Whether a channel of the view is of the pattern. Some writers leave the name of the layer to the part.
std::optional<PatternMatch> match_channel(const ExrReader& exr, const FileViews& views, int part,
                                          const std::string& channel, const std::string& pattern) {
  const std::optional<std::string> name = views.name_of(part, channel);
  if (!name) return std::nullopt;
  const std::optional<PatternMatch> fits = match_pattern(pattern, *name);
  if (fits || exr.parts() == 1) return fits;
  return match_pattern(pattern, views.part_name(part) + "." + *name);
}

/// All channels that one alternative of a pattern fits.
FoundChannels channels_of_pattern(const ExrReader& exr, const FileViews& views,
                                  const std::string& part_pattern, const std::string& pattern,
                                  const std::string& layer) {
  FoundChannels found;
  for (int part = 0; part < exr.parts(); ++part) {
    const std::optional<PatternMatch> in_part =
        match_pattern(with_layer(part_pattern, layer), exr.part_name(part));
    if (!in_part) continue;
    const Imf::ChannelList& channels = exr.header(part).channels();
    for (auto it = channels.begin(); it != channels.end(); ++it) {
      const std::optional<PatternMatch> fits = match_channel(exr, views, part, it.name(), pattern);
      if (!fits) continue;
      const SourceChannel channel{part, it.name()};
      const auto [at, is_new] = found.emplace(std::max(in_part->sample, fits->sample), channel);
      if (!is_new)
        fail(
            "{}: the pattern '{}' fits the channels {} and {}; name one of them: --set layer=NAME, --set "
            "part=NAME "
            "or a mapping of your own",
            exr.path(), pattern, place(exr, at->second), place(exr, channel));
    }
  }
  return found;
}

/// The components of a feature; empty when the file has none of them.
std::vector<FoundChannels> find_feature_channels(const ExrReader& exr, const FileViews& views,
                                                 const ImportMapping& mapping,
                                                 const FeatureMapping& feature) {
  std::vector<FoundChannels> components;
  size_t there = 0;
  for (size_t c = 0; c < feature.channels.size(); ++c) {
    components.push_back(find_channels(
        exr, views, mapping, feature.part.empty() ? mapping.part : feature.part, feature.channels[c]));
    if (!components.back().empty()) ++there;
  }
  if (there == 0) return {};
  for (size_t c = 0; c < components.size(); ++c)
    if (components[c].empty())
      fail("{}: {} needs the channels {}, but nothing fits '{}'; write that channel, {}", exr.path(),
           feature.feature, fmt::join(feature.channels, ", "), feature.channels[c],
           feature.feature == "radiance"
               ? "or say which ones are radiance with another --preset or --mapping"
               : fmt::format("or leave the feature out with --set {}.channels=[]", feature.feature));
  return components;
}

/// The feature's channels of one sample.
SourceFeature of_sample(const ExrReader& exr, const FeatureMapping& feature,
                        const std::vector<FoundChannels>& components, int sample) {
  SourceFeature result;
  result.mapping = &feature;
  for (const FoundChannels& component : components) {
    auto at = component.find(feature.per_sample ? sample : -1);
    if (at == component.end())
      fail("{}: no channel '{}' of {} for sample {}; {}", exr.path(),
           feature.channels[result.channels.size()], feature.feature, sample,
           sample >= 0 && component.count(-1) > 0 ? "say per_sample: false where one serves all samples"
                                                  : "every sample must have the same features");
    exr.require_channel(at->second.part, at->second.name, "");
    result.channels.push_back(at->second);
  }
  return result;
}

std::vector<FoundChannels> radiance_of(const ExrReader& exr, const FileViews& views,
                                       const ImportMapping& mapping) {
  const FeatureMapping& radiance = mapping.features[0];
  std::vector<FoundChannels> found = find_feature_channels(exr, views, mapping, radiance);
  if (found.empty() && !mapping.features[1].channels.empty())
    found = find_feature_channels(exr, views, mapping, mapping.features[1]);
  if (!found.empty()) return found;
  fail("{}: no radiance: nothing fits {}; the file has {}; choose another --preset or --mapping", exr.path(),
       shown(fmt::format("{}", fmt::join(radiance.channels, ", ")), 400), channels_of_parts(exr));
}

}  // namespace

std::string channels_of_parts(const ExrReader& exr) {
  std::string channels;
  for (int part = 0; part < exr.parts() && channels.size() < 400; ++part)
    channels += (channels.empty() ? "" : "; ") + exr.channel_list(part);
  return channels;
}

FoundChannels find_channels(const ExrReader& exr, const FileViews& views, const ImportMapping& mapping,
                            const std::string& part, const std::string& pattern) {
  for (const std::string& alternative : pattern_alternatives(with_layer(pattern, mapping.layer))) {
    FoundChannels found = channels_of_pattern(exr, views, part, alternative, mapping.layer);
    if (!found.empty()) return found;
  }
  return {};
}

std::vector<int> sample_numbers(const ExrReader& exr, const ImportMapping& mapping) {
  std::vector<int> numbers;
  const std::vector<FoundChannels> radiance = radiance_of(exr, FileViews(exr, mapping.view), mapping);
  for (const auto& [number, channel] : radiance[0]) numbers.push_back(number);
  return numbers;
}

bool holds_radiance(const ExrReader& exr, const ImportMapping& mapping) {
  const FileViews views(exr, mapping.view);
  const auto fits = [&](const std::string& pattern) {
    for (int part = 0; part < exr.parts(); ++part)
      for (auto it = exr.header(part).channels().begin(); it != exr.header(part).channels().end(); ++it)
        if (match_channel(exr, views, part, it.name(), pattern)) return true;
    return false;
  };
  const FeatureMapping& radiance = mapping.features[0];
  for (const std::string& channel : radiance.channels) {
    const std::vector<std::string> alternatives = pattern_alternatives(with_layer(channel, mapping.layer));
    if (std::none_of(alternatives.begin(), alternatives.end(), fits)) return false;
  }
  return true;
}

std::vector<SourceSample> plan_samples(const ExrReader& exr, const ImportMapping& mapping, Wanted wanted) {
  const FileViews views(exr, mapping.view);
  std::vector<SourceSample> samples;
  const std::vector<FoundChannels> radiance = radiance_of(exr, views, mapping);
  // FoundChannels first, so that each complaint comes once.
  std::vector<std::pair<const FeatureMapping*, std::vector<FoundChannels>>> found;
  for (size_t i = 0; i < mapping.features.size(); i += 2)
    for (const size_t choice : {i, i + 1}) {
      const FeatureMapping& feature = mapping.features[choice];
      if (wanted == Wanted::per_sample && !feature.per_sample) continue;
      if (wanted == Wanted::picture && feature.feature != "radiance") continue;
      std::vector<FoundChannels> components = find_feature_channels(exr, views, mapping, feature);
      if (components.empty()) continue;
      found.emplace_back(&feature, std::move(components));
      break;
    }
  const std::vector<FoundChannels> alpha = find_feature_channels(exr, views, mapping, mapping.alpha);
  for (const auto& [number, channel] : radiance[0]) {
    SourceSample sample;
    for (const auto& [feature, components] : found)
      sample.features.push_back(of_sample(exr, *feature, components, number));
    if (!alpha.empty()) sample.alpha = of_sample(exr, mapping.alpha, alpha, number);
    samples.push_back(std::move(sample));
  }
  return samples;
}

}  // namespace ld
