#include "dataset/training_set.h"

#include "core/error.h"

namespace ld {

TrainingSet::TrainingSet(FrameStore store, std::vector<std::string> features, TrainingSetOptions options)
    : store_(std::move(store)), features_(std::move(features)), options_(options) {
  if (static_cast<int64_t>(store_.size()) < options_.batch)
    fail_usage(
        "data.batch: {} crops a step come from different frames, but the split has {}; render more frames or "
        "set data.batch={}",
        options_.batch, store_.size(), store_.size());
  for (size_t i = 0; i < store_.size(); ++i)
    if (store_.width(i) < options_.crop || store_.height(i) < options_.crop)
      fail_usage(
          "data.crop: frame {} has {}x{} pixels, smaller than the crop of {}; set data.crop={} or less",
          store_.name(i), store_.width(i), store_.height(i), options_.crop,
          std::min(store_.width(i), store_.height(i)));
}

TrainingSet::~TrainingSet() {
  if (next_.valid()) next_.wait();
}

Batch TrainingSet::batch(int64_t step) {
  if (next_.valid() && next_step_ != step) next_.get();  // prepared for another step than the caller asks for
  Batch current = next_.valid() ? next_.get() : make(step);
  next_step_ = step + 1;
  next_ = std::async(std::launch::async, [this, step] { return make(step + 1); });
  return current;
}

Batch TrainingSet::make(int64_t step) {
  const int64_t epoch = step / steps_per_epoch();
  RandomStream order(options_.seed, RandomPurpose::data_order, static_cast<uint32_t>(epoch));
  const std::vector<uint32_t> shuffled = random_permutation(order, static_cast<uint32_t>(store_.size()));
  const auto first = static_cast<size_t>(step % steps_per_epoch() * options_.batch);

  std::vector<Frame> crops;
  std::vector<torch::Tensor> references;
  for (size_t i = 0; i < static_cast<size_t>(options_.batch); ++i) {
    const std::shared_ptr<const StoredFrame> stored = store_.get(shuffled[first + i]);
    RandomStream stream(options_.seed, RandomPurpose::augmentation, static_cast<uint32_t>(step),
                        static_cast<uint32_t>(i));
    const Augmentation augmentation =
        random_augmentation(stream, stored->frame.width, stored->frame.height,
                            static_cast<int>(options_.crop), options_.flips, options_.rotations);
    crops.push_back(augment(stored->frame, augmentation));
    references.push_back(to_tensor(augment(stored->reference, augmentation)));
  }
  return {make_network_input(crops, features_), torch::stack(references)};
}

}  // namespace ld
