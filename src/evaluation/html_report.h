// An evaluation as one web page: pictures to flip through with exposure, zoom and error maps, tables, cost.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "evaluation/evaluator.h"

namespace ld {

struct ReportOptions {
  size_t frames = 8;  // pictures of at most so many frames, spread evenly over the set; the tables have all
  int side = 512;     // larger pictures are cut to their middle of so many pixels a side
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

  size_t frame_count_;
  ReportOptions options_;
  std::vector<std::string> labels_;
  std::vector<Picture> pictures_;
};

}  // namespace ld
