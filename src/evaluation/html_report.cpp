#include "evaluation/html_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "core/checksum.h"
#include "core/error.h"
#include "core/file_io.h"
#include "evaluation/picture_codec.h"
#include "evaluation/report_assets.h"
#include "evaluation/sequence_evaluation.h"
#include "evaluation/strips.h"
#include "evaluation/tables.h"

namespace ld {
namespace {

/// The middle of the picture, at most `side` pixels wide and high.
Image middle_of(const Image& image, int side) {
  const int width = std::min(image.width, side), height = std::min(image.height, side);
  const int left = (image.width - width) / 2, top = (image.height - height) / 2;
  Image result(width, height, image.channels);
  for (int c = 0; c < image.channels; ++c)
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) result.at(c, x, y) = image.at(c, left + x, top + y);
  return result;
}

/// JSON that cannot end the element it stands in: "</script>" and "<!--" both begin with "<". What is no
/// UTF-8 (file names may be anything) becomes U+FFFD.
std::string json_for_html(const nlohmann::ordered_json& json) {
  std::string text;
  for (const char c : json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace))
    text += c == '<' ? std::string("\\u003c") : std::string(1, c);
  return text;
}

/// The page with {{NAME}} replaced; what is put in is not searched again.
std::string fill_page(const std::string& page, const std::map<std::string, std::string>& values) {
  std::string text;
  size_t at = 0;
  for (size_t open = page.find("{{"); open != std::string::npos; open = page.find("{{", at)) {
    const size_t close = page.find("}}", open);
    text += page.substr(at, open - at) + values.at(page.substr(open + 2, close - open - 2));
    at = close + 2;
  }
  return text + page.substr(at);
}

/// Scores, pairs, curves as SVG text, and room for the clips.
nlohmann::ordered_json json_of_sequences(const Evaluation& evaluation) {
  const Evaluation scores = sequence_scores(evaluation);
  nlohmann::ordered_json json = {{"evaluation", to_json(scores)},
                                 {"comparisons", nlohmann::ordered_json::array()},
                                 {"curves", nlohmann::ordered_json::array()},
                                 {"clips", nlohmann::ordered_json::array()}};
  for (const MethodScores& method : scores.methods)
    json["comparisons"].push_back(comparison_json(scores, method));
  for (const SequenceCurve& curve : evaluation.sequences->curves)
    json["curves"].push_back({{"title", curve.plot.title}, {"svg", to_svg(curve.plot)}});
  return json;
}

}  // namespace

ReportWriter::ReportWriter(size_t frame_count, const ReportOptions& options)
    : frame_count_(frame_count), options_(options) {}

void ReportWriter::add_to_clips(size_t frame, const std::string& name,
                                const std::vector<LabelledPicture>& pictures) {
  const auto& sequences = options_.sequences;
  for (size_t s = 0; s < sequences.size(); ++s) {
    const auto at = std::find(sequences[s].begin(), sequences[s].end(), frame);
    if (at == sequences[s].end() || at - sequences[s].begin() >= std::ptrdiff_t(options_.most_frames) ||
        !is_evenly_chosen(s, sequences.size(), options_.most_sequences))
      continue;
    Clip& clip = clips_[s];
    clip.frames.push_back(name);
    clip.encoded.emplace_back();
    labels_.clear();
    for (const LabelledPicture& picture : pictures) {
      const Image shown = middle_of(picture.image, options_.sequence_side);
      clip.width = shown.width;
      clip.height = shown.height;
      clip.encoded.back().push_back(encode_shown_picture(shown));
      labels_.push_back(picture.label);
    }
  }
}

void ReportWriter::add(size_t frame, const std::string& name, const std::vector<LabelledPicture>& pictures) {
  add_to_clips(frame, name, pictures);
  if (!is_evenly_chosen(frame, frame_count_, options_.frames)) return;
  const Image& first = pictures.front().image;
  Picture entry{frame, name, 0, 0, first.width, first.height, {}};
  labels_.clear();
  for (const LabelledPicture& picture : pictures) {
    const Image shown = middle_of(picture.image, options_.side);
    entry.width = shown.width;
    entry.height = shown.height;
    entry.encoded.push_back(encode_picture(shown));
    labels_.push_back(picture.label);
  }
  pictures_.push_back(std::move(entry));
}

void ReportWriter::write(const std::filesystem::path& path, const Evaluation& evaluation) const {
  nlohmann::ordered_json data = {{"version", LD_VERSION},
                                 {"evaluation", to_json(evaluation)},
                                 {"labels", labels_},
                                 {"order", nlohmann::ordered_json::array()},
                                 {"comparisons", nlohmann::ordered_json::array()},
                                 {"pictures", nlohmann::ordered_json::array()}};
  for (const MethodScores& method : evaluation.methods) {
    data["order"].push_back(method.name);
    data["comparisons"].push_back(comparison_json(evaluation, method));
  }
  std::string encoded;
  const auto embed = [&](const std::string& id, const std::string& picture) {
    encoded += fmt::format("<script type=\"text/plain\" id=\"{}\">{}</script>\n", id, picture);
  };
  if (evaluation.sequences) {
    data["sequences"] = json_of_sequences(evaluation);
    for (const auto& [number, clip] : clips_) {
      nlohmann::ordered_json& clips = data["sequences"]["clips"];
      for (size_t f = 0; f < clip.encoded.size(); ++f)
        for (size_t m = 0; m < clip.encoded[f].size(); ++m)
          embed(fmt::format("clip-{}-{}-{}", clips.size(), f, m), clip.encoded[f][m]);
      clips.push_back({{"width", clip.width}, {"height", clip.height}, {"frames", clip.frames}});
    }
  }
  for (size_t p = 0; p < pictures_.size(); ++p) {
    const Picture& picture = pictures_[p];
    data["pictures"].push_back({{"index", picture.index},
                                {"frame", picture.frame},
                                {"width", picture.width},
                                {"height", picture.height},
                                {"full_width", picture.full_width},
                                {"full_height", picture.full_height}});
    for (size_t m = 0; m < picture.encoded.size(); ++m)
      embed(fmt::format("picture-{}-{}", p, m), picture.encoded[m]);
  }
  const std::string json = json_for_html(data);
  // A nonce that depends on the data: whoever chose a name in it cannot know it.
  const std::string nonce = checksum_text(json.data(), json.size());
  write_file_atomically(path, fill_page(kReportPage, {{"nonce", nonce},
                                                      {"style", kReportStyle},
                                                      {"script", kReportScript},
                                                      {"data", json},
                                                      {"pictures", encoded}}));
}

}  // namespace ld
