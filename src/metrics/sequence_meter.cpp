#include "metrics/sequence_meter.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/window_sums.h"
#include "metrics/detail_filter.h"
#include "metrics/image_pair.h"

namespace ld {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kLightChange = 0.1;  // of display values
constexpr int kLightRadius = 3;       // pixels
constexpr float kStillFlow = 1.0F / 64;
constexpr double kStillShare = 0.01;     // of the pixels, for a flicker to be measured
constexpr double kDetailLeast = 0.01;    // |fine_detail| of the reference where there is detail
constexpr double kSettled = 0.05;        // share of the change
constexpr size_t kFirstFrameLength = 4;  // of a sequence, for its beginning to be told from its end

enum Measure { te, tpsnr, trmae, flicker_of, steadier, ghosting, trail, first_frame, detail, measure_count };

/// Two zeros are as much as one another.
double ratio(double a, double b) {
  if (b > 0 || std::isnan(b)) return a / b;
  return a > 0 ? std::numeric_limits<double>::infinity() : 1;
}

std::vector<double> channel_mean(const std::vector<double>& planes) {
  const size_t count = planes.size() / 3;
  std::vector<double> mean(count);
  for (size_t p = 0; p < count; ++p) mean[p] = (planes[p] + planes[count + p] + planes[2 * count + p]) / 3;
  return mean;
}

/// Means over the window around each pixel, of the pixels that count.
std::vector<double> window_means(const std::vector<double>& values, const std::vector<double>& counts,
                                 const SequenceGround& ground) {
  std::vector<double> means = window_sums(values, ground.width, ground.height, kLightRadius);
  const std::vector<double> count = window_sums(counts, ground.width, ground.height, kLightRadius);
  for (size_t i = 0; i < means.size(); ++i) means[i] = count[i] > 0.5 ? means[i] / count[i] : 0;
  return means;
}

/// How the light on each pixel changed: of the reference less the warped one before, the mean over channels
/// and a window, in which a texture that the warp blurs averages out.
std::vector<double> light_change(const SequenceGround& ground) {
  const std::vector<double> now = channel_mean(ground.shown), before = channel_mean(ground.shown_before);
  const std::vector<double> past = warped(before, ground.warp, ground.width);
  std::vector<double> change(now.size()), seen(now.size());
  for (size_t p = 0; p < now.size(); ++p) {
    seen[p] = ground.warp[p].valid ? 1 : 0;
    if (ground.warp[p].valid) change[p] = now[p] - past[p];
  }
  return window_means(change, seen, ground);
}

/// What came into view less what was seen at its place in the frame before, the mean over channels and the
/// pixels of a window that came into view, too. 0 for what was outside.
std::vector<double> replacement(const SequenceGround& ground, const SurfaceGuides& guides) {
  const std::vector<double> now = channel_mean(ground.shown), before = channel_mean(ground.shown_before);
  std::vector<double> change(now.size()), came(now.size());
  for (size_t p = 0; p < now.size(); ++p) {
    if (ground.warp[p].seen_at >= 0) continue;
    const size_t x = p % size_t(ground.width), y = p / size_t(ground.width);
    const double u = std::floor(double(x) + double{guides.flow_x[p]} + 0.5),
                 v = std::floor(double(y) + double{guides.flow_y[p]} + 0.5);
    if (!(u >= 0 && v >= 0 && u < ground.width && v < ground.height)) continue;
    came[p] = 1;
    change[p] = now[p] - before[size_t(v) * size_t(ground.width) + size_t(u)];
  }
  return window_means(change, came, ground);
}

}  // namespace

