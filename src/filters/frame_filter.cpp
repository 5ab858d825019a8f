#include "filters/frame_filter.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <any>

#include "core/config_tree.h"
#include "core/error.h"
#include "core/log.h"

namespace ld {
namespace {

bool is_kind(const std::string& text) {
  const std::vector<std::string> kinds = filter_kinds();
  return std::find(kinds.begin(), kinds.end(), text) != kinds.end();
}

}  // namespace

std::vector<std::string> filter_kinds() {
  return {"eaw", "svgf"};
}

std::vector<FilterArgument> parse_filter_arguments(const std::vector<std::string>& arguments,
                                                   std::vector<std::string>& assignments) {
  std::vector<FilterArgument> filters;
  for (const std::string& argument : arguments) {
    const size_t equals = argument.find('=');
    FilterArgument filter;
    filter.name = argument.substr(0, equals);
    filter.kind = equals == std::string::npos ? argument : argument.substr(equals + 1);
    if (!is_kind(filter.kind) || filter.name.empty())
      fail_usage("--filter '{}': expected {}, or NAME= and one of them", argument,
                 fmt::join(filter_kinds(), " or "));
    for (const FilterArgument& other : filters)
      if (other.name == filter.name)
        fail_usage("--filter: '{}' is given twice; expected each name once, such as soft={}", filter.name,
                   filter.kind);
    const std::string prefix = filter.name + ".";
    const auto mine = std::stable_partition(
        assignments.begin(), assignments.end(),
        [&](const std::string& text) { return text.compare(0, prefix.size(), prefix) != 0; });
    for (auto text = mine; text != assignments.end(); ++text)
      filter.assignments.push_back(text->substr(prefix.size()));
    assignments.erase(mine, assignments.end());
    filters.push_back(std::move(filter));
  }
  return filters;
}

FrameFilter::FrameFilter(const FilterArgument& argument)
    : kind_(argument.kind), assignments_(argument.assignments) {
  if (!is_kind(kind_))
    fail_usage("no filter is called '{}'; expected {}", kind_, fmt::join(filter_kinds(), " or "));
  ConfigNode root;
  root.origin = "--set";
  for (const std::string& assignment : argument.assignments) apply_override(root, assignment);
  if (is_temporal())
    svgf_ = config_from_tree<SvgfSettings>(root);
  else
    eaw_ = config_from_tree<EawSettings>(root);
  check_settings(svgf_);
}

std::string FrameFilter::description() const {
  return assignments_.empty() ? kind_ : fmt::format("{} ({})", kind_, fmt::join(assignments_, ", "));
}

void FrameFilter::tell(const std::vector<std::string>& lines) {
  for (const std::string& line : lines) {
    if (std::find(told_.begin(), told_.end(), line) != told_.end()) continue;
    told_.push_back(line);
    spdlog::info("{}: {}", kind_, line);
  }
}

Image FrameFilter::denoise(const Frame& frame, SequenceState& state, int threads) {
  tell(missing_guides(frame, is_temporal()));
  const IlluminationSettings& light = is_temporal() ? svgf_.light : eaw_.light;
  read_guides(frame, light, surfaces_, light_, threads);
  if (light.firefly_bound > 0) bound_fireflies(light_.signals, spare_, light.firefly_bound, threads);
  const bool compresses = light.compress == "reinhard";
  if (compresses) compress(light_.signals, threads);
  if (!is_temporal()) {
    eaw(surfaces_, light_.signals, spare_, eaw_, threads);
    recombine(light_.signals, 3, light_, compresses, picture_, threads);
    return image_of(picture_, threads);
  }
  if (!state.memory.has_value()) state.memory = TemporalState();
  auto& kept = std::any_cast<TemporalState&>(state.memory);
  const RowPlanes& filtered = svgf(surfaces_, light_.signals, kept.light, memory_, svgf_, threads);
  recombine(filtered, 4, light_, compresses, picture_, threads);
  if (svgf_.antialias == 1) return image_of(picture_, threads);
  antialias(kept.light.surfaces, picture_, kept.picture, spare_, svgf_.antialias, svgf_.antialias_deviations,
            threads);
  return image_of(kept.picture.picture, threads);
}

}  // namespace ld
