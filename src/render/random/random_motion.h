// Random movement of what a scene holds, and where its camera focuses.
#pragma once

#include "core/random.h"
#include "render/random/scene_builder.h"
#include "render/trace/scene.h"

namespace ld {

struct SceneConfig;

/// Opens the shutter and moves models: 45 % of them, by 1 to 12 % of the picture's height; those that turn do
/// so about their middle. Now and then the camera moves as well.
void add_random_motion(Scene& scene, const std::vector<Placed>& models, const SceneConfig& config,
                       RandomStream& random);

/// Depth along the view axis of a model that the camera sees, for the lens to focus on.
float random_focus(const Scene& scene, const std::vector<Placed>& models, RandomStream& random);

}  // namespace ld
