// What ld_eval leaves behind, and what it prints.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "evaluation/evaluator.h"
#include "evaluation/html_report.h"
#include "evaluation/strips.h"

namespace ld {

/// Collects pictures while the frames are evaluated, then writes FOLDER/metrics.csv, comparison.csv,
/// metrics.json, comparison.png, strips/ and report.html.
class ResultWriter {
 public:
  ResultWriter(const std::filesystem::path& folder, size_t frame_count, const ReportOptions& report);

  /// For EvaluatorOptions::on_pictures.
  void add(size_t frame, const std::string& name, const std::vector<LabelledPicture>& pictures);
  /// Writes all files. Throws Error when one cannot be written.
  void write(const Evaluation& evaluation) const;

 private:
  std::filesystem::path folder_;
  StripWriter strips_;
  ReportWriter report_;
};

/// The tables as they are printed: means with formulas, intervals, comparison; with `per_frame` the frames
/// first.
std::string results_text(const Evaluation& evaluation, bool per_frame);

}  // namespace ld
