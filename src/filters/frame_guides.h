// Frames as the classical filters read them: one surface a pixel, and light apart from colour.
#pragma once

#include <string>
#include <vector>

#include "filters/illumination.h"
#include "filters/kernels/surfaces.h"
#include "frame/frame.h"

namespace ld {

/// What the filters read of a frame where it is there, besides radiance.
std::vector<std::string> filter_features();

/// One line for each thing that the frame lacks: what, and what is taken instead. `temporal`: what only the
/// temporal filter reads, too.
std::vector<std::string> missing_guides(const Frame& frame, bool temporal);

/// A pixel's surface is that of one of its samples, the one of the lower median depth (of equal ones the
/// first): normal, depth, id and flow come from it. Albedo, specular colour and light are means over the
/// samples. Normals are turned to world space and positions computed where the frame has its camera's
/// matrices. Instead of what is missing: one id, view space, depths that do not change, one signal, no
/// emission but where the ray escaped, a wall that faces the camera; without flow there is no history.
void read_guides(const Frame& frame, const IlluminationSettings& settings, Surfaces& surfaces,
                 Illumination& light, int threads);

}  // namespace ld
