#include "frame/frame_attributes.h"

#include <ImfDoubleAttribute.h>
#include <ImfFloatAttribute.h>
#include <ImfIntAttribute.h>
#include <ImfMatrixAttribute.h>
#include <ImfStringAttribute.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "core/error.h"

namespace ld {
namespace {

const std::string kFloor = "ldFloor.";

void write_matrix(Imf::Header& header, const char* name, const std::optional<Matrix4>& matrix) {
  if (!matrix) return;
  Imath::M44f value;
  std::copy(matrix->begin(), matrix->end(), value.getValue());
  header.insert(name, Imf::M44fAttribute(value));
}

void read_text(const Imf::Header& header, const char* name, std::string& value) {
  if (const auto* attribute = header.findTypedAttribute<Imf::StringAttribute>(name))
    value = attribute->value();
}

/// EXR has no integers of 64 bits: they are decimal text. An int attribute will do as well.
template <class Integer>
void read_integer(const Imf::Header& header, const std::string& path, const char* name, Integer& value) {
  if (header.find(name) == header.end()) return;
  std::string text;
  if (const auto* number = header.findTypedAttribute<Imf::IntAttribute>(name))
    text = std::to_string(number->value());
  read_text(header, name, text);
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || stop != text.data() + text.size() || text.empty() || value < 0)
    fail("{}: the attribute '{}' is '{}'; expected a whole number of at least 0, as an int or as text", path,
         name, text);
}

}  // namespace

std::optional<Matrix4> read_matrix(const Imf::Header& header, const char* name) {
  const auto* attribute = header.findTypedAttribute<Imf::M44fAttribute>(name);
  if (attribute == nullptr) return std::nullopt;
  Matrix4 matrix;
  std::copy_n(attribute->value().getValue(), matrix.size(), matrix.begin());
  if (!std::all_of(matrix.begin(), matrix.end(), [](float value) { return std::isfinite(value); }))
    return std::nullopt;
  return matrix;
}

void write_attributes(Imf::Header& header, const FrameInfo& info, int spp) {
  header.insert("ldSchemaVersion", Imf::IntAttribute(kSchemaVersion));
  header.insert("ldSpp", Imf::IntAttribute(spp));
  header.insert("ldSeed", Imf::StringAttribute(std::to_string(info.seed)));
  header.insert("ldFrame", Imf::StringAttribute(std::to_string(info.frame)));
  header.insert("ldClamped", Imf::StringAttribute(std::to_string(info.clamped)));
  header.insert("ldDepthScale", Imf::FloatAttribute(info.depth_scale));
  if (!info.generator.empty()) header.insert("ldGenerator", Imf::StringAttribute(info.generator));
  if (!info.scene.empty()) header.insert("ldScene", Imf::StringAttribute(info.scene));
  if (!info.camera.empty()) header.insert("ldCamera", Imf::StringAttribute(info.camera));
  if (info.cut) header.insert("ldCut", Imf::IntAttribute(1));
  write_matrix(header, kWorldToCamera, info.world_to_camera);
  write_matrix(header, kWorldToNdc, info.world_to_ndc);
}

FrameInfo read_attributes(const Imf::Header& header, const std::string& path, int& spp) {
  int64_t version = kSchemaVersion;
  read_integer(header, path, "ldSchemaVersion", version);
  if (version > kSchemaVersion)
    fail("{}: written with feature schema {}; this program knows schemas up to {}; use a newer version of it",
         path, version, kSchemaVersion);
  spp = -1;
  if (header.find("ldSpp") != header.end()) read_integer(header, path, "ldSpp", spp);
  FrameInfo info;
  read_integer(header, path, "ldSeed", info.seed);
  read_integer(header, path, "ldFrame", info.frame);
  read_integer(header, path, "ldClamped", info.clamped);
  read_text(header, "ldGenerator", info.generator);
  read_text(header, "ldScene", info.scene);
  read_text(header, "ldCamera", info.camera);
  int64_t cut = 0;
  read_integer(header, path, "ldCut", cut);
  info.cut = cut != 0;
  info.world_to_camera = read_matrix(header, kWorldToCamera);
  info.world_to_ndc = read_matrix(header, kWorldToNdc);
  if (header.find("ldDepthScale") != header.end()) {
    const auto* attribute = header.findTypedAttribute<Imf::FloatAttribute>("ldDepthScale");
    if (attribute == nullptr || !std::isfinite(attribute->value()) || attribute->value() < 0)
      fail("{}: the attribute 'ldDepthScale' is not a finite float of at least 0; correct or remove it",
           path);
    info.depth_scale = attribute->value();
  }
  return info;
}

void write_floor(Imf::Header& header, const ReferenceFloor& floor) {
  for (const auto& [metric, score] : floor) header.insert(kFloor + metric, Imf::DoubleAttribute(score));
}

ReferenceFloor read_floor(const Imf::Header& header, const std::string& path) {
  ReferenceFloor floor;
  for (auto attribute = header.begin(); attribute != header.end(); ++attribute) {
    const std::string name = attribute.name();
    if (name.rfind(kFloor, 0) != 0) continue;
    double score = std::numeric_limits<double>::quiet_NaN();
    if (const auto* value = dynamic_cast<const Imf::DoubleAttribute*>(&attribute.attribute()))
      score = value->value();
    if (const auto* value = dynamic_cast<const Imf::FloatAttribute*>(&attribute.attribute()))
      score = value->value();
    if (std::isnan(score))
      fail("{}: the attribute '{}' is not a number (double or float); correct or remove it", path, name);
    floor[name.substr(kFloor.size())] = score;
  }
  return floor;
}

Imf::Header header_with(int width, int height, const Windows& windows) {
  const Imath::V2i corner(windows.x, windows.y);
  const Imath::Box2i data(corner, corner + Imath::V2i(width - 1, height - 1));
  const Imath::Box2i display({windows.display_left, windows.display_top},
                             {windows.display_right, windows.display_bottom});
  return {windows.has_display() ? display : data, data};
}

Windows windows_of(const Imf::Header& header) {
  const Imath::Box2i &data = header.dataWindow(), &display = header.displayWindow();
  Windows windows;
  windows.x = data.min.x;
  windows.y = data.min.y;
  if (display != data) {
    windows.display_left = display.min.x;
    windows.display_top = display.min.y;
    windows.display_right = display.max.x;
    windows.display_bottom = display.max.y;
  }
  return windows;
}

}  // namespace ld
