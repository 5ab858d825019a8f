#include "training/validation.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "frame/frame_file.h"
#include "frame/manifest.h"
#include "metrics/metric.h"
#include "ops/tone_map_tensor.h"
#include "training/held_out.h"

namespace ld {
namespace {

constexpr const char* kLoss = "validation_loss";
constexpr int64_t kPicturesOfFrame = 3;  // ValidationPicture
constexpr int kTargetTurns = 4;          // ValidationSamples

/// Mean radiance of the valid samples, [3, H, W].
Image mean_of_samples(const NetworkInput& input) {
  const torch::Tensor count = input.valid.sum(1).clamp_min(1);
  return to_image(((input.radiance * input.valid).sum(1) / count).squeeze(0));
}

/// Each value that is a number, and a 1 behind it; two zeros stay where it is none.
void set_measured(const std::vector<double>& values, double* row) {
  for (const double value : values) {
    if (std::isfinite(value)) {
      row[0] = value;
      row[1] = 1;
    }
    row += 2;
  }
}

}  // namespace

Validation::Validation(std::vector<std::unique_ptr<FrameStore>> stores, int64_t pictures,
                       ValidationSamples samples, bool sequences)
    : stores_(std::move(stores)), pictures_(pictures), samples_(samples) {
  for (const std::unique_ptr<FrameStore>& store : stores_) {
    const size_t first = frames_.size();
    for (size_t i = 0; i < store->size(); ++i) {
      frames_.push_back({store.get(), i, {}, blocks_});
      blocks_ += blocks_of(store->width(i), store->height(i));
    }
    for (std::vector<size_t>& run : store->runs()) {
      for (size_t i = 0; i < run.size(); ++i) {
        run[i] += first;
        frames_[run[i]].place = {static_cast<int64_t>(sequences_.size()), static_cast<int64_t>(i)};
      }
      sequences_.push_back(std::move(run));
    }
  }
  for (size_t i = 0; sequences && !samples.targets && i < sequences_.size(); ++i)
    measures_sequences_ = measures_sequences_ || is_sequence(static_cast<int64_t>(i));
}

int64_t Validation::pixels() const {
  int64_t sum = 0;
  for (const FrameOf& frame : frames_)
    sum += int64_t{frame.store->width(frame.index)} * frame.store->height(frame.index);
  return sum;
}

int Validation::turns_of(const FrameOf& frame) const {
  return samples_.targets ? std::min(kTargetTurns, frame.store->spp(frame.index)) : 1;
}

int Validation::samples_of(const FrameOf& frame) const {
  const int all = frame.store->spp(frame.index), turns = turns_of(frame);
  const int most = samples_.targets ? all - (all + turns - 1) / turns : all;
  return samples_.input > 0 ? std::min(samples_.input, most) : most;
}

/// That part of the frame, with its first samples, or with those that are not this turn's targets.
Batch Validation::read(const FrameOf& frame, const std::vector<std::string>& features,
                       const Augmentation& part, int turn, Noisy noisy) const {
  const std::shared_ptr<const PackedFrame> packed = frame.store->get(frame.index);
  SampleList targets, input;
  if (samples_.targets)
    for (int s = turn; s < packed->spp; s += turns_of(frame)) targets.push_back(s);
  input = other_samples(packed->spp, targets);
  input.resize(static_cast<size_t>(samples_of(frame)));
  const bool all = !targets.empty() || noisy == Noisy::others;
  auto intact = frame.store->get_intact(frame.index, packed, part.tiles(), all ? SampleList() : input);
  const SampleList beside = noisy_samples(noisy, packed->spp, input);
  return make_batch({{std::move(intact), part, input, targets, beside}}, features);
}

const Validation::FrameOf& Validation::largest() const {
  const auto size = [this](const FrameOf& frame) {
    return int64_t{frame.store->width(frame.index)} * frame.store->height(frame.index) * samples_of(frame);
  };
  return *std::max_element(frames_.begin(), frames_.end(),
                           [&](const FrameOf& a, const FrameOf& b) { return size(a) < size(b); });
}

int64_t Validation::pixels_of_largest() const {
  const FrameOf& frame = largest();
  return int64_t{frame.store->width(frame.index)} * frame.store->height(frame.index);
}

Batch Validation::middle_of_largest(const std::vector<std::string>& features, int side) const {
  const FrameOf& frame = largest();
  const int width = frame.store->width(frame.index), height = frame.store->height(frame.index);
  Augmentation middle;
  middle.width = std::min(width, side);
  middle.height = std::min(height, side);
  middle.x = (width - middle.width) / 2;
  middle.y = (height - middle.height) / 2;
  return read(frame, features, middle);
}

int64_t Validation::picture_bytes() const {
  const int64_t sets = std::min<int64_t>(pictures_, static_cast<int64_t>(frames_.size())) + 1;
  const FrameOf& frame = largest();
  const int64_t samples = int64_t{samples_of(frame)} * kAllChannels * int64_t{sizeof(float)};
  return pixels_of_largest() * (sets * kPicturesOfFrame * 3 * int64_t{sizeof(float)} +
                                (measures_sequences_ ? SequenceWatch::kBytesOfPixel + samples : 0));
}

SurfaceGuides Validation::guides_of(const FrameOf& frame) const {
  Faults faults;  // which the store has told
  return surface_guides(read_frame(frame_path(frame.store->folder(), frame.store->name(frame.index)),
                                   {"radiance"}, faults, samples_of(frame)));
}

std::optional<int64_t> Validation::sequence_shown(const ProcessGroup& group) const {
  if (!group.is_root() || !measures_sequences_ || pictures_ == 0) return std::nullopt;
  for (int64_t i = 0; i < static_cast<int64_t>(sequences_.size()); i += group.size())
    if (is_sequence(i)) return i;
  return std::nullopt;
}

std::vector<size_t> Validation::frames_of(const ProcessGroup& group) const {
  std::vector<size_t> own;
  for (auto i = static_cast<size_t>(group.rank()); i < sequences_.size();
       i += static_cast<size_t>(group.size()))
    own.insert(own.end(), sequences_[i].begin(), sequences_[i].end());
  return own;
}

/// Of the frames of rank 0, evenly spread ones.
std::set<size_t> Validation::shown(const ProcessGroup& group) const {
  std::set<size_t> frames;
  if (!group.is_root()) return frames;
  const std::vector<size_t> own = frames_of(group);
  const size_t count = std::min(static_cast<size_t>(pictures_), own.size());
  for (size_t i = 0; i < count; ++i) frames.insert(own[i * own.size() / count]);
  return frames;
}

std::optional<ValidationResult> Validation::run(Network& network, const Loss& loss, ProcessGroup& group,
                                                const std::function<bool()>& stop) const {
  const Denoise forward = [&](NetworkInput input, const torch::Tensor& reference, SequenceState& sequence) {
    if (!sequence.memory.has_value()) sequence.memory = NetworkState();
    return network.compare(std::move(input), reference, std::any_cast<NetworkState&>(sequence.memory));
  };
  return run(forward, network.config().features, loss, group, stop);
}

std::optional<ValidationResult> Validation::run(const Denoise& denoise,
                                                const std::vector<std::string>& features, const Loss& loss,
                                                ProcessGroup& group,
                                                const std::function<bool()>& stop) const {
  const torch::NoGradGuard no_graph;
  ValidationResult result;
  // One row for each frame; each process fills the rows of its own frames.
  const auto columns = static_cast<int64_t>(1 + metrics().size());
  const torch::Tensor table = torch::zeros({static_cast<int64_t>(frames_.size()), columns}, torch::kFloat64);
  const torch::Tensor blocks = torch::zeros({samples_.targets ? blocks_ + 1 : 0}, torch::kFloat64);
  const std::set<size_t> shown_frames = shown(group);
  // One row for each sequence: what was measured, and 1 where it is a number.
  const std::vector<Metric>& measures = sequence_measures();
  const torch::Tensor steadiness =
      torch::zeros({measures_sequences_ ? static_cast<int64_t>(sequences_.size()) : 0,
                    static_cast<int64_t>(2 * measures.size())},
                   torch::kFloat64);
  const std::optional<int64_t> shown_sequence = sequence_shown(group);
  SequenceWatch watch;
  SequenceState state;
  bool stopped = false;
  for (const size_t i : frames_of(group)) {
    stopped = stop();
    if (stopped) break;
    const FrameOf& frame = frames_[i];
    const int width = frame.store->width(frame.index), height = frame.store->height(frame.index);
    Augmentation whole;
    whole.width = width;
    whole.height = height;
    double* row = table[static_cast<int64_t>(i)].data_ptr<double>();
    state.advance(frame.place, width, height);
    const SequenceState before = state;  // every turn follows the same frame
    const int turns = turns_of(frame);
    for (int turn = 0; turn < turns; ++turn) {
      state = before;
      Batch batch = read(frame, features, whole, turn);
      ValidationPicture picture;
      picture.name = frame.store->name(frame.index);
      const bool is_shown = turn == 0 && shown_frames.count(i) > 0;
      const bool is_measured = measures_sequences_ && is_sequence(frame.place.sequence);
      if (is_shown || is_measured) picture.noisy = mean_of_samples(batch.input);
      const Compared compared =
          denoise(samples_.targets ? batch.input : std::move(batch.input), batch.reference, state);
      const torch::Tensor& denoised = compared.picture;
      row[0] += loss(compared.predicted, compared.target).item<double>() / turns;
      picture.denoised = to_image(denoised.squeeze(0));
      picture.reference = to_image(batch.reference.squeeze(0));
      for (size_t m = 0; m < metrics().size(); ++m)
        row[m + 1] += metrics()[m].compute(picture.denoised, picture.reference) / turns;
      if (samples_.targets) {
        const int spp = frame.store->spp(frame.index), targets = (spp - turn + turns - 1) / turns;
        const std::vector<double> errors = block_errors(denoised, batch, targets);
        double* sums = blocks.data_ptr<double>();
        for (size_t k = 0; k < errors.size(); ++k)
          sums[static_cast<size_t>(frame.first_block) + k] += errors[k] / turns;
        sums[blocks_] +=
            sample_correlation(denoised, batch).value_or(0) / turns / static_cast<double>(frames_.size());
      }
      if (is_measured) {
        const bool keep = frame.place.sequence == shown_sequence;
        watch.add(guides_of(frame), picture.noisy, picture.denoised, picture.reference, keep);
        if (keep && !result.strip) result.strip = SequenceStrip{picture.name, {}};
        const int64_t sequence = frame.place.sequence;
        if (i == sequences_[static_cast<size_t>(sequence)].back())
          set_measured(watch.finish(), steadiness[sequence].data_ptr<double>());
      }
      if (is_shown) result.pictures.push_back(std::move(picture));
    }
  }
  if (group.any(stopped, "validating")) return std::nullopt;
  group.sum({table, blocks, steadiness}, "validating");
  if (result.strip) result.strip->image = watch.strip();
  const torch::Tensor sums = steadiness.sum(0);
  const double* sum = sums.data_ptr<double>();
  for (size_t m = 0; m < measures.size(); ++m)
    if (sum[2 * m + 1] > 0) result.scores[measures[m].name] = sum[2 * m] / sum[2 * m + 1];
  if (samples_.targets) {
    const double* first = blocks.data_ptr<double>();
    result.block_errors.assign(first, first + blocks_);
    result.correlation = first[blocks_];
  }
  const torch::Tensor means = table.mean(0);
  const double* mean = means.data_ptr<double>();
  result.scores[kLoss] = *mean++;
  for (const Metric& metric : metrics()) result.scores[metric.name] = *mean++;
  return result;
}

std::optional<FirstStageScore> Validation::score_first_stage(Network& network, Noisy noisy,
                                                             ProcessGroup& group) const {
  const torch::NoGradGuard no_graph;
  // Sums of squared differences of the first stage and of the reference, and how many.
  const torch::Tensor sums = torch::zeros({3}, torch::kFloat64);
  for (const size_t i : frames_of(group)) {
    const FrameOf& frame = frames_[i];
    Augmentation whole;
    whole.width = frame.store->width(frame.index);
    whole.height = frame.store->height(frame.index);
    Batch batch = read(frame, network.config().features, whole, /*turn=*/0, noisy);
    if (!batch.noisy.defined()) continue;
    const auto shown = [](const torch::Tensor& x) { return tone_map(x).clamp_max(1).to(torch::kFloat64); };
    const torch::Tensor target = shown(batch.noisy);
    const auto error = [&](const torch::Tensor& picture) {
      return (shown(picture.cpu()) - target).square().sum();
    };
    sums[1] += error(batch.reference);
    sums[0] += error(network.stages(std::move(batch.input), SecondReads::first).first);
    sums[2] += static_cast<double>(target.numel());
  }
  group.sum({sums}, "scoring the first stage");
  const double* sum = sums.data_ptr<double>();
  if (sum[2] == 0) return std::nullopt;
  const auto psnr = [&](double square) { return -10 * std::log10(square / sum[2]); };
  return FirstStageScore{psnr(sum[0]), psnr(sum[1])};
}

}  // namespace ld
