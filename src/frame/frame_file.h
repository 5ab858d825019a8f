// Frames and images on disk: multi-part OpenEXR, half float, tiled, ZIP (docs/data_format.md).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "frame/frame.h"

namespace ld {

/// What a frame's header says, read without its pixels.
struct FrameHeader {
  int width = 0, height = 0;
  int spp = 0;                        // number of sample parts; 0 for a file with means only
  std::vector<std::string> features;  // features of the schema that every sample part holds
  std::vector<std::string>
      derivable;         // features that read_frame() can make beside (frame/derived_features.h)
  std::string misnamed;  // where there are none: a part that looks like one, such as "s0"
  bool alpha = false;    // every sample part has a channel A
  /// Layers NAME of channels NAME.R, NAME.G and NAME.B that every sample part has beside the features: parts
  /// of the light, as far as anybody can tell.
  std::vector<std::string> layers;
  FrameInfo info;
};

/// Those of the names, in their order, that one of the patterns fits; `*`, `?` and `[...]` as in a shell.
/// Throws Error, naming what `where` has, for a pattern that fits none.
std::vector<std::string> choose_names(const std::vector<std::string>& names,
                                      const std::vector<std::string>& patterns, const std::string& where);

/// The number in a part's name "s000", "s001", ..., "s1000"; -1 for any other name.
int sample_number(const std::string& part_name);

/// What to say of a file without samples one of whose parts looks like one.
std::string misnamed_text(const FrameHeader& header);

/// Throws Error: missing file, not an EXR, truncated, absurd size, unequal parts, newer schema version.
FrameHeader read_frame_header(const std::filesystem::path& path);

/// Reads the samples with at least the `required` features (others that are missing become 0) and sanitises
/// them; `faults` receives what was found. frame.features are all that the file holds, and those of the
/// required that follow from what lies beside it (frame/derived_features.h). info.depth_scale is computed
/// where the file has none. Throws Error as above and for a missing feature (naming part and channel), for a
/// file without samples and for one with fewer than `samples`, of which only the first so many are read (0:
/// all). Of the layers, those that a pattern of `also` fits become its light parts (choose_names). Nothing
/// depends on the number of threads.
Frame read_frame(const std::filesystem::path& path, const std::vector<std::string>& required, Faults& faults,
                 int samples = 0, int threads = 1, const std::vector<std::string>& also = {});

/// Keeps the first `samples` samples of a frame that was read from `file`; 0: all. Throws Error when it has
/// fewer.
void keep_first_samples(Frame& frame, int samples, const std::filesystem::path& file);

/// Writes part `mean` and parts s000, s001, ... with the frame's features, alpha and light parts, and the
/// info as attributes; atomic. Radiance beyond half's range is clamped and the count of clamped channels
/// returned; light parts become darker with it. Masked samples are written as NaN radiance, so that they are
/// masked again on reading. The same frame gives the same bytes. Throws Error when the frame cannot be
/// written or holds no radiance, UsageError for an unknown feature.
int64_t write_frame(const std::filesystem::path& path, const Frame& frame);

enum class PictureFormat { exr, png };

/// By the extension, in capitals or not. Throws UsageError for another one: to be called before any work.
PictureFormat picture_format(const std::filesystem::path& path);

/// An image of 1 (Y), 3 (R, G, B) or, in ".exr", 4 channels (and A): ".exr" holds linear half floats, ".png"
/// 8 bits of the tone map (eq. 7 of [MH20]) and neither windows nor floor; atomic. Throws UsageError for
/// another extension.
void write_image(const std::filesystem::path& path, const Image& image, const Windows& windows = {},
                 const ReferenceFloor& floor = {});

/// The bytes of such a PNG file; `path` is what complaints name.
std::string png_bytes(const std::filesystem::path& path, const Image& image);

/// Sets values that are NaN, infinite or negative to 0 and counts them.
int64_t mend_image(Image& image);

/// Reads R, G, B of an EXR's picture (picture_part). `bad_values`, when given, receives mend_image's count.
/// Throws Error.
Image read_image(const std::filesystem::path& path, int64_t* bad_values = nullptr);

}  // namespace ld