const std::vector<Metric>& sequence_measures() {
  static const std::string e = "e = (T(d_t) - W T(d_t-1)) - (T(r_t) - W T(r_t-1))";
  static const std::string display = "display values; frames after the first";
  static const std::vector<Metric> all = {
      {"te", "TE", Best::lowest, display + ", pixels whose surface was seen in the frame before",
       "mean of |e|, " + e + ", W the lookup at the pixel's place in the frame before", 5, nullptr},
      {"tpsnr", "tPSNR", Best::highest, display + ", dB", "-10 log10(mean of e^2), e as in TE without W", 2,
       nullptr},
      {"trmae", "trMAE", Best::lowest, display,
       fmt::format("mean of |e| / (|T(r_t) - T(r_t-1)| + {:g}), e as in TE without W", kTemporalEpsilon), 4,
       nullptr},
      {"flicker", "flicker", Best::lowest,
       fmt::format("display values; pixels that stand still with the light on them, at least {:g} %",
                   100 * kStillShare),
       "mean over pixels and channels of the standard deviation of T(d) over the frames", 5, nullptr},
      {"steadier", "steadier", Best::highest, "as flicker", "flicker of noisy / flicker", 2, nullptr},
      {"ghosting", "ghosting", Best::lowest,
       fmt::format(
           "display values; pixels that came into view, or whose light changed by more than {:g}, less "
           "than {} frames ago",
           kLightChange, kChangedFrames),
       "mean of |T(d) - T(r)| on these pixels / that on all", 3, nullptr},
      {"trail", "trail", Best::lowest, "the same pixels by the frames since then",
       fmt::format(
           "the first number of frames with |sum (T(r) - T(d)) c| / sum c^2 below {:g}, c the change of "
           "the reference; {}: none",
           kSettled, kChangedFrames),
       2, nullptr},
      {"first_frame", "first frame", Best::lowest,
       fmt::format("display values; sequences of at least {} frames", kFirstFrameLength),
       "mean |T(d) - T(r)| of the first frame / that of the second half of the frames", 3, nullptr},
      {"detail", "detail", Best::one,
       fmt::format("display values, mean over channels, where the reference's |L| > {:g}", kDetailLeast),
       fmt::format("sum L(T(d))^2 / sum L(T(r))^2, L the Laplacian of a Gaussian, sigma {:g}, {}x{}",
                   kDetailSigma, kDetailWindow, kDetailWindow),
       3, nullptr},
  };
  return all;
}

void SequenceGround::advance(const SurfaceGuides& guides, const Image& reference) {
  width = reference.width;
  height = reference.height;
  const size_t count = reference.plane_size();
  shown_before = std::move(shown);
  shown = display_values(reference);
  age_before_ = std::move(age);
  age.assign(count, kChangedFrames);
  change_before_ = std::move(change);
  change.assign(count, 0);
  const std::vector<double> mean = channel_mean(shown);
  detail = fine_detail(mean, width, height);
  if (frames == 0) {
    warp.assign(count, {});
    first_ = mean;
    still.assign(count, guides.has_flow ? 1 : 0);
  } else {
    warp = reproject(guides, guides_);
    const std::vector<double> lit = light_change(*this), replaced = replacement(*this, guides);
    for (size_t p = 0; p < count; ++p) {
      const bool surface = guides.surface[p].depth < kEscapedDepth;
      if (!guides.has_flow || !surface) continue;
      if (warp[p].seen_at < 0 || std::abs(lit[p]) > kLightChange) {
        age[p] = 0;
        change[p] = warp[p].seen_at < 0 ? replaced[p] : lit[p];
      } else {
        const auto before = size_t(warp[p].seen_at);
        age[p] = std::min(age_before_[before] + 1, kChangedFrames);
        change[p] = change_before_[before];
      }
    }
  }
  for (size_t p = 0; p < count; ++p)
    if (!(guides.surface[p].depth < kEscapedDepth) ||
        (frames > 0 &&
         (!(std::abs(guides.flow_x[p]) <= kStillFlow && std::abs(guides.flow_y[p]) <= kStillFlow) ||
          !warp[p].valid || std::abs(mean[p] - first_[p]) > kLightChange)))
      still[p] = 0;
  guides_ = guides;
  ++frames;
}

void SequenceMeter::add(const SequenceGround& ground, const Image& denoised) {
  broken_ = broken_ || count_not_finite(denoised) > 0;
  if (broken_) {
    frames_.push_back({kNone, kNone, kNone});
    return;
  }
  const std::vector<double> shown = display_values(denoised);
  const size_t count = ground.age.size();
  SequenceFrame frame{0, kNone, kNone};
  for (size_t p = 0; p < count; ++p) {
    double error = 0, missing = 0;
    for (size_t i = p; i < shown.size(); i += count) {
      error += std::abs(shown[i] - ground.shown[i]);
      missing += (ground.shown[i] - shown[i]) / 3;
    }
    const auto age = static_cast<size_t>(ground.age[p]);
    error_of_age_[age] += error;
    lag_of_age_[age] += missing * ground.change[p];
    change_of_age_[age] += ground.change[p] * ground.change[p];
    ++pixels_of_age_[age];
    frame.error += error;
  }
  frame.error /= static_cast<double>(shown.size());
  if (!frames_.empty()) {
    const TemporalPictures<double> pictures{shown, before_, ground.shown, ground.shown_before};
    const Warp identity = identity_warp(ground.width, ground.height);
    const double squared = temporal_error(TemporalNorm::squared, pictures, identity, ground.width);
    frame.unwarped = std::sqrt(squared);
    frame.warped = temporal_error(TemporalNorm::absolute, pictures, ground.warp, ground.width);
    squared_change_ += squared;
    relative_change_ += temporal_error(TemporalNorm::relative, pictures, identity, ground.width);
    if (!std::isnan(frame.warped)) {
      warped_change_ += frame.warped;
      ++warped_frames_;
    }
  }
  frames_.push_back(frame);

  const std::vector<double> fine = fine_detail(channel_mean(shown), ground.width, ground.height);
  for (size_t i = 0; i < fine.size(); ++i)
    if (std::abs(ground.detail[i]) > kDetailLeast) {
      detail_ += fine[i] * fine[i];
      reference_detail_ += ground.detail[i] * ground.detail[i];
    }
  if (first_.empty()) first_ = shown;
  sums_.resize(shown.size());
  squares_.resize(shown.size());
  for (size_t i = 0; i < shown.size(); ++i) {
    const double since = shown[i] - first_[i];
    sums_[i] += since;
    squares_[i] += since * since;
  }
  before_ = shown;
}

