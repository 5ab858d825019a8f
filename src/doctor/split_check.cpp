// No picture of one split appears in another: scores on frames that were trained on are worth nothing.
#include <algorithm>
#include <array>
#include <cmath>

#include "doctor/doctor_check.h"

namespace ld {
namespace {

constexpr int kSide = 8;
constexpr int kPlanes = 8;  // reference, depth, normal (3), albedo (3), averaged over kSide x kSide cells
constexpr size_t kNumbers = size_t{kSide} * kSide * kPlanes;
// Correlation of two pictures' cells, averaged over the planes that vary in both. Different random scenes
// stay below 0.8; the next frame of a sequence or another noise of the same view comes to 0.97 and more.
constexpr double kAlike = 0.97;
// A plane counts when its cells differ at all: walls of one colour are alike in many pictures.
constexpr double kPlain = 1e-4;
constexpr size_t kLeastPlanes = 2;

struct Picture {
  std::string checksum;  // of the reference
  std::array<float, kNumbers> cells{};
  std::array<bool, kPlanes> plain{};  // all cells equal: says nothing
};

/// What a network sees of a pixel's guides, bounded so that no cell decides alone.
std::array<double, kPlanes> pixel_numbers(const Evidence& evidence, size_t p) {
  const Frame& frame = evidence.frame;
  const float scale = frame.info.depth_scale;
  static const int albedo = find_feature("albedo").offset;
  std::array<double, kPlanes> sum{};
  double count = 0;
  for (int s = 0; s < frame.spp; ++s) {
    if (frame.valid_plane(s)[p] == 0) continue;
    const double depth = std::max(frame.plane(s, kDepthOffset)[p], 0.0F);
    sum[1] += depth / (depth + static_cast<double>(scale));
    for (size_t c = 0; c < 3; ++c) {
      sum[2 + c] += frame.plane(s, kNormalOffset + static_cast<int>(c))[p];
      sum[5 + c] += frame.plane(s, albedo + static_cast<int>(c))[p];
    }
    ++count;
  }
  for (double& value : sum) value /= std::max(count, 1.0);
  sum[0] = std::log1p(evidence.reference_brightness.empty() ? evidence.mean_brightness[p]
                                                            : evidence.reference_brightness[p]);
  return sum;
}

Picture measure(const Evidence& evidence) {
  const Frame& frame = evidence.frame;
  Picture picture;
  picture.checksum = evidence.reference_checksum;
  std::array<double, kNumbers> sums{};
  std::array<double, size_t{kSide} * kSide> counts{};
  for (int y = 0; y < frame.height; ++y)
    for (int x = 0; x < frame.width; ++x) {
      const int row = y * kSide / frame.height, column = x * kSide / frame.width;
      const size_t cell = static_cast<size_t>(row) * kSide + static_cast<size_t>(column);
      const size_t p = static_cast<size_t>(y) * static_cast<size_t>(frame.width) + static_cast<size_t>(x);
      const auto numbers = pixel_numbers(evidence, p);
      for (size_t i = 0; i < kPlanes; ++i) sums[i * kSide * kSide + cell] += numbers[i];
      ++counts[cell];
    }
  // Each plane with mean 0 and length 1, so that a product is a correlation.
  constexpr size_t kCells = size_t{kSide} * kSide;
  for (size_t i = 0; i < kPlanes; ++i) {
    double mean = 0, squares = 0;
    for (size_t cell = 0; cell < kCells; ++cell) {
      double& value = sums[i * kCells + cell];
      if (counts[cell] > 0) value /= counts[cell];
      mean += value / kCells;
    }
    for (size_t cell = 0; cell < kCells; ++cell) squares += std::pow(sums[i * kCells + cell] - mean, 2);
    picture.plain[i] = squares < kPlain * kCells;
    for (size_t cell = 0; cell < kCells; ++cell)
      picture.cells[i * kCells + cell] =
          picture.plain[i] ? 0.0F : static_cast<float>((sums[i * kCells + cell] - mean) / std::sqrt(squares));
  }
  return picture;
}

double likeness(const Picture& a, const Picture& b) {
  double sum = 0;
  size_t planes = 0;
  for (size_t i = 0; i < kPlanes; ++i) {
    if (a.plain[i] != b.plain[i]) return 0;
    if (a.plain[i]) continue;
    float product = 0;
    for (size_t cell = i * kSide * kSide; cell < (i + 1) * kSide * kSide; ++cell)
      product += a.cells[cell] * b.cells[cell];
    sum += static_cast<double>(product);
    ++planes;
  }
  return planes < kLeastPlanes ? 0 : sum / static_cast<double>(planes);
}

struct Pair {
  std::string first, second;
  std::string splits;
};

void add_finding(Diagnosis& diagnosis, Severity severity, const std::vector<Pair>& pairs,
                 const std::string& what, const std::string& advice) {
  if (pairs.empty()) return;
  std::vector<std::string> names;
  std::string list;
  for (const Pair& pair : pairs) {
    names.push_back(pair.first);
    names.push_back(pair.second);
    if (names.size() <= 6)
      list += fmt::format("{}{} and {} ({})", list.empty() ? "" : ", ", pair.first, pair.second, pair.splits);
  }
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  diagnosis.add(
      severity,
      fmt::format("{} pair{} of frames in different splits {}: {}{}; {}", pairs.size(),
                  pairs.size() == 1 ? "" : "s", what, list, pairs.size() > 3 ? ", ..." : "", advice),
      names, {{"pairs", pairs.size()}});
}

void conclude(const Measurements<Picture>& frames, Diagnosis& diagnosis) {
  std::vector<Pair> same, alike;
  double most_alike = 0;
  for (size_t i = 0; i < frames.size(); ++i)
    for (size_t j = i + 1; j < frames.size(); ++j) {
      if (frames[i].split == frames[j].split) continue;
      const Picture &a = frames[i].result, &b = frames[j].result;
      const Pair pair = {frames[i].name, frames[j].name, frames[i].split + ", " + frames[j].split};
      if (!a.checksum.empty() && a.checksum == b.checksum) {
        same.push_back(pair);
        continue;
      }
      const double correlation = likeness(a, b);
      most_alike = std::max(most_alike, correlation);
      if (correlation > kAlike) alike.push_back(pair);
    }
  diagnosis.facts["likeness_across_splits"] = most_alike;
  const std::string advice =
      "scores on such frames say nothing about new ones: give a scene to one split only";
  add_finding(diagnosis, Severity::problem, same, "have the same reference", advice);
  add_finding(diagnosis, Severity::problem, alike, "show the same scene from almost the same view", advice);
}

}  // namespace

std::unique_ptr<Check> make_split_check(size_t frames) {
  return FrameCheck<Picture, measure, conclude>::make(frames);
}

}  // namespace ld
