#include "render/file/gltf_json.h"

#include <fmt/ranges.h>

#include <charconv>
#include <cstring>
#include <map>

#include "core/error.h"
#include "core/file_io.h"
#include "core/json_text.h"
#include "render/file/gltf_buffers.h"
#include "render/file/gltf_item.h"

namespace ld {
namespace {

using nlohmann::json;
using Item = GltfItem;

constexpr uint32_t kMagic = 0x46546C67, kJsonChunk = 0x4E4F534A;  // "glTF", "JSON"
constexpr size_t kHeader = 12, kChunkHeader = 8;

uint32_t word(const std::string& bytes, size_t at) {
  uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);  // little-endian, as this machine is
  return value;
}

void put_word(std::string& bytes, size_t at, size_t value) {
  const auto small = static_cast<uint32_t>(value);
  std::memcpy(bytes.data() + at, &small, sizeof small);
}

bool is_binary(const std::string& bytes) {
  return bytes.size() >= 4 && word(bytes, 0) == kMagic;
}

/// Length of the JSON chunk of a .glb, which must come first.
size_t json_length(const std::string& bytes, const std::string& name) {
  if (bytes.size() < kHeader + kChunkHeader || word(bytes, 8) > bytes.size())
    fail("{}: truncated: its header says {} bytes, it has {}; copy it again", name,
         bytes.size() < kHeader ? kHeader : word(bytes, 8), bytes.size());
  const size_t length = word(bytes, kHeader);
  if (word(bytes, kHeader + 4) != kJsonChunk || length > bytes.size() - kHeader - kChunkHeader)
    fail("{}: damaged: no JSON chunk of {} bytes at its beginning; export it again", name, length);
  return length;
}

MaterialKind kind_of(const Item& item) {
  static const std::map<std::string, MaterialKind> kinds = {
      {"diffuse", MaterialKind::diffuse},
      {"rough_conductor", MaterialKind::rough_conductor},
      {"mirror", MaterialKind::mirror},
      {"smooth_dielectric", MaterialKind::smooth_dielectric},
      {"rough_dielectric", MaterialKind::rough_dielectric},
      {"plastic", MaterialKind::plastic}};
  const auto it = kinds.find(item.text(""));
  if (it != kinds.end()) return it->second;
  std::vector<std::string> names;
  for (const auto& [name, kind] : kinds) names.push_back(name);
  item.wrong(fmt::format("one of {}", fmt::join(names, ", ")));
}

GltfMaterial read_material(const Item& item, size_t index) {
  GltfMaterial material;
  material.name = item["name"].text(fmt::format("materials[{}]", index));
  const Item strength = item["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"];
  material.emissive_strength = strength.number(1);
  const Item own = item["extras"]["ld"];
  if (!own.there()) return material;
  if (own["kind"].there()) material.kind = kind_of(own["kind"]);
  if (own["roughness"].there()) material.roughness = own["roughness"].number(0);
  if (own["ior"].there()) material.ior = own["ior"].number(0);
  if (own["eta"].there()) material.eta = own["eta"].colour({});
  if (own["k"].there()) material.k = own["k"].colour({});
  return material;
}

void read_camera(const Item& item, const std::string& node, GltfFile& file) {
  const Item perspective = item["perspective"];
  if (!perspective.there()) return;  // orthographic: the renderer has no such camera
  GltfCamera camera;
  camera.node = node;
  camera.name = item["name"].text(node);
  camera.fov = perspective["yfov"].number(0);
  if (!(camera.fov > 0 && camera.fov < kPi)) perspective["yfov"].wrong("an angle between 0 and pi");
  const Item own = item["extras"]["ld"];
  camera.lens_radius = own["aperture_radius"].number(0);
  camera.focus_distance = own["focus_distance"].number(1);
  if (camera.lens_radius < 0 || !(camera.focus_distance > 0))
    own.wrong("aperture_radius of at least 0 and focus_distance above 0");
  file.cameras.push_back(camera);
}

GltfLight read_light(const Item& item, const std::string& node) {
  GltfLight light;
  light.node = node;
  const std::string type = item["type"].text("");
  if (type == "spot")
    light.kind = GltfLightKind::spot;
  else if (type == "directional")
    light.kind = GltfLightKind::directional;
  else if (type != "point")
    item["type"].wrong("point, spot or directional");
  light.intensity = item["color"].colour({1, 1, 1}) * item["intensity"].number(1);
  light.inner = item["spot"]["innerConeAngle"].number(light.inner);
  light.outer = item["spot"]["outerConeAngle"].number(light.outer);
  return light;
}

GltfProbe read_probe(const Item& item, const std::filesystem::path& folder) {
  GltfProbe probe;
  probe.path = folder / item["uri"].text("");
  if (!item["uri"].there()) item.wrong("an object with a \"uri\"");
  probe.scale = item["scale"].colour({1, 1, 1});
  probe.turn = item["rotation_y"].number(0);
  return probe;
}

void read_nodes(const Item& root, GltfFile& file) {
  const Item nodes = root["nodes"], cameras = root["cameras"];
  const Item lights = root["extensions"]["KHR_lights_punctual"]["lights"];
  for (size_t i = 0; i < nodes.size(); ++i) {
    const Item node = nodes.at(i);
    const std::string name = fmt::format("nodes[{}]", i);
    if (node["camera"].there()) read_camera(node["camera"].in(cameras), name, file);
    const Item light = node["extensions"]["KHR_lights_punctual"]["light"];
    if (light.there()) file.lights.push_back(read_light(light.in(lights), name));
  }
}

void note_files(const Item& list, const std::filesystem::path& folder, GltfFile& file) {
  for (size_t i = 0; i < list.size(); ++i) {
    const std::string uri = list.at(i)["uri"].text("");
    if (!uri.empty() && uri.compare(0, 5, "data:") != 0) file.files.push_back(folder / percent_decoded(uri));
  }
}

/// The file again around the changed JSON.
std::string rebuild(const std::string& bytes, const json& root, const std::string& name) {
  std::string text = root.dump(-1, ' ', false, json::error_handler_t::replace);
  if (!is_binary(bytes)) return text;
  const size_t old = json_length(bytes, name);
  text.resize((text.size() + 3) / 4 * 4, ' ');
  std::string result =
      bytes.substr(0, kHeader + kChunkHeader) + text + bytes.substr(kHeader + kChunkHeader + old);
  put_word(result, 8, result.size());
  put_word(result, kHeader, text.size());
  return result;
}

}  // namespace

