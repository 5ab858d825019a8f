// What ld_eval leaves behind, and what it prints.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "evaluation/evaluator.h"
#include "evaluation/html_report.h"
#include "evaluation/strips.h"

namespace ld {

/// Films of the sequences, each of the strips of its frames.
struct MovieOptions {
  std::string format;  // "mp4", "webm", or "": none
  double frames_a_second = 12;
};

/// Collects pictures while the frames are evaluated, then writes FOLDER/metrics.csv, comparison.csv,
/// metrics.json, comparison.png, strips/ and report.html; of sequences besides sequences.csv,
/// sequence_comparison.csv and a figure sequence_*.svg for each curve, and movies/ (sequence/movie_file.h).
class ResultWriter {
 public:
  ResultWriter(const std::filesystem::path& folder, size_t frame_count, const ReportOptions& report);

  /// For EvaluatorOptions::on_pictures.
  void add(size_t frame, const std::string& name, const std::vector<LabelledPicture>& pictures);
  /// Writes all files. Throws Error when one cannot be written.
  void write(const Evaluation& evaluation, const FrameSet& frames, const MovieOptions& movies) const;

 private:
  std::filesystem::path folder_;
  StripWriter strips_;
  ReportWriter report_;
};

/// The tables as they are printed: means with formulas, intervals, comparison; with `per_frame` the frames
/// first.
std::string results_text(const Evaluation& evaluation, bool per_frame);

}  // namespace ld
