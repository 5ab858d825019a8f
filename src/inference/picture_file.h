// Denoised pictures as OpenEXR files that keep what their inputs said.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "frame/frame.h"

namespace ld {

/// The input that a picture was made of.
struct Original {
  std::filesystem::path file;
  int part = 0;                       // whose channels, windows and attributes are kept
  std::vector<std::string> replaced;  // its channels that the picture stands for
  bool keep_channels = true;          // the others
};

/// A further part of the file, for looking.
struct PicturePart {
  std::string name;
  Image image;
  std::vector<std::string> channels;  // a name for each plane
  int x = 0, y = 0;                   // its upper left pixel, from that of the picture
};

/// Writes R, G, B (and A where the picture has a fourth channel), with the channels of the original as they
/// are (half, float or integers), its windows and its attributes, but for those that speak of samples. Half
/// floats, or full ones; ZIP, no time stamps; atomic. `by` goes into the attribute ldDenoisedBy. Channels of
/// an original whose part is not of the picture's size are left out. Throws Error.
void write_picture(const std::filesystem::path& path, const Image& picture, const Original& original,
                   const std::vector<PicturePart>& further, bool full_float, const std::string& by);

}  // namespace ld
