#include "import/recognise.h"

#include <fmt/ranges.h>

#include <algorithm>

#include "core/error.h"
#include "frame/frame_file.h"
#include "import/source_plan.h"

namespace ld {

bool is_frame(const ExrReader& exr) {
  for (int part = 0; part < exr.parts(); ++part)
    if (sample_number(exr.part_name(part)) >= 0) return true;
  return false;
}

namespace {

/// How much of the file speaks for the preset: features in channels that are more than one letter.
size_t evidence(const ExrReader& exr, const SourceSample& sample) {
  size_t found = sample.alpha.mapping != nullptr ? 1 : 0;
  for (const SourceFeature& source : sample.features)
    if (exr.parts() > 1 || source.channels[0].name.size() > 1) ++found;
  return found;
}

}  // namespace

std::string recognise_preset(const ExrReader& exr, const std::string& view,
                             const std::vector<std::string>& assignments) {
  // Plain R, G and B could be anybody's; then the first counts.
  std::vector<std::string> names = preset_names();
  std::stable_partition(names.begin(), names.end(),
                        [](const std::string& name) { return name == "mitsuba"; });
  std::string best, doubt;
  size_t most = 0;
  for (const std::string& name : names) {
    ImportMapping mapping;
    try {
      mapping = read_mapping(name, {}, assignments);
    } catch (const UsageError& error) {
      if (doubt.empty()) doubt = error.what();  // what is set does not go with every preset
      continue;
    }
    mapping.view = view;
    if (!holds_radiance(exr, mapping)) continue;
    try {
      const std::vector<SourceSample> samples = plan_samples(exr, mapping, Wanted::all);
      const size_t found = evidence(exr, samples[0]);
      if (!best.empty() && found <= most) continue;
      most = found;
      best = name;
    } catch (const Error& error) {
      doubt = error.what();
    }
  }
  if (!best.empty()) return best;
  if (!doubt.empty()) fail("{}", doubt);
  fail(
      "{}: no picture that the presets ({}) know; the file has {}; say which channels are what with "
      "--mapping",
      exr.path(), fmt::join(preset_names(), ", "), channels_of_parts(exr));
}

}  // namespace ld
