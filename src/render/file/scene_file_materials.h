// The materials of a file that Assimp read. Inside the library only: pulls Assimp in.
#pragma once

#include <assimp/scene.h>

#include <filesystem>
#include <vector>

#include "render/file/gltf_json.h"
#include "render/trace/scene.h"

namespace ld {

/// Material i of the result is the file's material i as Assimp numbers them; parts of mixed ones follow after
/// them.
/// - metallic-roughness: a plastic (diffuse base under a GGX coat) where metallic is 0, a conductor where it
/// is 1, a
///   mix of both between; transmission mixes a dielectric in;
/// - specular-glossiness: a plastic of roughness 1 - glossiness;
/// - others (OBJ, FBX...): plastic with the roughness of the Phong exponent, diffuse where nothing shines;
/// - emission from the emissive colour, picture and strength; opacity from the alpha of the base colour where
/// the alpha
///   mode is MASK (above the cutoff or not) or BLEND, and from `d`.
/// `gltf` is empty for other formats. Throws Error for a texture that is missing or no picture.
std::vector<Material> read_materials(const aiScene& scene, const std::filesystem::path& file,
                                     const std::vector<GltfMaterial>& gltf);

/// The texture coordinates that the material's colour goes by: a channel of the mesh, 0 when it says nothing.
unsigned uv_channel(const aiMaterial& material);

}  // namespace ld
