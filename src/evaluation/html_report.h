// An evaluation as one web page: pictures to flip through with exposure, zoom and error maps, tables, cost.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "evaluation/evaluator.h"

namespace ld {

struct ReportOptions {
  size_t frames = 8;  // pictures of at most so many frames, spread evenly over the set; the tables have all
  int side = 512;     // larger pictures are cut to their middle of so many pixels a side
  // Sequences that play: those of FrameSet::sequences, at most so many, each at most so many frames from its
  // start; their pictures, of 8 bits, are cut likewise.
  std::vector<std::vector<size_t>> sequences = {};
  size_t most_sequences = 2, most_frames = 32;
  int sequence_side = 256;
};

/// Collects the pictures while the frames are evaluated. The page needs no other file and no network (its
/// Content-Security-Policy forbids both); names are data in it, never HTML.
class ReportWriter {
 public:
  ReportWriter(size_t frame_count, const ReportOptions& options);

  /// For EvaluatorOptions::on_pictures.
  void add(size_t frame, const std::string& name, const std::vector<LabelledPicture>& pictures);
  /// Writes the page, atomically. Throws Error when that fails.
  void write(const std::filesystem::path& path, const Evaluation& evaluation) const;

 private:
  struct Picture {
    size_t index;  // of the frame
    std::string frame;
    int width, height, full_width, full_height;
    std::vector<std::string> encoded;  // one for each label
  };

  struct Clip {
    int width = 0, height = 0;
    std::vector<std::string> frames;                // names
    std::vector<std::vector<std::string>> encoded;  // for each frame one for each label
  };

  void add_to_clips(size_t frame, const std::string& name, const std::vector<LabelledPicture>& pictures);

  size_t frame_count_;
  ReportOptions options_;
  std::map<size_t, Clip> clips_;  // by the number of the sequence
  std::vector<std::string> labels_;
  std::vector<Picture> pictures_;
};

}  // namespace ld
