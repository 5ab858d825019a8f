// glTF files that tests write: JSON with its buffers embedded.
#pragma once

#include <nlohmann/json.hpp>

#include <cstring>
#include <string>
#include <vector>

#include "core/file_io.h"
#include "render/geometry/vec3.h"

namespace ld {

inline std::string base64(const std::string& bytes) {
  const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t group = 0;
    for (size_t k = 0; k < 3; ++k)
      group = group << 8 | (i + k < bytes.size() ? static_cast<uint8_t>(bytes[i + k]) : 0);
    for (size_t k = 0; k < 4; ++k) text += i + k > bytes.size() ? '=' : digits[group >> (18 - 6 * k) & 63];
  }
  return text;
}

/// A scene of one mesh, the square [-1, 1]^2 in the xy plane facing +z, with texture coordinates; tests add
/// the rest.
class TestGltf {
 public:
  nlohmann::json root;

  TestGltf() {
    root["asset"]["version"] = "2.0";
    root["scene"] = 0;
    root["scenes"] = {{{"nodes", {0}}}};
    const int positions = add_floats({-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0}, "VEC3");
    root["accessors"][0]["min"] = {-1, -1, 0};
    root["accessors"][0]["max"] = {1, 1, 0};
    const int uvs = add_floats({0, 1, 1, 1, 1, 0, 0, 0}, "VEC2");  // v downwards, as glTF has it
    const int indices = add_indices({0, 1, 2, 0, 2, 3});
    root["meshes"] = {{{"primitives",
                        {{{"attributes", {{"POSITION", positions}, {"TEXCOORD_0", uvs}}},
                          {"indices", indices},
                          {"material", 0}}}}}};
    root["materials"] = {{{"pbrMetallicRoughness", {{"metallicFactor", 0}}}}};
    root["nodes"] = {{{"mesh", 0}}};
  }

  /// Returns the accessor's index.
  int add_floats(const std::vector<float>& values, const char* type) {
    const int width = type[0] == 'S' ? 1 : type[3] - '0';
    std::string bytes(values.size() * sizeof(float), '\0');
    std::memcpy(bytes.data(), values.data(), bytes.size());
    return add(bytes, 5126, values.size() / static_cast<size_t>(width), type);
  }
  int add_indices(const std::vector<uint16_t>& values) {
    std::string bytes(values.size() * sizeof(uint16_t), '\0');
    std::memcpy(bytes.data(), values.data(), bytes.size());
    return add(bytes, 5123, values.size(), "SCALAR");
  }

  /// Another node of the scene; returns its index.
  int add_node(const nlohmann::json& node) {
    root["nodes"].push_back(node);
    const auto index = static_cast<int>(root["nodes"].size()) - 1;
    root["scenes"][0]["nodes"].push_back(index);
    return index;
  }

  /// A key at time 0 and one at time 1 for "translation" or "rotation" of a node.
  void animate(int node, const char* path, const std::vector<float>& values) {
    const int times = add_floats({0, 1}, "SCALAR");
    root["accessors"][static_cast<size_t>(times)]["min"] = {0};
    root["accessors"][static_cast<size_t>(times)]["max"] = {1};
    const int output = add_floats(values, values.size() == 8 ? "VEC4" : "VEC3");
    nlohmann::json& animation = root["animations"][0];
    const size_t sampler = animation.contains("samplers") ? animation["samplers"].size() : 0;
    animation["samplers"].push_back({{"input", times}, {"output", output}, {"interpolation", "LINEAR"}});
    animation["channels"].push_back({{"sampler", sampler}, {"target", {{"node", node}, {"path", path}}}});
  }

  std::filesystem::path write(const std::filesystem::path& path) const {
    write_file_atomically(path, root.dump());
    return path;
  }

 private:
  int add(const std::string& bytes, int component, size_t count, const char* type) {
    root["buffers"].push_back(
        {{"byteLength", bytes.size()}, {"uri", "data:application/octet-stream;base64," + base64(bytes)}});
    const size_t buffer = root["buffers"].size() - 1;
    root["bufferViews"].push_back({{"buffer", buffer}, {"byteOffset", 0}, {"byteLength", bytes.size()}});
    root["accessors"].push_back(
        {{"bufferView", buffer}, {"componentType", component}, {"count", count}, {"type", type}});
    return static_cast<int>(root["accessors"].size()) - 1;
  }
};

}  // namespace ld
