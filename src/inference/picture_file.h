// Denoised pictures as OpenEXR files that keep what their inputs said.
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "frame/frame.h"

namespace ld {

/// The input that a picture was made of. All that it holds besides the samples is kept.
struct Original {
  std::filesystem::path file;
  Windows windows;  // of the samples, and so of the picture
  int part = 0;     // whose attributes the picture has, and whose channels stand beside it
  std::set<std::pair<int, std::string>> replaced;  // part and channel: those that the picture stands for
  std::set<int> samples;                           // parts that are samples: left out
  /// Whether the picture is the first part; else it stays behind those before `part`, which are the hero's.
  bool leads = true;
  std::string prefix = {};  // of the picture's channels, where other views' lie in one part with them
};

/// A further part of the file, for looking.
struct PicturePart {
  std::string name;
  Image image;
  std::vector<std::string> channels;  // a name for each plane
  int x = 0, y = 0;                   // its upper left pixel, from that of the picture
};

/// Images by the names of the layers that their channels are in; the first is the picture, which is in none.
using PictureLayers = std::vector<std::pair<std::string, Image>>;

/// Writes R, G, B of all layers (and A where one has a fourth channel), behind the original's prefix, at the
/// windows of the samples; beside them, bit for bit, the original's channels in half, float or integers,
/// those of its other parts in parts of their own; and its attributes, but for those that speak of samples.
/// Channels of `part` are placed by its data window, 0 outside; of the picture's names they make way. Half
/// floats, in which colours beyond their range become darker but keep their hue, or full ones; ZIP, no time
/// stamps; atomic. `by` goes into the attribute of former_result.h. Returns what users should know, a line
/// each: what could not be kept. Throws Error.
std::vector<std::string> write_picture(const std::filesystem::path& path, const PictureLayers& layers,
                                       const Original& original, const std::vector<PicturePart>& further,
                                       bool full_float, const std::string& by, int threads);

}  // namespace ld
