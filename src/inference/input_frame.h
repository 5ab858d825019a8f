// Frames to denoise, from our own files or, through a preset, from other renderers'.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "frame/frame.h"
#include "import/mapping.h"
#include "import/view_camera.h"
#include "inference/picture_file.h"

namespace ld {

/// How files are read: those of other renderers (docs/import.md), or without a mapping frames.
struct RenderInput {
  std::optional<ImportMapping> mapping;
  std::optional<ViewCamera> camera;
  std::string preset = {};  // where the mapping is one
  bool allow_identical = false;
  std::vector<std::string> also = {};  // patterns of light parts (choose_names in frame/frame_file.h)
};

struct InputFrame {
  Frame frame;  // sanitised, with a depth scale
  Faults faults;
  std::vector<std::string> notes;  // what users should know, a line each
  std::vector<std::string> taken;  // of renders: what was taken for what (ImportedFrame)
  Original original;               // for write_picture
};

/// Reads one frame with the features that a network needs, and of its samples the first `samples`; 0: all.
/// Without a mapping there is one file. Features that the network can do without and that would need a camera
/// are left out where there is none. Throws Error as read_frame() and import_frame() say, for features or
/// samples that the renders lack, and where no sample of any pixel is finite. `threads` decode frames; 0:
/// default_threads().
InputFrame read_input(const std::vector<std::filesystem::path>& files, const RenderInput& render,
                      const std::vector<std::string>& features, int samples = 0, int threads = 0);

/// Width and height of the frame that read_input() gives, from the files' headers.
std::pair<int, int> input_size(const std::vector<std::filesystem::path>& files, const RenderInput& render);

/// Red, green and blue, and alpha [1, H, W] where that is not empty.
Image with_alpha(const Image& picture, const Image& alpha);

}  // namespace ld
