// Renders frames of a recipe into a data set's folder (frame/manifest.h).
#pragma once

#include <cstdint>
#include <filesystem>

#include "render/recipe/recipe.h"

namespace ld {

struct RenderReport {
  int64_t rendered = 0;  // frames written by this run
  int64_t present = 0;   // frames that an earlier run had finished
  int64_t left = 0;      // frames that a stop kept from being finished
  int64_t paths = 0;     // traced by this run
  int64_t clamped = 0;   // radiance channels beyond half's range, in the samples
  double seconds = 0;
};

/// frame_000012.half.exr: samples of the same view at half the width and height (rounded up), with their own
/// random numbers; of recipes with half_radiance.
std::filesystem::path half_path(const std::filesystem::path& folder, const std::string& name);

/// Renders frames [begin, end) that `folder` does not hold yet: frame_000012.exr, frame_000012.reference.exr
/// and an entry in manifest.json each; with several noise instances also frame_000012_n1.exr,
/// frame_000012_n1. reference.exr and so on, the references being one file under several names. A frame
/// counts as held when the manifest lists it and its files have the listed checksums. A frame's bytes depend
/// on the recipe and its index alone, so any number of machines may share the frames. Returns within about a
/// second of stop_requested(), leaving finished frames only. Throws Error when the folder holds a data set of
/// another recipe or cannot be written.
RenderReport render_dataset(const Recipe& recipe, const std::filesystem::path& folder, int64_t begin,
                            int64_t end, int threads);

}  // namespace ld
