#include "render/file/scene_file_materials.h"

#include <assimp/GltfMaterial.h>

#include <cstring>
#include <functional>
#include <map>

#include "core/error.h"

namespace ld {
namespace {

namespace fs = std::filesystem;
using Picture = std::shared_ptr<const TextureImage>;

float number(const aiMaterial& material, const char* key, float fallback) {
  ai_real value = 0;
  return material.Get(key, 0, 0, value) == AI_SUCCESS && std::isfinite(value) ? value : fallback;
}

bool has(const aiMaterial& material, const char* key) {
  const aiMaterialProperty* property = nullptr;
  return aiGetMaterialProperty(&material, key, 0, 0, &property) == AI_SUCCESS;
}

Vec3 colour(const aiMaterial& material, const char* key, Vec3 fallback) {
  aiColor4D value;
  return material.Get(key, 0, 0, value) == AI_SUCCESS ? Vec3{value.r, value.g, value.b} : fallback;
}

std::string text(const aiMaterial& material, const char* key) {
  aiString value;
  return material.Get(key, 0, 0, value) == AI_SUCCESS ? value.C_Str() : "";
}

// Keys of assimp/material.h without the two zeros that its macros end with.
constexpr const char *kBase = "$clr.base", *kDiffuse = "$clr.diffuse", *kSpecular = "$clr.specular",
                     *kEmissive = "$clr.emissive", *kMetallic = "$mat.metallicFactor",
                     *kRoughness = "$mat.roughnessFactor", *kGlossiness = "$mat.glossinessFactor",
                     *kShininess = "$mat.shininess", *kTransmission = "$mat.transmission.factor",
                     *kIor = "$mat.refracti", *kOpacity = "$mat.opacity", *kAlphaMode = "$mat.gltf.alphaMode",
                     *kAlphaCutoff = "$mat.gltf.alphaCutoff", *kStrength = "$mat.emissiveIntensity";

/// A picture with every texel put through `change`.
Picture changed(const Picture& picture, const std::function<Vec3(Vec3)>& change) {
  auto copy = std::make_shared<TextureImage>(*picture);
  for (Vec3& texel : copy->texels) texel = change(texel);
  return copy;
}

class MaterialReader {
 public:
  MaterialReader(const aiScene& scene, const fs::path& file, const std::vector<GltfMaterial>& gltf)
      : scene_(scene), file_(file), gltf_(gltf) {}

  std::vector<Material> read() {
    materials_.resize(scene_.mNumMaterials);
    for (unsigned i = 0; i < scene_.mNumMaterials; ++i) {
      const Material material = convert(*scene_.mMaterials[i]);
      materials_[i] = material;
    }
    return std::move(materials_);
  }

 private:
  /// Empty when the material has no such picture.
  Picture picture(const aiMaterial& material, aiTextureType type, TextureUse use) {
    aiString name;
    if (material.GetTexture(type, 0, &name) != AI_SUCCESS) return nullptr;
    const auto [entry, is_new] = pictures_.try_emplace({name.C_Str(), use});
    if (is_new) entry->second = load(name.C_Str(), use);
    return entry->second;
  }

  Picture load(std::string name, TextureUse use) const {
    if (const aiTexture* embedded = scene_.GetEmbeddedTexture(name.c_str())) {
      const std::string called = file_.string() + ": texture " + name;
      if (embedded->mHeight != 0) fail("{}: stored as bare texels; expected PNG or JPEG", called);
      const auto* data = reinterpret_cast<const uint8_t*>(embedded->pcData);
      return decode_texture_image({data, data + embedded->mWidth}, called, use);
    }
    std::replace(name.begin(), name.end(), '\\', '/');
    fs::path path = file_.parent_path() / name;
    if (!fs::exists(path)) path = file_.parent_path() / percent_decoded(name);
    if (!fs::exists(path)) path = file_.parent_path() / fs::path(name).filename();
    if (!fs::exists(path))
      fail("{}: its texture {} is not there; put it where the file says, or beside it", file_.string(), name);
    return read_texture_image(path, use);
  }

  const GltfMaterial* gltf_of(const aiMaterial& material) const {
    const std::string name = text(material, "?mat.name"), prefix = "materials[";
    if (gltf_.empty() || name.compare(0, prefix.size(), prefix) != 0) return nullptr;
    return &gltf_.at(std::stoul(name.substr(prefix.size())));
  }

  static Texture textured(Vec3 factor, const Picture& picture) {
    return picture ? image_texture(picture, factor) : plain_texture(factor);
  }

  Texture base_colour(const aiMaterial& material) {
    Picture image = picture(material, aiTextureType_BASE_COLOR, TextureUse::colour);
    if (!image) image = picture(material, aiTextureType_DIFFUSE, TextureUse::colour);
    return textured(colour(material, kBase, colour(material, kDiffuse, grey(0.6F))), image);
  }

  int add(const Material& material) {
    materials_.push_back(material);
    return static_cast<int>(materials_.size()) - 1;
  }

  /// `share` of `second`, the rest of `first`; one of them alone where that is all there is.
  Material mixed(const Material& first, const Material& second, const Texture& share) {
    if (share.pattern == Pattern::plain && share.colour_a.x <= 0) return first;
    if (share.pattern == Pattern::plain && share.colour_a.x >= 1) return second;
    Material both;
    both.kind = MaterialKind::mixed;
    both.first = add(first);
    both.second = add(second);
    both.mask = share;
    return both;
  }

