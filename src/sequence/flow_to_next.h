// Where the surfaces of a frame will be: what `flow` tells of the frame before, for sequences that are walked
// backwards.
#pragma once

#include "sequence/surface_guides.h"

namespace ld {

/// Pixels from the place of what each pixel shows now to its place in the next frame, [2, H, W], +x right, +y
/// down; kNoFlow in both where nobody knows. Every pixel q of the next frame lay at q + flow(q) in this one:
/// it tells the four pixels around that place that they move by -flow(q). Of those that tell a pixel
/// something, one that shows the same surface (is_same_surface) wins over one that does not, then the one
/// whose place is nearer. What a pixel shows is known in both frames, so that no order of depths is needed.
/// Who arrives with another surface counts where no other does, because edges and samples of fine geometry
/// show now one surface, now the other; whoever looks there compares the surfaces anyway.
///
/// The guides must have one size, and the next frame's flow.
Image flow_to_next(const SurfaceGuides& now, const SurfaceGuides& next);

/// Every valid sample's flow becomes that of its pixel. The frame holds flow.
void set_flow(Frame& frame, const Image& flow);

}  // namespace ld
