// Sequences: one scene over many frames, the camera flying through it, objects moving on at even speed.
#pragma once

#include <algorithm>

#include "render/recipe/sequence_camera.h"

namespace ld {

// Index c of RandomStream(seed, scene, sequence, 0, c) for the camera's way: beyond those of random scenes
// and views.
constexpr uint32_t kPathStream = 32;

/// The part of an even motion, given over one frame, that begins `from` frames later and lasts `frames` of
/// them; negative ones go back.
Motion part_of(const Motion& frame, float from, float frames);

/// Moves the mesh as the motion has it at time 1.
void carry(Mesh& mesh, const Motion& motion);

/// A scene whose objects' `motion` is their way in one frame, and the camera's way through it.
struct SequencePlan {
  Scene scene;  // at frame 0
  CameraPath path;
  float begin = -1e9F;  // until this frame the objects stand still

  /// How many frames of their way the objects have gone.
  float progress(float frame) const { return std::max(frame, begin) - std::max(begin, 0.0F); }
  /// How many of them in the next `frames`; negative ones go back.
  float progress(float frame, float frames) const {
    return std::min(frame, frame + frames) >= begin ? frames : progress(frame + frames) - progress(frame);
  }
};

/// Takes the scene's objects, their motion times `speed`, and its camera as the start. `distance` is to what
/// the camera looks at.
SequencePlan plan_sequence(Scene scene, float distance, int64_t length, float speed, RandomStream& random);

/// The camera at frame `position`, the shutter open for a share of the time to the next frame; `previous` is
/// set.
Camera fly(const Camera& camera, const CameraPath& path, int64_t position, float shutter);

/// The scene at frame `position`: objects moved there, with their motion over the shutter and since the frame
/// before.
Scene sequence_frame(const SequencePlan& plan, int64_t position, float shutter);

}  // namespace ld
