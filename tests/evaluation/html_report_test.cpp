// The report as a file; tests/evaluation/report_test.py opens it in a browser.
#include "evaluation/html_report.h"

#include <gtest/gtest.h>

#include <OpenImageIO/strutil.h>
#include <half.h>
#include <zlib.h>

#include <cmath>
#include <limits>

#include "core/file_io.h"
#include "evaluation/picture_codec.h"
#include "evaluation/strips.h"
#include "test_frames.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

/// What decode.js does, for a picture whose size is known.
std::vector<uint16_t> decoded(const std::string& text, int width, int height) {
  std::string packed;
  static const std::string kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  unsigned bits = 0;
  int held = 0;
  for (const char c : text) {
    if (c == '=') break;
    bits = (bits << 6) | unsigned(kDigits.find(c));
    held += 6;
    if (held < 8) continue;
    held -= 8;
    packed += char((bits >> held) & 0xffU);
  }
  const size_t count = size_t(3 * width * height);
  std::vector<uint8_t> bytes(2 * count);
  uLongf size = uLongf(bytes.size());
  EXPECT_EQ(
      uncompress(bytes.data(), &size, reinterpret_cast<const Bytef*>(packed.data()), uLong(packed.size())),
      Z_OK);
  std::vector<uint16_t> halfs(count);
  for (size_t i = 0; i < count; ++i) {
    const unsigned difference = unsigned(bytes[i]) << 8 | bytes[count + i];
    halfs[i] = uint16_t(difference + (i % size_t(width) == 0 ? 0U : halfs[i - 1]));
  }
  return halfs;
}

TEST(PictureCodec, KeepsEveryHalfFloatAndCutsWhatIsBeyond) {
  Image image(5, 4, 3);
  RandomStream stream(2, RandomPurpose::test);
  for (float& x : image.pixels) x = half(float(std::exp(4 * stream.normal())));
  const float odd[] = {0.0F,  -0.0F, -3.5F, 6e-8F, 65504.0F, 1e9F, std::numeric_limits<float>::infinity(),
                       -1e30F};
  std::copy(std::begin(odd), std::end(odd), image.pixels.begin() + 7);
  image.pixels[20] = std::numeric_limits<float>::quiet_NaN();
  const std::vector<uint16_t> halfs = decoded(encode_picture(image), 5, 4);
  for (size_t i = 0; i < halfs.size(); ++i) {
    half value;
    value.setBits(halfs[i]);
    const float x = image.pixels[i];
    if (std::isnan(x))
      EXPECT_TRUE(value.isNan());
    else if (std::isinf(x))
      EXPECT_TRUE(value.isInfinity());
    else
      EXPECT_EQ(value.bits(), half(std::clamp(x, -65504.0F, 65504.0F)).bits()) << i << ": " << x;
  }
}

TEST(HtmlReport, FramesAreChosenEvenly) {
  std::vector<size_t> chosen;
  for (size_t f = 0; f < 10; ++f)
    if (is_evenly_chosen(f, 10, 4)) chosen.push_back(f);
  EXPECT_EQ(chosen, (std::vector<size_t>{0, 2, 5, 7}));
  EXPECT_TRUE(is_evenly_chosen(1, 2, 8));
  EXPECT_FALSE(is_evenly_chosen(0, 2, 0));
}

/// Evaluates frames of this size and writes the report; returns its bytes.
std::string report_of(size_t frame_count, int width, int height, const std::vector<Method>& methods,
                      const ReportOptions& options, const std::string& prefix = "frame_") {
  const FrameSet frames = {frame_count, [&](size_t i) {
                             return noisy_frame(prefix + std::to_string(i), width, height, 2, int(i));
                           }};
  ReportWriter report(frame_count, options);
  EvaluatorOptions evaluator;
  evaluator.on_pictures = [&](size_t f, const std::string& name,
                              const std::vector<LabelledPicture>& pictures) {
    report.add(f, name, pictures);
  };
  std::optional<Evaluation> evaluation = evaluate(frames, methods, evaluator);
  for (MethodScores& method : evaluation->methods)
    for (FrameScores& frame : method.frames) frame.seconds.reset();
  evaluation->data = "data/<set>";
  evaluation->split = "test";
  const TemporaryFolder folder;
  report.write(folder / "report.html", *evaluation);
  return read_file(folder / "report.html");
}