double SequenceMeter::flicker(const SequenceGround& ground) const {
  const size_t count = ground.still.size();
  const auto n = static_cast<double>(frames_.size());
  double sum = 0;
  size_t used = 0;
  for (size_t i = 0; i < sums_.size(); ++i) {
    if (ground.still[i % count] == 0) continue;
    sum += std::sqrt(std::max(squares_[i] - sums_[i] * sums_[i] / n, 0.0) / (n - 1));
    ++used;
  }
  return sum / static_cast<double>(used);
}

std::array<double, kChangedFrames> SequenceMeter::left_by_age() const {
  std::array<double, kChangedFrames> left{};
  for (size_t age = 0; age < left.size(); ++age)
    left[age] =
        !broken_ && change_of_age_[age] > 0 ? std::abs(lag_of_age_[age]) / change_of_age_[age] : kNone;
  return left;
}

SequenceScores SequenceMeter::scores(const SequenceGround& ground, const SequenceMeter& noisy) const {
  const size_t length = frames_.size(), count = ground.age.size();
  SequenceScores result{std::vector<double>(measure_count, kNone), std::vector<bool>(measure_count, false)};
  const bool pairs = length > 1;
  const auto still = static_cast<double>(std::count(ground.still.begin(), ground.still.end(), 1));
  // What a sequence lacks is told from the noisy pictures, because a broken method has counted nothing.
  const auto changed =
      std::accumulate(noisy.pixels_of_age_.begin(), noisy.pixels_of_age_.end() - 1, int64_t{0});
  result.applies[te] = noisy.warped_frames_ > 0;
  result.applies[tpsnr] = result.applies[trmae] = pairs;
  result.applies[flicker_of] = result.applies[steadier] =
      pairs && still >= kStillShare * static_cast<double>(count) && still > 0;
  result.applies[ghosting] = changed > 0;
  result.applies[trail] =
      std::accumulate(noisy.change_of_age_.begin(), noisy.change_of_age_.end() - 1, 0.0) > 0;
  result.applies[first_frame] = length >= kFirstFrameLength;
  result.applies[detail] = noisy.reference_detail_ > 0;
  if (broken_) return result;

  std::vector<double>& values = result.values;
  const double after_first = static_cast<double>(length) - 1;
  if (result.applies[te]) values[te] = warped_change_ / static_cast<double>(warped_frames_);
  if (pairs) {
    const double squared = squared_change_ / after_first;
    values[tpsnr] = squared > 0 ? -10 * std::log10(squared) : std::numeric_limits<double>::infinity();
    values[trmae] = relative_change_ / after_first;
  }
  if (result.applies[flicker_of]) {
    values[flicker_of] = flicker(ground);
    values[steadier] = noisy.broken_ ? kNone : ratio(noisy.flicker(ground), values[flicker_of]);
  }
  if (changed > 0) {
    const auto mean = [](double sum, int64_t pixels) { return sum / static_cast<double>(pixels); };
    const double all = mean(std::accumulate(error_of_age_.begin(), error_of_age_.end(), 0.0),
                            std::accumulate(pixels_of_age_.begin(), pixels_of_age_.end(), int64_t{0}));
    values[ghosting] =
        ratio(mean(std::accumulate(error_of_age_.begin(), error_of_age_.end() - 1, 0.0), changed), all);
  }
  if (result.applies[trail]) {
    const std::array<double, kChangedFrames> left = left_by_age();
    const auto* const gone = std::find_if(left.begin(), left.end(), [](double x) { return x < kSettled; });
    values[trail] = static_cast<double>(gone - left.begin());
  }
  if (result.applies[first_frame]) {
    double steady = 0;
    const size_t half = length / 2;
    for (size_t f = half; f < length; ++f) steady += frames_[f].error / static_cast<double>(length - half);
    values[first_frame] = ratio(frames_[0].error, steady);
  }
  if (result.applies[detail]) values[detail] = detail_ / reference_detail_;
  return result;
}

}  // namespace ld