std::string percent_decoded(const std::string& uri) {
  std::string result;
  for (size_t i = 0; i < uri.size(); ++i) {
    unsigned char byte = 0;
    const char* digits = uri.data() + i + 1;
    if (uri[i] == '%' && i + 2 < uri.size() &&
        std::from_chars(digits, digits + 2, byte, 16).ptr == digits + 2) {
      result += static_cast<char>(byte);
      i += 2;
    } else {
      result += uri[i];
    }
  }
  return result;
}

bool is_gltf(const std::filesystem::path& path) {
  return path.extension() == ".gltf" || path.extension() == ".glb";
}

GltfFile read_gltf(const std::filesystem::path& path) {
  const std::string name = path.string();
  const std::string bytes = read_file(path);
  const std::string text =
      is_binary(bytes) ? bytes.substr(kHeader + kChunkHeader, json_length(bytes, name)) : bytes;
  json root = parse_json(text, name);
  const Item top(root, name + ": glTF");
  const std::string version = top["asset"]["version"].text("");
  GltfFile file;
  if (version.substr(0, 2) != "2.") {
    if (version.substr(0, 2) == "1.") return {bytes, {}, {}, {}, {}, {}};
    fail("{}: asset.version is '{}'; expected 2.0 (or 1.0); is it a glTF file?", name, version);
  }
  check_gltf_buffers(top);
  read_nodes(top, file);
  const Item materials = top["materials"];
  for (size_t i = 0; i < materials.size(); ++i) file.materials.push_back(read_material(materials.at(i), i));
  for (const char* list : {"buffers", "images"}) note_files(top[list], path.parent_path(), file);
  const Item scenes = top["scenes"];
  if (scenes.size() > 0) {
    const Item scene = top["scene"].there() ? top["scene"].in(scenes) : scenes.at(0);
    const Item probe = scene["extras"]["ld"]["probe"];
    if (probe.there()) file.probe = read_probe(probe, path.parent_path());
  }
  // Bones move nothing here, and Assimp ends the program at skins that have no matrices of their own, which
  // glTF allows.
  root.erase("skins");
  if (root.contains("nodes"))
    for (json& node : root["nodes"])
      if (node.is_object()) {
        node.erase("name");
        node.erase("skin");
      }
  for (size_t i = 0; i < materials.size(); ++i)
    root["materials"][i]["name"] = fmt::format("materials[{}]", i);
  file.bytes = rebuild(bytes, root, name);
  return file;
}

}  // namespace ld
