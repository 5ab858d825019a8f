#include "import/light_parts.h"

#include <ImfChannelList.h>

#include <algorithm>
#include <set>

#include "core/error.h"
#include "import/channel_pattern.h"

namespace ld {
namespace {

constexpr const char* kGroup = "{group}";

std::vector<std::string> split(const std::string& text, const std::string& separator) {
  std::vector<std::string> pieces;
  for (size_t begin = 0; begin <= text.size();) {
    const size_t end = std::min(text.find(separator, begin), text.size());
    pieces.push_back(text.substr(begin, end - begin));
    begin = end + separator.size();
  }
  return pieces;
}

bool has_group(const std::string& text) {
  return text.find(kGroup) != std::string::npos;
}

std::string with_group(std::string text, const std::string& group) {
  for (size_t at = text.find(kGroup); at != std::string::npos; at = text.find(kGroup, at + group.size()))
    text.replace(at, std::string(kGroup).size(), group);
  return text;
}

/// What {group} of a pattern stands for in a name: the longest text; empty where it does not fit.
std::string group_in(const std::string& pattern, const std::string& name) {
  const size_t at = pattern.find(kGroup);
  const std::string before = pattern.substr(0, at),
                    after = pattern.substr(at + std::string(kGroup).size()) + ".R";
  if (name.size() < after.size() || name.compare(name.size() - after.size(), after.size(), after) != 0)
    return "";
  const size_t end = name.size() - after.size();
  for (size_t begin = 0; begin < end; ++begin)
    if (match_pattern(before, name.substr(0, begin))) return name.substr(begin, end - begin);
  return "";
}

/// All groups that the first layer of a formula finds.
std::set<std::string> groups_of(const ExrReader& exr, const FileViews& views, const ImportMapping& mapping,
                                const LightPartFormula& formula) {
  std::set<std::string> groups;
  for (const std::string& pattern : pattern_alternatives(with_layer(formula.terms[0][0], mapping.layer)))
    for (int part = 0; part < exr.parts(); ++part)
      for (auto it = exr.header(part).channels().begin(); it != exr.header(part).channels().end(); ++it) {
        const std::optional<std::string> name = views.name_of(part, it.name());
        if (!name) continue;
        std::string group = group_in(pattern, *name);
        if (group.empty() && exr.parts() > 1) group = group_in(pattern, views.part_name(part) + "." + *name);
        if (!group.empty()) groups.insert(group);
      }
  return groups;
}

/// The formulas with all groups that there are in the place of {group}.
std::vector<LightPartFormula> formulas_for(const ExrReader& exr, const FileViews& views,
                                           const ImportMapping& mapping) {
  std::vector<LightPartFormula> formulas;
  for (const std::string& text : mapping.parts) {
    const LightPartFormula formula = parse_light_part(text);
    if (!has_group(formula.name)) {
      formulas.push_back(formula);
      continue;
    }
    for (const std::string& group : groups_of(exr, views, mapping, formula)) {
      LightPartFormula own = formula;
      own.name = with_group(own.name, group);
      for (std::vector<std::string>& term : own.terms)
        for (std::string& layer : term) layer = with_group(layer, group);
      formulas.push_back(std::move(own));
    }
  }
  return formulas;
}

/// The pattern of a layer's channel, in all alternatives.
std::string channel_of_layer(const std::string& layer, char channel) {
  std::string pattern;
  for (const std::string& alternative : pattern_alternatives(layer))
    pattern += (pattern.empty() ? "" : " | ") + alternative + "." + channel;
  return pattern;
}

}  // namespace

LightPartFormula parse_light_part(const std::string& text) {
  const std::vector<std::string> sides = split(text, " = ");
  LightPartFormula formula;
  formula.name = sides[0];
  if (sides.size() == 2)
    for (const std::string& term : split(sides[1], " + ")) formula.terms.push_back(split(term, " * "));
  bool complete = sides.size() == 2 && !formula.name.empty();
  for (const std::vector<std::string>& term : formula.terms)
    for (const std::string& layer : term)
      complete = complete && !layer.empty() && has_group(layer) <= has_group(formula.name);
  if (!complete || has_group(formula.name) != has_group(formula.terms[0][0]))
    fail_usage(
        "mapping: parts: '{}'; expected 'NAME = LAYER * LAYER + LAYER' with spaces around the signs, and "
        "{{group}} in the name and in the first layer or in neither",
        text);
  return formula;
}

std::vector<std::vector<SourcePart>> plan_light_parts(const ExrReader& exr, const ImportMapping& mapping) {
  const FileViews views(exr, mapping.view);
  const std::vector<int> numbers = sample_numbers(exr, mapping);
  std::vector<std::vector<SourcePart>> samples(numbers.size());
  std::set<std::string> names;
  for (const LightPartFormula& formula : formulas_for(exr, views, mapping)) {
    if (names.count(formula.name) > 0) continue;
    std::vector<SourcePart> parts(numbers.size(), {formula.name, {}, {}});
    bool complete = true;
    for (const std::vector<std::string>& term : formula.terms) {
      for (SourcePart& part : parts) part.factors.push_back(term.size());
      for (const std::string& layer : term)
        for (const char channel : {'R', 'G', 'B'}) {
          const FoundChannels found =
              find_channels(exr, views, mapping, mapping.part, channel_of_layer(layer, channel));
          for (size_t s = 0; s < numbers.size(); ++s) {
            auto at = found.find(numbers[s]);
            if (at == found.end()) at = found.find(-1);  // one colour for all samples
            complete = complete && at != found.end();
            if (!complete) break;
            exr.require_channel(at->second.part, at->second.name, "");
            parts[s].channels.push_back(at->second);
          }
        }
    }
    if (!complete) continue;
    names.insert(formula.name);
    for (size_t s = 0; s < numbers.size(); ++s) samples[s].push_back(std::move(parts[s]));
  }
  return samples;
}

std::vector<std::vector<float>> sum_of_products(const SourcePart& part,
                                                const std::vector<std::vector<float>>& planes) {
  std::vector<std::vector<float>> sum(3, std::vector<float>(planes[0].size()));
  for (size_t c = 0; c < 3; ++c)
    for (size_t p = 0; p < sum[c].size(); ++p) {
      double total = 0;
      size_t plane = c;
      for (const size_t factors : part.factors) {
        double product = 1;
        for (size_t f = 0; f < factors; ++f, plane += 3) product *= double(planes[plane][p]);
        total += product;
      }
      sum[c][p] = static_cast<float>(total);
    }
  return sum;
}

}  // namespace ld
