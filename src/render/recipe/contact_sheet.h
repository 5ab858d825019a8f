// Small pictures of many scenes of a recipe on one sheet, to see whether they are worth rendering.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>

#include "render/random/draft_check.h"
#include "render/recipe/recipe.h"

namespace ld {

struct SheetReport {
  int64_t scenes = 0;
  int64_t drafts = 0;                      // drafts - scenes were rejected
  std::map<DraftFault, int64_t> rejected;  // for what
};

/// Renders the random scenes of frames [begin, end) at the recipe's resolution or 128 pixels a side,
/// whichever is smaller, with `spp` evenly spread samples, tone-mapped, in rows of `columns`, and writes them
/// as PNG. The scenes are those of the recipe's frames. Throws Error when the picture cannot be written,
/// UsageError when the recipe has a scene file in place of random scenes.
SheetReport render_contact_sheet(const Recipe& recipe, int64_t begin, int64_t end, int columns, int spp,
                                 const std::filesystem::path& path, int threads);

}  // namespace ld
