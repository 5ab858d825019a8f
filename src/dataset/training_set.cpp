#include "dataset/training_set.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <limits>

#include "core/error.h"

namespace ld {
namespace {

/// Streams of their own beside that of a slot's position and turn, which are then those of a training with
/// all samples.
constexpr uint32_t kWhich = 1, kHowMany = 2, kDropped = 3, kPurposes = 4;

std::vector<std::vector<Clip>> clips_of_sets(const std::vector<WeightedStore>& sets, int length) {
  std::vector<std::vector<Clip>> clips;
  for (const WeightedStore& set : sets) clips.push_back(clips_of(*set.store, length));
  return clips;
}

EpochPlan make_plan(const std::vector<WeightedStore>& sets, const std::vector<std::vector<Clip>>& clips,
                    uint64_t seed) {
  std::vector<size_t> counts;
  std::vector<double> weights;
  size_t crops = 0;
  for (size_t set = 0; set < sets.size(); ++set) {
    counts.push_back(clips[set].size());
    weights.push_back(sets[set].weight);
    crops += clips_per_epoch(clips[set]);
  }
  return EpochPlan(counts, crops, weights, seed);
}

void check_samples(const std::string& frame, int held, const TrainingSetOptions& options) {
  if (options.sample_targets && held < 2)
    fail_usage(
        "data.targets: frame {} has 1 sample a pixel; samples as targets need 2 or more, some to denoise and "
        "some to compare with",
        frame);
  if (options.noisy == Noisy::others && held < 2)
    fail_usage(
        "optimizer.scheme: frame {} has 1 sample a pixel; a first stage that learns from noise needs 2 or "
        "more, "
        "some to read and some to compare with; render more, or read 'half_radiance'",
        frame);
  const int usable = options.sample_targets || options.noisy == Noisy::others ? held - 1 : held;
  if (usable < options.samples.least)
    fail_usage(
        "data.samples: frame {} has {} samples a pixel{}, fewer than the {} that every batch uses; render "
        "more, or let data.samples begin at {} or less",
        frame, held, usable < held ? ", one of which must be the target" : "", options.samples.least, usable);
}

TrainingSetOptions settle_samples(TrainingSetOptions options, const std::vector<WeightedStore>& sets) {
  if ((!options.sample_targets && options.noisy != Noisy::others) || !options.samples.all()) return options;
  int fewest = std::numeric_limits<int>::max();
  for (const WeightedStore& set : sets)
    for (size_t i = 0; i < set.store->size(); ++i) fewest = std::min(fewest, set.store->spp(i));
  const int most = options.sample_targets ? fewest - 1 : fewest / 2;
  options.samples = {std::max(fewest / 2, 1), std::max(most, 1)};
  return options;
}

}  // namespace

BatchPart batch_part(int64_t batch, int rank, int processes) {
  const int64_t first = batch * rank / processes;
  return {first, batch * (rank + 1) / processes - first};
}

TrainingSet::TrainingSet(std::vector<WeightedStore> sets, std::vector<std::string> features,
                         TrainingSetOptions options)
    : sets_(std::move(sets)),
      features_(std::move(features)),
      options_(settle_samples(std::move(options), sets_)),
      part_(batch_part(options_.batch, options_.rank, options_.processes)),
      clips_(clips_of_sets(sets_, options_.clip)),
      plan_(make_plan(sets_, clips_, options_.seed)),
      batches_([this](int64_t number) { return batch_with(number, sample_count(number)); },
               options_.workers) {
  if (options_.batch < options_.processes)
    fail_usage(
        "data.batch: {} crops a step cannot be split over {} processes; set data.batch={} or more, or start "
        "fewer processes",
        options_.batch, options_.processes, options_.processes);
  if (batches_per_epoch() < 1)
    fail_usage(
        "data.batch: {} crops a step come from different {}, but an epoch of the split has {}; render more "
        "frames or set data.batch={}",
        options_.batch, options_.clip == 1 ? "frames" : "clips", plan_.crops(), plan_.crops());
  const AugmentationOptions& augmentation = options_.augmentation;
  if (first_channel(features_, "flow") >= 0 &&
      (augmentation.reversal || augmentation.stop > 0 || augmentation.freeze > 0))
    fail_usage(
        "data.{}: the network reads 'flow', the way to the frame before, which a clip that runs backwards or "
        "stands still does not know; set it to {} or leave 'flow' out of network.features",
        augmentation.reversal   ? "reversal"
        : augmentation.stop > 0 ? "stop"
                                : "freeze",
        augmentation.reversal ? "false" : "0");
  if (augmentation.stop + augmentation.freeze > 1)
    fail_usage("data.stop={:g} and data.freeze={:g} are more than all clips; expected a sum of at most 1",
               augmentation.stop, augmentation.freeze);
  const int crop = options_.augmentation.crop;
  if (crop % options_.augmentation.multiple != 0)
    fail_usage("data.crop: {}, but the network makes {}x{} pixels of one; set it to a multiple of {}", crop,
               options_.augmentation.multiple, options_.augmentation.multiple,
               options_.augmentation.multiple);
  for (const WeightedStore& set : sets_)
    for (size_t i = 0; i < set.store->size(); ++i)
      if (set.store->width(i) < crop || set.store->height(i) < crop)
        fail_usage(
            "data.crop: frame {} has {}x{} pixels, smaller than the crop of {}; set data.crop={} or less",
            set.store->name(i), set.store->width(i), set.store->height(i), crop,
            std::min(set.store->width(i), set.store->height(i)));
  for (const WeightedStore& set : sets_)
    for (size_t i = 0; i < set.store->size(); ++i)
      check_samples(set.store->name(i), set.store->spp(i), options_);
}

int64_t TrainingSet::batches_per_epoch() const {
  const auto crops = static_cast<int64_t>(plan_.crops());
  const int64_t step = options_.batch * options_.accumulate;
  return step <= crops ? crops / step * options_.accumulate : crops / options_.batch;
}

RandomStream TrainingSet::Slot::stream(uint64_t seed, uint32_t purpose, uint32_t frame) const {
  return RandomStream(seed, RandomPurpose::augmentation, static_cast<uint32_t>(step),
                      static_cast<uint32_t>(place), purpose + kPurposes * frame);
}

/// `place`: within the batch.
TrainingSet::Slot TrainingSet::slot_of(int64_t number, int64_t place) const {
  return {number / options_.accumulate, number % options_.accumulate * options_.batch + place};
}

/// Of the whole batch.
std::vector<ClipRef> TrainingSet::clips_of_batch(int64_t number) const {
  const std::vector<ClipRef> epoch = plan_.epoch(static_cast<uint32_t>(number / batches_per_epoch()));
  const auto first = epoch.begin() + number % batches_per_epoch() * options_.batch;
  return {first, first + options_.batch};
}

/// All batches of a step have as many.
int TrainingSet::sample_count(int64_t number) const {
  if (options_.samples.all()) return 0;
  RandomStream stream = Slot{number / options_.accumulate, 0}.stream(options_.seed, kHowMany);
  return draw_sample_count(stream, options_.samples);
}

Batch TrainingSet::batch_with(int64_t number, int samples) const {
  const std::vector<ClipRef> clips = clips_of_batch(number);
  std::vector<FrameCrop> crops;
  for (int64_t place = part_.first; place < part_.first + part_.count; ++place)
    for (FrameCrop& crop : draw_clip(clips[static_cast<size_t>(place)], slot_of(number, place), samples))
      crops.push_back(std::move(crop));
  Batch batch = make_batch(crops, features_, options_.clip);
  drop_features(batch, number);
  return batch;
}

/// As frames look that never had the feature: zeros, in all frames of a clip. By hand, as make_batch() does
/// it.
void TrainingSet::drop_features(Batch& batch, int64_t number) const {
  if (options_.drop == 0) return;
  const torch::Tensor& features = batch.input.features;  // [B T, S, F, H, W]
  const int64_t plane = features.size(3) * features.size(4);
  for (int64_t b = 0; b < features.size(0); ++b) {
    RandomStream stream = slot_of(number, part_.first + b / batch.clip).stream(options_.seed, kDropped);
    for (const std::string& name : options_.optional) {
      if (static_cast<double>(stream.uniform()) >= options_.drop) continue;
      const int64_t first = first_channel(features_, name), channels = find_feature(name).channels;
      for (int64_t s = 0; s < features.size(1); ++s)
        std::fill_n(
            features.data_ptr<float>() + ((b * features.size(1) + s) * features.size(2) + first) * plane,
            channels * plane, 0.0F);
    }
  }
}

std::string TrainingSet::describe(int64_t first, int64_t count) const {
  std::string text;
  for (int64_t number = first; number < first + count; ++number) {
    const std::vector<ClipRef> clips = clips_of_batch(number);
    for (int64_t place = 0; place < options_.batch; ++place) {
      const ClipRef ref = clips[static_cast<size_t>(place)];
      const std::vector<FrameCrop> drawn = draw_clip(ref, slot_of(number, place), sample_count(number));
      const Augmentation& crop = drawn.front().augmentation;
      std::vector<std::string> names;
      for (const size_t frame : clips_[ref.set][ref.clip]) names.push_back(sets_[ref.set].store->name(frame));
      text += fmt::format("{}{}{} at {},{}{}{}{}", text.empty() ? "" : "; ", fmt::join(names, "+"),
                          crop.reversed ? " backwards" : "", crop.x, crop.y,
                          crop.flip_x ? " flipped in x" : "", crop.flip_y ? " flipped in y" : "",
                          crop.quarter_turns > 0 ? fmt::format(" turned {}", 90 * crop.quarter_turns) : "");
      if (options_.augmentation.exposure > 0 || options_.augmentation.tint > 0)
        text += fmt::format(" times {:.4g}", fmt::join(crop.exposure, " "));
      if (crop.last_frame >= 0) text += fmt::format(" stays at its frame {}", crop.last_frame + 1);
      for (size_t t = 0; t < drawn.size(); ++t)
        if (!drawn[t].samples.empty())
          text += fmt::format("{}{}", t == 0 ? " of samples " : ", ", fmt::join(drawn[t].samples, " "));
    }
  }
  return text;
}

/// How many of a frame's samples enter; 0: all.
int TrainingSet::input_samples(int held, int samples) const {
  const bool spares_one = options_.sample_targets || options_.noisy == Noisy::others;
  return spares_one ? std::clamp(samples, 1, held - 1) : samples;
}

/// What there is of a frame that a clip stays at: its noise instances, and of each as many groups of samples
/// as it has without one of them twice; in random order.
std::vector<TrainingSet::FrameNoise> TrainingSet::noise_of_stay(const FrameStore& store, size_t frame,
                                                                const Slot& slot, int samples) const {
  RandomStream stream = slot.stream(options_.seed, kWhich, static_cast<uint32_t>(options_.clip));
  std::vector<FrameNoise> all;
  for (const size_t instance : store.instances(frame)) {
    const int held = store.spp(instance), count = input_samples(held, samples);
    if (count <= 0 || count >= held) {
      all.push_back({instance, {}});
      continue;
    }
    const std::vector<uint32_t> order = random_permutation(stream, static_cast<uint32_t>(held));
    for (auto first = order.begin(); order.end() - first >= count; first += count) {
      all.push_back({instance, SampleList(first, first + count)});
      std::sort(all.back().samples.begin(), all.back().samples.end());
    }
  }
  std::vector<FrameNoise> shuffled;
  for (const uint32_t i : random_permutation(stream, static_cast<uint32_t>(all.size())))
    shuffled.push_back(std::move(all[i]));
  return shuffled;
}

/// One crop and turn for all frames of the clip, samples of its own for each.
std::vector<FrameCrop> TrainingSet::draw_clip(const ClipRef& ref, const Slot& slot, int samples) const {
  FrameStore& store = *sets_[ref.set].store;
  Clip clip = clips_[ref.set][ref.clip];
  std::vector<std::shared_ptr<const PackedFrame>> frames;
  std::vector<const PackedFrame*> pointers;
  for (const size_t index : clip) {
    frames.push_back(store.get(index));
    pointers.push_back(frames.back().get());
  }
  RandomStream stream = slot.stream(options_.seed);
  const Augmentation augmentation = random_augmentation(stream, pointers, options_.augmentation);
  if (augmentation.reversed) {
    std::reverse(clip.begin(), clip.end());
    std::reverse(frames.begin(), frames.end());
  }
  std::vector<FrameNoise> of_stay;
  if (augmentation.last_frame >= 0)
    of_stay = noise_of_stay(store, clip[static_cast<size_t>(augmentation.last_frame)], slot, samples);
  std::vector<FrameCrop> crops;
  for (size_t t = 0; t < clip.size(); ++t) {
    FrameNoise noise = {clip[t], {}};
    if (!of_stay.empty() && t >= static_cast<size_t>(augmentation.last_frame)) {
      noise = of_stay[(t - static_cast<size_t>(augmentation.last_frame)) % of_stay.size()];
    } else if (const int count = input_samples(frames[t]->spp, samples); count > 0) {
      RandomStream which = slot.stream(options_.seed, kWhich, static_cast<uint32_t>(t));
      noise.samples = draw_samples(which, frames[t]->spp, count);
    }
    const auto frame = noise.frame == clip[t] ? frames[t] : store.get(noise.frame);
    SampleList targets;
    if (options_.sample_targets) targets = other_samples(frame->spp, noise.samples);
    SampleList noisy = noisy_samples(options_.noisy, frame->spp, noise.samples);
    auto checked = store.get_intact(noise.frame, frame, augmentation.tiles(),
                                    targets.empty() && noisy.empty() ? noise.samples : SampleList());
    crops.push_back(
        {std::move(checked), augmentation, std::move(noise.samples), std::move(targets), std::move(noisy)});
  }
  return crops;
}

}  // namespace ld
