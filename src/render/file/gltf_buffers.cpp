#include "render/file/gltf_buffers.h"

#include <map>

namespace ld {
namespace {

// glTF 2.0, section 3.6.2: https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html
uint64_t component_bytes(const GltfItem& type) {
  static const std::map<uint64_t, uint64_t> bytes = {{5120, 1}, {5121, 1}, {5122, 2},
                                                     {5123, 2}, {5125, 4}, {5126, 4}};
  const auto found = bytes.find(type.whole(0));
  if (found == bytes.end()) type.wrong("5120 to 5123, 5125 or 5126");
  return found->second;
}

uint64_t component_count(const GltfItem& type) {
  static const std::map<std::string, uint64_t> counts = {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4},
                                                         {"MAT2", 4},   {"MAT3", 9}, {"MAT4", 16}};
  const auto found = counts.find(type.text(""));
  if (found == counts.end()) type.wrong("SCALAR, VEC2 to VEC4 or MAT2 to MAT4");
  return found->second;
}

void check_view(const GltfItem& view, const GltfItem& buffers) {
  const uint64_t held = view["buffer"].in(buffers)["byteLength"].whole(0);
  if (view["byteOffset"].whole(0) + view["byteLength"].whole(0) > held)
    view.wrong(fmt::format("a place within the {} bytes of its buffer", held));
}

/// `count` elements of so many bytes from an offset in a view, which `stride` sets apart where it says so.
void check_within(const GltfItem& item, const GltfItem& views, uint64_t count, uint64_t bytes, bool strided) {
  const GltfItem view = item["bufferView"].in(views);
  const uint64_t held = view["byteLength"].whole(0), stride = strided ? view["byteStride"].whole(0) : 0;
  if (stride > 0 && stride < bytes)
    view["byteStride"].wrong(fmt::format("at least the {} bytes of an element", bytes));
  const uint64_t step = stride > 0 ? stride : bytes;
  // Neither the product nor the sum can be more than 2^81: so in doubles, whose 53 bits hold all that a file
  // can.
  const double end =
      double(item["byteOffset"].whole(0)) + double(count > 0 ? count - 1 : 0) * double(step) + double(bytes);
  if (count > 0 && end > double(held))
    item.wrong(fmt::format("{} elements of {} bytes within the {} bytes of its view", count, bytes, held));
}

void check_accessor(const GltfItem& accessor, const GltfItem& views) {
  const uint64_t count = accessor["count"].whole(0), component = component_bytes(accessor["componentType"]),
                 bytes = component * component_count(accessor["type"]);
  if (count < 1) accessor["count"].wrong("at least 1");
  if (accessor["bufferView"].there()) check_within(accessor, views, count, bytes, true);
  const GltfItem sparse = accessor["sparse"];
  if (!sparse.there()) return;
  const uint64_t replaced = sparse["count"].whole(0);
  if (replaced > count) sparse["count"].wrong(fmt::format("at most the accessor's {}", count));
  check_within(sparse["indices"], views, replaced, component_bytes(sparse["indices"]["componentType"]),
               false);
  check_within(sparse["values"], views, replaced, bytes, false);
}

/// Strips and fans have fewer lines and triangles than vertices: of too few vertices Assimp makes 2^32 - 1.
void check_primitive(const GltfItem& primitive, const GltfItem& accessors) {
  const GltfItem positions = primitive["attributes"]["POSITION"].in(accessors);
  const GltfItem counted = primitive["indices"].there() ? primitive["indices"].in(accessors) : positions;
  static const std::map<uint64_t, uint64_t> least = {{2, 2}, {3, 2}, {5, 3}, {6, 3}};
  const auto found = least.find(primitive["mode"].whole(4));
  if (found != least.end() && counted["count"].whole(0) < found->second)
    counted["count"].wrong(fmt::format("at least {}, for a strip or fan", found->second));
}

}  // namespace

void check_gltf_buffers(const GltfItem& root) {
  const GltfItem buffers = root["buffers"], views = root["bufferViews"], accessors = root["accessors"];
  for (size_t i = 0; i < views.size(); ++i) check_view(views.at(i), buffers);
  for (size_t i = 0; i < accessors.size(); ++i) check_accessor(accessors.at(i), views);
  const GltfItem meshes = root["meshes"];
  for (size_t i = 0; i < meshes.size(); ++i) {
    const GltfItem primitives = meshes.at(i)["primitives"];
    for (size_t j = 0; j < primitives.size(); ++j) check_primitive(primitives.at(j), accessors);
  }
}

}  // namespace ld
