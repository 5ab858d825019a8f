#include "evaluation/results.h"

#include "core/file_io.h"
#include "evaluation/sequence_evaluation.h"
#include "evaluation/tables.h"
#include "sequence/movie_file.h"

namespace ld {

ResultWriter::ResultWriter(const std::filesystem::path& folder, size_t frame_count,
                           const ReportOptions& report)
    : folder_(folder), strips_(folder, frame_count), report_(frame_count, report) {}

void ResultWriter::add(size_t frame, const std::string& name, const std::vector<LabelledPicture>& pictures) {
  strips_.add(frame, name, pictures);
  report_.add(frame, name, pictures);
}

void ResultWriter::write(const Evaluation& evaluation, const FrameSet& frames,
                         const MovieOptions& movies) const {
  write_file_atomically(folder_ / "metrics.csv", to_csv(evaluation));
  write_file_atomically(folder_ / "comparison.csv", comparison_csv(evaluation));
  write_file_atomically(folder_ / "metrics.json", to_json(evaluation).dump(2) + "\n");
  strips_.finish();
  report_.write(folder_ / "report.html", evaluation);
  if (evaluation.sequences) {
    const Evaluation sequences = sequence_scores(evaluation);
    write_file_atomically(folder_ / "sequences.csv", to_csv(sequences));
    write_file_atomically(folder_ / "sequence_comparison.csv", comparison_csv(sequences));
    for (const SequenceCurve& curve : evaluation.sequences->curves)
      write_file_atomically(folder_ / (curve.name + ".svg"), to_svg(curve.plot));
  }
  if (movies.format.empty()) return;
  for (const std::vector<size_t>& sequence : frames.sequences)
    write_movie(folder_ / "movies" / (frames.names[sequence.front()] + "." + movies.format),
                movies.frames_a_second, sequence.size(),
                [&](size_t i) { return read_shown_picture(strips_.path_of(frames.names[sequence[i]])); });
}

std::string results_text(const Evaluation& evaluation, bool per_frame) {
  return (per_frame ? markdown_frames(evaluation) + "\n" : "") + markdown_means(evaluation) + "\n" +
         markdown_intervals(evaluation) + "\n" + markdown_comparison(evaluation) +
         (evaluation.sequences
              ? "\nOver whole sequences:\n\n" + results_text(sequence_scores(evaluation), per_frame)
              : "");
}

}  // namespace ld
