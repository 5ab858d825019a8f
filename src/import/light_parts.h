// Parts of the light, which add up to the radiance, as sums of products of layers: renderers that divide the
// light of a surface by its colour write the colour beside it.
#pragma once

#include <string>
#include <vector>

#include "import/source_plan.h"

namespace ld {

/// "NAME = LAYER * LAYER + LAYER": a sum of products of layers, each a pattern of channels R, G and B without
/// ".R" (channel_pattern.h). {group} in the name and in the layers stands for any text, of which each that is
/// found makes a part of its own.
struct LightPartFormula {
  std::string name;
  std::vector<std::vector<std::string>> terms;  // the factors of each
};

/// Throws UsageError.
LightPartFormula parse_light_part(const std::string& text);

/// A part of one sample.
struct SourcePart {
  std::string name;
  std::vector<size_t> factors;          // how many layers each term multiplies
  std::vector<SourceChannel> channels;  // R, G and B of each layer, in their order
};

/// The parts of each sample, in the order of plan_samples(): those of the mapping all of whose layers the
/// file has, of a name the first. Throws Error as find_channels().
std::vector<std::vector<SourcePart>> plan_light_parts(const ExrReader& exr, const ImportMapping& mapping);

/// The sum of the products of the layers' planes, [R, G, B].
std::vector<std::vector<float>> sum_of_products(const SourcePart& part,
                                                const std::vector<std::vector<float>>& planes);

}  // namespace ld