size_t count_of(const std::string& text, const std::string& part) {
  size_t count = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST(HtmlReport, IsOneFileThatForbidsItselfTheNetwork) {
  const std::string page = report_of(3, 20, 16, {{"mean", mean_of_samples}}, {});
  EXPECT_NE(page.find("default-src 'none'"), std::string::npos);
  for (const std::string& outside :
       std::vector<std::string>{"http://", "https://", "src=", "@import", "url("}) {
    size_t expected = outside == "http://" ? 1U : 0U;  // the name space of SVG, which nobody fetches
    EXPECT_EQ(count_of(page, outside), expected) << outside;
  }
  EXPECT_EQ(count_of(page, "id=\"picture-"), 3U * 4);
  EXPECT_EQ(page.find("{{"), std::string::npos);
  EXPECT_EQ(page, report_of(3, 20, 16, {{"mean", mean_of_samples}}, {})) << "the same bytes again";
}

TEST(HtmlReport, NamesAreDataAndNeverElements) {
  const std::string page =
      report_of(1, 8, 8, {{"</script><img src=x>", mean_of_samples}}, {}, "<!--<script>\xff");
  EXPECT_EQ(page.find("<img"), std::string::npos);
  EXPECT_EQ(page.find("<!--"), std::string::npos);
  EXPECT_EQ(page.find("<set>"), std::string::npos);
  EXPECT_NE(page.find("\\u003c/script>\\u003cimg src=x>"), std::string::npos);
  EXPECT_EQ(count_of(page, "<script"), count_of(page, "</script>"));
}

TEST(HtmlReport, SequencesPlayFromTheirStart) {
  const FrameSet frames = {
      5, [](size_t i) { return still_frame("f" + std::to_string(i), 20, 18, i < 3 ? 0 : 1, int64_t(i)); }};
  ReportOptions options;
  options.sequences = {{0, 1, 2}, {3, 4}};
  options.most_frames = 2;
  options.sequence_side = 10;
  ReportWriter report(frames.count, options);
  EvaluatorOptions evaluator;
  evaluator.sequences = true;
  evaluator.on_pictures = [&](size_t f, const std::string& name,
                              const std::vector<LabelledPicture>& pictures) {
    report.add(f, name, pictures);
  };
  const std::optional<Evaluation> evaluation = evaluate(frames, {{"mean", mean_of_samples}}, evaluator);
  const TemporaryFolder folder;
  report.write(folder / "report.html", *evaluation);
  const std::string page = read_file(folder / "report.html");
  EXPECT_EQ(count_of(page, "id=\"clip-"), 2U * 2 * 4 + 6) << "and the page's own elements";
  EXPECT_NE(page.find("{\"width\":10,\"height\":10,\"frames\":[\"f0\",\"f1\"]}"), std::string::npos);
  EXPECT_NE(page.find("\"unit\":\"sequence\""), std::string::npos);
}

TEST(HtmlReport, LimitsFramesAndSize) {
  ReportOptions options;
  options.frames = 2;
  options.side = 10;
  const std::string page = report_of(5, 24, 18, {}, options);
  EXPECT_EQ(count_of(page, "id=\"picture-"), 2U * 3);
  EXPECT_NE(page.find("\"width\":10,\"height\":10,\"full_width\":24,\"full_height\":18"), std::string::npos);
  options.frames = 0;
  EXPECT_EQ(count_of(report_of(2, 8, 8, {}, options), "id=\"picture-"), 0U);
}

TEST(HtmlReport, EightFramesOfFiveMethodsStayBelowTenMegabytes) {
  const Image noise = mean_radiance(noisy_frame("", 128, 128, 2, 1).frame);  // packs worst
  EXPECT_LT(encode_picture(noise).size() * 8 * (5 + 3), 9'000'000U);
}

}  // namespace
}  // namespace ld
