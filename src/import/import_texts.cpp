#include "import/import_texts.h"

#include <ImfChannelList.h>
#include <ImfStringAttribute.h>
#include <fmt/ranges.h>

#include <set>

namespace ld {

std::vector<std::string> feature_list(const SourceSample& sample) {
  std::vector<std::string> names;
  for (const SourceFeature& feature : sample.features) names.push_back(feature.mapping->feature);
  return names;
}

std::vector<std::string> unused_channels(const ExrReader& exr, const FileViews& views,
                                         const std::vector<SourceSample>& samples,
                                         const std::vector<SourcePart>& parts) {
  std::set<std::pair<int, std::string>> used;
  for (const SourcePart& part : parts)
    for (const SourceChannel& channel : part.channels) used.insert({channel.part, channel.name});
  for (const SourceSample& sample : samples) {
    for (const SourceFeature& feature : sample.features)
      for (const SourceChannel& channel : feature.channels) used.insert({channel.part, channel.name});
    for (const SourceChannel& channel : sample.alpha.channels) used.insert({channel.part, channel.name});
  }
  std::vector<std::string> unused;
  for (int part = 0; part < exr.parts(); ++part) {
    const Imf::ChannelList& channels = exr.header(part).channels();
    for (auto it = channels.begin(); it != channels.end(); ++it)
      if (used.count({part, it.name()}) == 0 && views.name_of(part, it.name()))
        unused.push_back(exr.parts() > 1 ? fmt::format("{} of part '{}'", it.name(), exr.part_name(part))
                                         : it.name());
  }
  return unused;
}

std::string taken_text(const SourceFeature& source) {
  std::vector<std::string> names;
  for (const SourceChannel& channel : source.channels) names.push_back(channel.name);
  std::string text = fmt::format("{}: {}", source.mapping->feature, fmt::join(names, ", "));
  if (source.mapping->feature == "normal") text += fmt::format(" ({} space)", source.mapping->space);
  if (source.mapping->feature == "depth") text += fmt::format(" ({})", source.mapping->kind);
  return text;
}

std::vector<std::string> names_of(const std::vector<SourcePart>& parts) {
  std::vector<std::string> names;
  for (const SourcePart& part : parts) names.push_back(part.name);
  return names;
}

std::string taken_text(const SourcePart& part) {
  std::string text = part.name + ": ";
  size_t channel = 0;
  for (size_t term = 0; term < part.factors.size(); ++term)
    for (size_t f = 0; f < part.factors[term]; ++f, channel += 3) {
      const std::string& name = part.channels[channel].name;
      text += (f > 0 ? " * " : term > 0 ? " + " : "") + name.substr(0, name.size() - 2);
    }
  return text;
}

std::string generator_of(const ExrReader& exr, const ImportMapping& mapping) {
  for (const char* name : {"generatedBy", "Software", "software"})
    if (const auto* text = exr.header(0).findTypedAttribute<Imf::StringAttribute>(name)) return text->value();
  return mapping.about;
}

std::string describe(const ViewCamera& camera) {
  const auto triple = [](const Imath::V3d& v) { return fmt::format("{:g} {:g} {:g}", v.x, v.y, v.z); };
  return fmt::format("position {}; right {}; up {}{}", triple(camera.position), triple(camera.right),
                     triple(camera.up),
                     camera.fov_y ? fmt::format("; vertical fov {:g} rad", *camera.fov_y) : "");
}

}  // namespace ld