  Material metallic_roughness(const aiMaterial& material) {
    Material coated;
    coated.kind = MaterialKind::plastic;
    coated.colour = base_colour(material);
    coated.roughness = number(material, kRoughness, 1);
    coated.ior = number(material, kIor, 1.5F);
    const auto packed =
        picture(material, aiTextureType_UNKNOWN, TextureUse::data);  // glTF: G roughness, B metallic
    Texture metallic = plain_texture(grey(number(material, kMetallic, 1)));
    if (packed) {
      coated.roughness_map = image_texture(changed(packed, [](Vec3 t) { return grey(t.y); }));
      metallic = image_texture(changed(packed, [](Vec3 t) { return grey(t.z); }), metallic.colour_a);
    }
    Material metal = coated, glass = coated;
    metal.kind = coated.roughness > 0 ? MaterialKind::rough_conductor : MaterialKind::mirror;
    const bool rough = coated.roughness > 0.05F;
    glass.kind = rough ? MaterialKind::rough_dielectric : MaterialKind::smooth_dielectric;
    const float transmission = number(material, kTransmission, 0);
    if (metallic.image) {  // both at once is rare: the metal goes by its picture, glass or not by the larger
                           // share
      return mixed(transmission > 0.5F ? glass : coated, metal, metallic);
    }
    if (metallic.colour_a.x >= 1) return metal;
    const auto clear = picture(material, aiTextureType_TRANSMISSION, TextureUse::data);
    if (metallic.colour_a.x <= 0 && transmission > 0)
      return mixed(
          coated, glass,
          textured(grey(transmission), clear ? changed(clear, [](Vec3 t) { return grey(t.x); }) : clear));
    return mixed(coated, metal, metallic);
  }

  Material shiny(const aiMaterial& material) {
    Material result;
    result.colour = base_colour(material);
    if (has(material, kGlossiness)) {
      result.kind = MaterialKind::plastic;
      result.roughness = 1 - number(material, kGlossiness, 0);
      return result;
    }
    const float exponent = number(material, kShininess, 0);
    if (exponent <= 0 || max_component(colour(material, kSpecular, {})) <= 0) return result;
    result.kind = MaterialKind::plastic;
    // Blinn-Phong's exponent as GGX's alpha = sqrt(2 / (n + 2)) (Walter et al. 2007), roughness its root.
    result.roughness = std::pow(2 / (exponent + 2), 0.25F);
    const float ior = number(material, kIor, 1.5F);
    if (ior > 1) result.ior = ior;  // OBJ writes 1 when it has nothing to say
    return result;
  }

  void override(const GltfMaterial& own, const aiMaterial& source, Material& material) {
    if (own.kind) {
      material = Material();
      material.kind = *own.kind;
      material.colour = base_colour(source);
      material.roughness = number(source, kRoughness, 1);
      material.ior = number(source, kIor, 1.5F);
    }
    const bool has_roughness = material.kind != MaterialKind::mirror &&
                               material.kind != MaterialKind::diffuse &&
                               material.kind != MaterialKind::smooth_dielectric;
    if (own.roughness) material.roughness = *own.roughness;
    if (own.kind && !has_roughness) material.roughness = material.kind == MaterialKind::diffuse ? 1.0F : 0.0F;
    if (own.ior) material.ior = *own.ior;
    if (own.eta) material.metal_eta = *own.eta;
    if (own.k) material.metal_k = *own.k;
  }

  void add_opacity(const aiMaterial& source, Material& material) {
    const std::string mode = text(source, kAlphaMode);
    const float factor = number(source, kOpacity, 1);
    if (mode == "OPAQUE") return;
    Picture alpha = picture(source, aiTextureType_BASE_COLOR, TextureUse::alpha);
    if (mode == "MASK") {
      const float cutoff = number(source, kAlphaCutoff, 0.5F);
      if (alpha)
        material.opacity =
            image_texture(changed(alpha, [&](Vec3 t) { return grey(t.x * factor >= cutoff ? 1.0F : 0.0F); }));
      else if (factor < cutoff)
        material.opacity = plain_texture({});
      return;
    }
    if (mode.empty()) alpha = picture(source, aiTextureType_OPACITY, TextureUse::data);
    if (alpha || factor < 1) material.opacity = textured(grey(factor), alpha);
  }

  Material convert(const aiMaterial& source) {
    const GltfMaterial* own = gltf_of(source);
    const bool metallic = has(source, kMetallic) && !has(source, kGlossiness);
    Material material = metallic ? metallic_roughness(source) : shiny(source);
    if (own != nullptr) override(*own, source, material);
    const float strength = own != nullptr ? own->emissive_strength : number(source, kStrength, 1);
    const Vec3 glow = colour(source, kEmissive, {}) * strength;
    if (max_component(glow) > 0)
      material.emission = textured(glow, picture(source, aiTextureType_EMISSIVE, TextureUse::colour));
    add_opacity(source, material);
    return material;
  }

  const aiScene& scene_;
  const fs::path& file_;
  const std::vector<GltfMaterial>& gltf_;
  std::vector<Material> materials_;
  std::map<std::pair<std::string, TextureUse>, Picture> pictures_;
};

}  // namespace

std::vector<Material> read_materials(const aiScene& scene, const fs::path& file,
                                     const std::vector<GltfMaterial>& gltf) {
  return MaterialReader(scene, file, gltf).read();
}

unsigned uv_channel(const aiMaterial& material) {
  for (const aiTextureType type : {aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE}) {
    int channel = 0;
    if (material.Get(AI_MATKEY_UVWSRC(type, 0), channel) == AI_SUCCESS && channel >= 0)
      return static_cast<unsigned>(channel);
  }
  return 0;
}

}  // namespace ld
