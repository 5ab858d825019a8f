// Writes a small report whose pictures and names tests/evaluation/report_test.py knows:
// write_test_report FILE, or write_test_report FILE sequences.
#include <any>
#include <cstdio>
#include <limits>
#include <string>

#include "evaluation/html_report.h"
#include "test_frames.h"

namespace {

/// 0.25, 0.5 and 2 everywhere, except one NaN and one very bright pixel.
ld::Image flat_picture(const ld::Frame& frame, ld::SequenceState&) {
  ld::Image image(frame.width, frame.height, 3);
  for (size_t i = 0; i < image.plane_size(); ++i) {
    image.plane(0)[i] = 0.25F;
    image.plane(1)[i] = 0.5F;
    image.plane(2)[i] = 2;
  }
  image.at(1, 0, 0) = std::numeric_limits<float>::quiet_NaN();
  image.at(0, 1, 0) = 60000;
  return image;
}

/// Two sequences of four frames of a still wall; a method that keeps its first picture, and the mean.
void write_sequences(const char* file) {
  const ld::FrameSet frames = {8, [](size_t i) {
                                 return ld::still_frame("frame_" + std::to_string(i), 48, 32,
                                                        static_cast<int64_t>(i / 4),
                                                        static_cast<int64_t>(i % 4));
                               }};
  ld::ReportOptions options;
  options.sequences = {{0, 1, 2, 3}, {4, 5, 6, 7}};
  ld::ReportWriter report(frames.count, options);
  ld::EvaluatorOptions evaluator;
  evaluator.sequences = true;
  evaluator.on_pictures = [&](size_t f, const std::string& name,
                              const std::vector<ld::LabelledPicture>& pictures) {
    report.add(f, name, pictures);
  };
  const ld::Method frozen{"<img src=x onerror=alert(1)>",
                          [](const ld::Frame& frame, ld::SequenceState& state) {
                            if (!state.memory.has_value()) state.memory = ld::mean_radiance(frame);
                            return std::any_cast<ld::Image>(state.memory);
                          }};
  std::optional<ld::Evaluation> evaluation =
      ld::evaluate(frames, {frozen, {"mean", ld::mean_of_samples}}, evaluator);
  evaluation->data = "sequences";
  evaluation->split = "test";
  report.write(file, *evaluation);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 3 && std::string(argv[2]) == "sequences") {
    write_sequences(argv[1]);
    return 0;
  }
  if (argc != 2) {
    std::fprintf(stderr, "usage: write_test_report FILE [sequences]\n");
    return 2;
  }
  // The last frame is of another size than the others.
  const ld::FrameSet frames = {
      7, [](size_t i) {
        const std::string name = i == 1 ? "</script><b>bold</b>" : "frame_" + std::to_string(i);
        ld::EvaluationFrame frame = ld::noisy_frame(name, i == 6 ? 40 : 48, 32, 2, static_cast<int>(i));
        frame.floor = {{"relmse", 1.5e-3}, {"smape", 0.0625}, {"ssim", 0.75}, {"psnr", 43.5}};
        return frame;
      }};
  ld::Method flat{"<img src=x onerror=alert(1)>", flat_picture};
  flat.cost = {17'280'000, 1.01e6};
  ld::ReportOptions options;
  options.frames = 7;
  ld::ReportWriter report(frames.count, options);
  ld::EvaluatorOptions evaluator;
  evaluator.on_pictures = [&](size_t f, const std::string& name,
                              const std::vector<ld::LabelledPicture>& pictures) {
    report.add(f, name, pictures);
  };
  std::optional<ld::Evaluation> evaluation =
      ld::evaluate(frames, {flat, {"mean", ld::mean_of_samples}}, evaluator);
  if (!evaluation) return 1;
  evaluation->data = "data & <more>";
  evaluation->split = "test";
  evaluation->baseline = "mean";
  report.write(argv[1], *evaluation);
  return 0;
}
