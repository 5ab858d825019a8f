#include "render/recipe/recipe.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>

#include "core/error.h"
#include "core/shown_text.h"
#include "render/file/scene_file.h"

namespace ld {
namespace {

void check_pair(const std::string& name, const char* key, const std::vector<int64_t>& values,
                const char* expected) {
  if (values.size() != 2)
    fail_usage("{}: {}: expected two numbers, [{}], found {}", name, key, expected, values.size());
}

/// Halves of the parts make the floor, and a robust mean takes three estimates at least: with two there is no
/// telling which is the outlier.
void check_parts(const Recipe& recipe, const std::string& name) {
  const int64_t parts = recipe.reference_parts;
  const bool robust = recipe.reference_estimator == "robust";
  if (robust && (parts < 6 || parts % 2 != 0))
    fail_usage(
        "{}: reference_parts: expected an even number of at least 6 with reference_estimator: robust, found "
        "{}",
        name, parts);
  if (!robust && parts != 1 && parts % 2 != 0)
    fail_usage("{}: reference_parts: expected 1 or an even number, found {}", name, parts);
  const auto check = [&](const char* split, int64_t frames, int64_t spp) {
    if (frames > 0 && spp % parts != 0)
      fail_usage("{}: reference_spp.{}: expected a multiple of reference_parts ({}), found {}", name, split,
                 parts, spp);
  };
  check("train", recipe.frames.train, recipe.reference_spp.train);
  check("validation", recipe.frames.validation, recipe.reference_spp.validation);
  check("test", recipe.frames.test, recipe.reference_spp.test);
}

int64_t parse_bound(const std::string& text, const std::string& whole) {
  int64_t value = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || stop != text.data() + text.size())
    fail_usage("--frames {}: expected A:B, two frame numbers like 0:16 (16 not included)", shown(whole));
  return value;
}

}  // namespace

PathSettings Recipe::path_settings() const {
  PathSettings settings;
  settings.max_bounces = static_cast<int>(max_bounces);
  settings.guides_through_specular = guides == "through_specular";
  settings.regularisation = static_cast<float>(path_regularisation);
  settings.indirect_clamp = static_cast<float>(indirect_clamp);
  return settings;
}

std::string Recipe::split(int64_t frame) const {
  if (frame < frames.train) return "train";
  return frame < frames.train + frames.validation ? "validation" : "test";
}

int64_t Recipe::reference_spp_of(int64_t frame) const {
  if (frame < frames.train) return reference_spp.train;
  return frame < frames.train + frames.validation ? reference_spp.validation : reference_spp.test;
}

int64_t Recipe::paths(int64_t frame) const {
  const int64_t pixels = resolution[0] * resolution[1];
  const int64_t halved = half_radiance ? ((resolution[0] + 1) / 2) * ((resolution[1] + 1) / 2) : 0;
  return (pixels + halved) * spp * sequence.noise_instances + pixels * reference_spp_of(frame);
}

std::string frame_name(int64_t frame, int64_t instance) {
  const std::string name = fmt::format("frame_{:06}", frame);
  return instance == 0 ? name : fmt::format("{}_n{}", name, instance);
}

void finish_recipe(Recipe& recipe, const std::string& name, const std::filesystem::path& folder) {
  check_pair(name, "resolution", recipe.resolution, "width, height");
  finish_scene_config(recipe.scenes, name, folder);
  if (recipe.frame_count() == 0)
    fail_usage("{}: frames: expected at least one frame in train, validation or test, found none", name);
  constexpr int64_t kMostFrames = 100000000;  // they are counted in 27 bits
  if (recipe.frame_count() > kMostFrames)
    fail_usage("{}: frames: expected at most {} in all, found {}", name, kMostFrames, recipe.frame_count());
  check_parts(recipe, name);
  const int64_t length = recipe.sequence.length;
  for (const int64_t count : {recipe.frames.train, recipe.frames.validation, recipe.frames.test})
    if (count % length != 0)
      fail_usage(
          "{}: frames: a split of {} frames cuts a sequence of {}; expected multiples of sequence.length",
          name, count, length);
  if (recipe.sequence.kinds.empty())
    fail_usage("{}: sequence.kinds: expected at least one kind, found none", name);
  if (recipe.scene_file.used() && recipe.sequence.kinds != SequenceConfig().kinds)
    fail_usage(
        "{}: sequence.kinds: expected [fly] for a scene file, found [{}]; other kinds are of random scenes",
        name, fmt::join(recipe.sequence.kinds, ", "));
  resolve(recipe.scene_file, folder);
}

Recipe read_recipe(const std::filesystem::path& path, const std::vector<std::string>& overrides,
                   std::optional<uint64_t> seed) {
  ConfigNode tree = read_config(path);
  for (const std::string& assignment : overrides) apply_override(tree, assignment);
  auto recipe = config_from_tree<Recipe>(tree);
  if (seed) recipe.seed = *seed;
  finish_recipe(recipe, path.string(), path.parent_path());
  return recipe;
}

Recipe scene_recipe(const std::string& scene, const std::string& probe, int64_t views,
                    const std::vector<std::string>& overrides, std::optional<uint64_t> seed) {
  if (views == 0) views = std::max<int64_t>(1, static_cast<int64_t>(SceneFile(scene).camera_count()));
  Recipe given;
  given.frames.validation = views / 8;
  given.frames.test = views >= 8 ? views / 8 : views / 4;
  given.frames.train = views - given.frames.validation - given.frames.test;
  given.scene_file.path = scene;
  given.scene_file.probe = probe;
  ConfigNode tree = parse_config(config_to_yaml(given), "--scene");
  for (const std::string& assignment : overrides) apply_override(tree, assignment);
  auto recipe = config_from_tree<Recipe>(tree);
  if (seed) recipe.seed = *seed;
  finish_recipe(recipe, "--scene " + scene, "");
  return recipe;
}

std::pair<int64_t, int64_t> frames_of_recipe(const std::string& text, int64_t frame_count) {
  if (text.empty()) return {0, frame_count};
  const size_t colon = text.find(':');
  if (colon == std::string::npos)
    fail_usage("--frames {}: expected A:B, two frame numbers like 0:16 (16 not included)", shown(text));
  const std::string low = text.substr(0, colon), high = text.substr(colon + 1);
  const int64_t begin = low.empty() ? 0 : parse_bound(low, text);
  const int64_t end = high.empty() ? frame_count : parse_bound(high, text);
  if (begin < 0 || begin >= end || end > frame_count)
    fail_usage(
        "--frames {}: expected a range that is not empty and lies within 0:{}, the frames of the recipe",
        shown(text), frame_count);
  return {begin, end};
}

}  // namespace ld
