// The light of random scenes: skies, suns, studio lights, lamps.
#pragma once

#include "render/random/scene_builder.h"

namespace ld {

/// White balanced light from candle to overcast sky.
Vec3 light_colour(RandomStream& random);

/// One of the user's probes where there are any, else a sky: a gradient with a sun or soft boxes, or a
/// picture with clouds. `studio` prefers soft boxes.
void add_environment(SceneBuilder& builder, bool studio);

/// A lamp of the given size around `centre` that shines along `direction`; `power` is radiance times area.
/// With a back, unless it lies against something.
void add_area_light(SceneBuilder& builder, Vec3 centre, Vec3 direction, float width, float depth, float power,
                    bool back);

/// A point light or a spot; intensity like an area light of this power.
void add_point_light(SceneBuilder& builder, Vec3 position, Vec3 direction, float power);

}  // namespace ld
