// Files of another renderer to a frame of ours, and into a data set.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "frame/frame.h"
#include "import/convert.h"
#include "import/mapping.h"

namespace ld {

struct ImportedFrame {
  Frame frame;  // sanitised
  Faults faults;
  ConversionCounts counts;
  std::vector<std::string> repeated;  // features that are the same in all samples (per_sample: false)
  std::vector<std::string> notes;     // what users should know, a line each
  std::string view;                   // that was read; empty where the files have none
  std::string view_text;              // of which ones it is, for users; empty where there is one at most
  std::vector<std::string> taken;     // "normal: Ns.X, Ns.Y, Ns.Z" of the first file, a line for each feature
  std::vector<std::string> unused;    // channels of the first file that no feature took, with their parts
};

/// The samples of all files, in the order of the files and in each of their numbers. `camera` may be empty;
/// then the files' attribute worldToCamera serves. Features that the files do not hold are not in the frame.
/// Channels are placed by the data windows of their parts (sample_window.h). Throws Error: different display
/// windows, features that only some files hold, two samples with the same noise (unless `allow_identical`),
/// pictures that were denoised already, no sample that is finite, and what plan_samples() and Converter say.
/// Of the light parts that the mapping finds, those that a pattern of `also` fits are in the frame, too
/// (choose_names in frame/frame_file.h).
ImportedFrame import_frame(const std::vector<std::filesystem::path>& files, const ImportMapping& mapping,
                           const std::optional<ViewCamera>& camera, bool allow_identical,
                           const std::vector<std::string>& also = {});

/// Throws Error where no sample of any pixel counts: there is nothing to denoise or to learn from.
void require_valid_sample(const Frame& frame, const std::string& file);

struct ImportedPicture {
  Image image;  // R, G, B and, where the file has it, A
  Windows windows;
};

/// Radiance and alpha of a converged picture: of the mapping's view, or of a file that has no views. Throws
/// Error where no pixel is finite.
ImportedPicture import_picture(const std::filesystem::path& file, const ImportMapping& mapping);

struct DataSetPlace {
  std::filesystem::path folder;
  std::string name, split;
  std::optional<int64_t> sequence = {}, position = {};
};

/// Throws Error for a name or split that cannot be, and for a folder of rendered frames; UsageError where
/// another frame has the place in the sequence. For calling before work is done.
void check_place(const DataSetPlace& place);

/// Writes frame and reference and adds them to the folder's manifest; replaces a frame of this name. Throws
/// Error when they are not of one size and window or show the same noise.
void add_to_data_set(const DataSetPlace& place, const Frame& frame, const ImportedPicture& reference);

}  // namespace ld
