// A look at the draft of a random scene before it is rendered: is there something to see, and how bright is
// it?
#pragma once

#include <cstdint>

#include "render/trace/prepared_scene.h"

namespace ld {

/// What is wrong with a draft; the first that applies.
enum class DraftFault { none, too_close, inside, empty, black, glassy, monotonous, harsh };
const char* fault_name(DraftFault fault);

struct DraftLook {
  DraftFault fault = DraftFault::none;
  float exposure = 1;  // what to multiply the light by
};

/// 24x24 pixels with a few paths each. The exposure brings the median luminance to `target`, less where the
/// brightest tenth of the picture would be beyond 2.5. Faults: the camera is against something or in it, sees
/// little but the sky, a quarter of the picture is black, almost all is glass or mirror, nearly everything is
/// one object or has one brightness, or bright and dark are so far apart that no exposure shows both.
DraftLook look_at_draft(const PreparedScene& scene, float target, uint64_t seed, uint32_t frame,
                        uint32_t attempt);

}  // namespace ld
