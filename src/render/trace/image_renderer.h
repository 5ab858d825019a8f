// Whole pictures: the samples of a frame and its reference.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "frame/frame.h"
#include "render/trace/path_tracer.h"

namespace ld {

struct RenderSettings {
  uint64_t seed = 0;
  uint32_t frame = 0;  // index in the recipe: another frame, other random numbers
  int spp = 8;
  bool filter_guides = false;  // keep what classical filters read besides
  int threads = 1;
  PathSettings path;
  bool low_discrepancy = false;  // spread the samples of a frame's pixels evenly, as a reference's always are
  int reference_parts = 1;       // independent parts of a reference, of spp / reference_parts samples each
  bool robust_reference = false;                // robust_mean of the parts in place of their mean
  std::function<bool()> stop;                   // asked between pixels; true: give up
  std::function<void(int64_t paths)> progress;  // called from any thread as tiles finish
};

/// spp samples of every pixel of the scene's camera, with guides, unfiltered. Sample s of pixel p takes its
/// numbers from RandomStream(seed, input_samples, frame, p, s), so threads do not matter; with
/// low_discrepancy the samples of a pixel are one SampleNumbers sequence each, scrambled by
/// RandomStream(seed, input_samples, frame, p). info.seed, frame, scene, camera and depth_scale are filled,
/// the features are those of [MH20]; with filter_guides also id, direct, indirect, emission and the camera's
/// matrices. Flow and flow_depth are there, but not among the features: only who renders sequences knows what
/// they mean. Empty when stopped.
std::optional<Frame> render_samples(const PreparedScene& scene, const RenderSettings& settings);

/// Two independent references of half the samples each, [3, H, W]; what they differ by tells how far their
/// mean is from its limit (metrics/floor.h).
struct ReferenceHalves {
  Image first, second;
};

/// Mean radiance [3, H, W] of spp samples of each pixel, one pixel box filter, accumulated in double. The
/// samples of a pixel are spread evenly (SampleNumbers), those of part k scrambled by RandomStream(seed,
/// reference, frame, p, k): far less noise than as many independent samples leave, no bias, nothing in common
/// with the frame's. spp must be a multiple of reference_parts. `halves`, when given, receives what the first
/// and the second half of the parts say by themselves, by the same estimator; reference_parts must then be
/// even. Empty when stopped.
std::optional<Image> render_reference(const PreparedScene& scene, const RenderSettings& settings,
                                      ReferenceHalves* halves = nullptr);

}  // namespace ld
