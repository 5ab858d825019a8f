// Whether what a glTF file says of its buffers can be: Assimp reads where it is told to.
#pragma once

#include "render/file/gltf_item.h"

namespace ld {

/// Throws Error where a buffer view does not lie within its buffer, an accessor within its view, and where a
/// part of a mesh has no positions or too few.
void check_gltf_buffers(const GltfItem& root);

}  // namespace ld
