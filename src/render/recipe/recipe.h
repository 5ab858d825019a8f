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
#include "render/file/scene_file_config.h"
#include "render/random/random_scene.h"
#include "render/recipe/sequence_config.h"
#include "render/trace/path_tracer.h"

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
  uint64_t seed = 1;                                   // of scenes and samples
  std::vector<int64_t> resolution = {256, 256};        // width, height
  int64_t spp = 8;                                     // samples kept one by one
  SplitNumbers reference_spp = {1024, 1024, 1024, 1};  // paths a pixel of the references of a split
  SplitNumbers frames = {64, 4, 8, 0};                 // how many frames a split has
  int64_t max_bounces = 5;               // scatterings between camera and light; 0: only what shines itself
  std::string sampling = "independent";  // of the frames' samples; low_discrepancy spreads a pixel's evenly
  std::string guides =
      "first_hit";             // of the first surface, or through_specular: of what mirrors and glass show
  bool filter_guides = false;  // keep what classical filters read besides: id, parts of radiance, matrices
  bool half_radiance = false;  // samples at half the width and height beside each frame
  /// The least roughness of later surfaces once a path was scattered broadly, of samples and references alike
  /// (docs/rendering.md); 0: off.
  double path_regularisation = 0;
  /// The largest channel that light may bring over two or more bounces, of samples and references
  /// alike; 0: off.
  double indirect_clamp = 0;
  std::string reference_estimator = "mean";  // of the parts; robust leaves out what few of them have found
  int64_t reference_parts = 1;  // independent parts of a reference; from 2 on it knows its own floor
  SceneConfig scenes;
  SceneFileConfig scene_file;  // in place of `scenes` where it has a path
  SequenceConfig sequence;

  template <class Visitor>
  void visit(Visitor& v) {
    v.field("seed", seed);
    v.field("resolution", resolution, Range{1, 16384});
    v.field("spp", spp, Range{1, 4096});
    v.section("reference_spp", reference_spp);
    v.section("frames", frames);
    v.field("max_bounces", max_bounces, Range{0, 1000});
    v.field("sampling", sampling, {"independent", "low_discrepancy"});
    v.field("guides", guides, {"first_hit", "through_specular"});
    v.field("filter_guides", filter_guides);
    v.field("half_radiance", half_radiance);
    v.field("path_regularisation", path_regularisation, Range{0, 1});
    v.field("indirect_clamp", indirect_clamp, Range{0, 1e30});
    v.field("reference_estimator", reference_estimator, {"mean", "robust"});
    v.field("reference_parts", reference_parts, Range{1, 1024});
    v.section("scenes", scenes);
    v.section("scene_file", scene_file);
    v.section("sequence", sequence);
  }

  int width() const { return static_cast<int>(resolution[0]); }
  int height() const { return static_cast<int>(resolution[1]); }
  int64_t frame_count() const { return frames.train + frames.validation + frames.test; }
  /// How its paths go, of samples and references alike.
  PathSettings path_settings() const;
  /// "train", "validation" or "test"; `frame` in [0, frame_count()).
  std::string split(int64_t frame) const;
  int64_t reference_spp_of(int64_t frame) const;
  /// Which sequence a frame belongs to, and its place in it; with one frame a sequence the frame and 0.
  int64_t sequence_of(int64_t frame) const { return frame / sequence.length; }
  int64_t position_of(int64_t frame) const { return frame % sequence.length; }
  /// Paths of the frame's samples, in all their instances, and of its reference.
  int64_t paths(int64_t frame) const;
};

/// "frame_000012"; further noise instances of it "frame_000012_n1", "frame_000012_n2"...
std::string frame_name(int64_t frame, int64_t instance = 0);

/// Checks what one field cannot know of another, and finds the files (paths go from `folder`). `name` is what
/// complaints call the recipe. Throws UsageError; Error for a file that is missing.
void finish_recipe(Recipe& recipe, const std::string& name, const std::filesystem::path& folder);

/// File, then "key=value" overrides, then the seed. Throws Error when the file is missing, UsageError when it
/// is wrong.
Recipe read_recipe(const std::filesystem::path& path, const std::vector<std::string>& overrides,
                   std::optional<uint64_t> seed);

/// The recipe that `ld_render --scene` stands for: views of a scene file, one for each of its cameras (at
/// least one) when `views` is 0. From eight views on an eighth of them is kept for validation and another for
/// tests, of four to seven one for tests; all others are for training. The overrides come on top, then the
/// seed. Throws as read_recipe.
Recipe scene_recipe(const std::string& scene, const std::string& probe, int64_t views,
                    const std::vector<std::string>& overrides, std::optional<uint64_t> seed);

/// Parses "A:B", frames A to B - 1; either may be left out; "" is all. Throws UsageError when it does not
/// fit.
std::pair<int64_t, int64_t> frames_of_recipe(const std::string& text, int64_t frame_count);

}  // namespace ld
