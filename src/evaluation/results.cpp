#include "evaluation/results.h"

#include "core/file_io.h"
#include "evaluation/tables.h"

namespace ld {

ResultWriter::ResultWriter(const std::filesystem::path& folder, size_t frame_count,
                           const ReportOptions& report)
    : folder_(folder), strips_(folder, frame_count), report_(frame_count, report) {}

void ResultWriter::add(size_t frame, const std::string& name, const std::vector<LabelledPicture>& pictures) {
  strips_.add(frame, name, pictures);
  report_.add(frame, name, pictures);
}

void ResultWriter::write(const Evaluation& evaluation) const {
  write_file_atomically(folder_ / "metrics.csv", to_csv(evaluation));
  write_file_atomically(folder_ / "comparison.csv", comparison_csv(evaluation));
  write_file_atomically(folder_ / "metrics.json", to_json(evaluation).dump(2) + "\n");
  strips_.finish();
  report_.write(folder_ / "report.html", evaluation);
}

std::string results_text(const Evaluation& evaluation, bool per_frame) {
  return (per_frame ? markdown_frames(evaluation) + "\n" : "") + markdown_means(evaluation) + "\n" +
         markdown_intervals(evaluation) + "\n" + markdown_comparison(evaluation);
}

}  // namespace ld
