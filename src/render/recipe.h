// A recipe is a data set in a few lines of YAML: how many frames of which scenes, at which quality. The
// resolved recipe stands in the data set's manifest.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/config_visitor.h"
#include "render/random_scene.h"

namespace ld {

/// One number for each split. Frames are counted through: training first, then validation, then test.
struct SplitNumbers {
  int64_t train = 0, validation = 0, test = 0;
  int64_t least = 0;  // allowed, set by the recipe

  template <class Visitor>
  void visit(Visitor& v) {
    const Range range = {static_cast<double>(least), 1e8};  // pixels and samples count in 32 bits
    v.field("train", train, range);
    v.field("validation", validation, range);
    v.field("test", test, range);
  }
};

struct Recipe {
  uint64_t seed = 1;
  std::vector<int64_t> resolution = {256, 256};  // width, height
  int64_t spp = 8;                               // samples kept one by one
  SplitNumbers reference_spp = {1024, 1024, 1024, 1};
  SplitNumbers frames = {64, 4, 8, 0};
  int64_t max_bounces = 5;
  SceneConfig scenes;

  template <class Visitor>
  void visit(Visitor& v) {
    v.field("seed", seed);
    v.field("resolution", resolution, Range{1, 16384});
    v.field("spp", spp, Range{1, 4096});
    v.section("reference_spp", reference_spp);
    v.section("frames", frames);
    v.field("max_bounces", max_bounces, Range{0, 1000});
    v.section("scenes", scenes);
  }

  int width() const { return static_cast<int>(resolution[0]); }
  int height() const { return static_cast<int>(resolution[1]); }
  int64_t frame_count() const { return frames.train + frames.validation + frames.test; }
  /// "train", "validation" or "test"; `frame` in [0, frame_count()).
  std::string split(int64_t frame) const;
  int64_t reference_spp_of(int64_t frame) const;
  /// Paths of the frame's samples and its reference.
  int64_t paths(int64_t frame) const {
    return resolution[0] * resolution[1] * (spp + reference_spp_of(frame));
  }
};

/// "frame_000012"
std::string frame_name(int64_t frame);

/// File, then "key=value" overrides, then the seed. Throws Error when the file is missing, UsageError when it
/// is wrong.
Recipe read_recipe(const std::filesystem::path& path, const std::vector<std::string>& overrides,
                   std::optional<uint64_t> seed);

/// Parses "A:B", frames A to B - 1; either may be left out; "" is all. Throws UsageError when it does not
/// fit.
std::pair<int64_t, int64_t> parse_frame_range(const std::string& text, int64_t frame_count);

}  // namespace ld
