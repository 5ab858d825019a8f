// Writes a small report whose pictures and names tests/evaluation/report_test.py knows:
// write_test_report FILE.
#include <cstdio>
#include <limits>

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

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: write_test_report FILE\n");
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
