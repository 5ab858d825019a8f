// What happens in a sequence of random scenes, by the kinds that recipes name (sequence.kinds).
#pragma once

#include <cstdint>
#include <vector>

#include "render/recipe/recipe.h"
#include "render/recipe/sequence.h"

namespace ld {

/// A part of a sequence between two cuts.
struct Take {
  int64_t first;  // its first frame
  SequencePlan plan;
};

struct Shot {
  std::vector<Take> takes;  // in order; the first begins at frame 0
  int64_t lamps_off =
      -1;  // from this frame on all but sky, probe and kEmergency of the lamps is off; -1: never
};
/// What is left of the lamps' light, for a reference of 0 has no relative error.
constexpr float kEmergency = 0.05F;

/// The shot of a sequence, a pure function of recipe and number. Kinds:
/// - fly: a random scene; the camera flies through it, objects move (plan_sequence());
/// - cut: two scenes, one after the other, flown through;
/// - light_off: a room whose lamps go out at once;
/// - door: a dim room, a door to a bright one opens, the camera stands or turns a little;
/// - enter: three objects cross the picture from outside of it;
/// - dolly: the camera goes straight ahead, half of the way to what it looks at in all;
/// - turn: the camera turns on the spot by 1.5 to 3.5 degrees a frame;
/// - mirror: a room with a large mirror in which things move; the camera goes sideways;
/// - thin: wires and plants; the camera goes sideways;
/// - still: nothing moves, only the noise is new.
Shot plan_shot(const Recipe& recipe, int64_t sequence);

/// The scene at frame `position`, its `cut` set where a take other than the first begins.
Scene shot_frame(const Shot& shot, int64_t position, float shutter);

}  // namespace ld
