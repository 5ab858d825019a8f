// A file as Blender Cycles writes it: passes of light that surfaces send, divided by their colours, and light
// groups; they add up to Combined.
#pragma once

#include <map>

#include "core/random.h"
#include "tests/support/exr_parts.h"

namespace ld {

struct CyclesNames {
  std::string direct, indirect, colour;
};

/// One sample of `width` x `height` pixels in full floats. `in_parts`: a part for each pass with the names of
/// Blender 5, else those of Blender 4.
inline void write_cycles_passes(const std::filesystem::path& path, int width, int height, uint32_t seed,
                                bool in_parts = false) {
  RandomStream random(seed, RandomPurpose::test);
  const auto pixels = size_t(width) * size_t(height);
  std::map<std::string, std::vector<float>> planes;
  const auto plane = [&](const std::string& name) -> std::vector<float>& {
    std::vector<float>& values = planes["ViewLayer." + name];
    values.resize(pixels);
    return values;
  };
  std::vector<CyclesNames> surfaces;
  for (const std::string surface : {"Diffuse", "Glossy", "Transmission"}) {
    const size_t letters = surface[0] == 'D' ? 4 : 5;  // Diff, Gloss, Trans
    const std::string pass = in_parts ? surface + " " : surface.substr(0, letters);
    surfaces.push_back({pass + (in_parts ? "Direct" : "Dir"), pass + (in_parts ? "Indirect" : "Ind"),
                        pass + (in_parts ? "Color" : "Col")});
  }
  const std::vector<std::string> beside_surfaces = {in_parts ? "Emission" : "Emit",
                                                    in_parts ? "Environment" : "Env"};
  for (const char c : {'R', 'G', 'B'}) {
    const std::string channel = std::string(".") + c;
    for (size_t p = 0; p < pixels; ++p) {
      double sum = 0;
      for (const CyclesNames& surface : surfaces) {
        const float direct = random.uniform(0.0F, 4.0F), indirect = random.uniform(0.0F, 1.0F),
                    colour = random.uniform(0.0F, 1.0F) < 0.3F ? 0 : random.uniform(0.0F, 1.0F);
        plane(surface.direct + channel)[p] = direct;
        plane(surface.indirect + channel)[p] = indirect;
        plane(surface.colour + channel)[p] = colour;
        sum += (double(direct) + double(indirect)) * double(colour);
      }
      for (const std::string& name : beside_surfaces) {
        const float value = random.uniform(0.0F, 1.0F) < 0.9F ? 0 : random.uniform(0.0F, 20.0F);
        plane(name + channel)[p] = value;
        sum += double(value);
      }
      plane("Combined" + channel)[p] = float(sum);
      const float key = float(sum) * random.uniform(0.0F, 1.0F);
      plane("Combined_key" + channel)[p] = key;
      plane("Combined_rim light" + channel)[p] = float(sum - double(key));
    }
  }
  for (size_t p = 0; p < pixels; ++p) {
    plane("Combined.A")[p] = random.uniform(0.0F, 1.0F) < 0.1F ? 0.0F : 1.0F;
    plane("Depth.Z")[p] = 2 + random.uniform(0.0F, 1.0F);
  }
  const Imath::Box2i window({0, 0}, {width - 1, height - 1});
  std::map<std::string, TestPart> parts;
  for (const auto& [name, values] : planes) {
    const std::string part = in_parts ? name.substr(0, name.rfind('.')) : "";
    TestPart& held = parts[part];
    held.name = part;
    held.window = window;
    held.channels.emplace_back(
        name, [&plane_values = values, width](int x, int y) { return plane_values[size_t(y * width + x)]; });
  }
  std::vector<TestPart> list;
  for (const auto& [name, part] : parts) list.push_back(part);
  write_exr_parts(path, window, list);
}

}  // namespace ld
