#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <set>

#include "core/error.h"
#include "core/file_io.h"
#include "tests/dataset/tiny_training_set.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

bool same(const Batch& a, const Batch& b) {
  return a.input.features.equal(b.input.features) && a.input.radiance.equal(b.input.radiance) &&
         a.input.valid.equal(b.input.valid) && a.reference.equal(b.reference);
}

TEST(TrainingSet, BatchesDependOnSeedAndStepAlone) {
  const TemporaryFolder folder;
  write_tiny_dataset(folder.path(), 5);
  TrainingSet first = training_set(folder.path(), options(8, 2)),
              other = training_set(folder.path(), options(8, 2, 0, 2)),
              uncached = training_set(folder.path(), options(8, 2), {"none", 0}),
              in_memory = training_set(folder.path(), options(8, 2), {"none", 1 << 20});
  EXPECT_EQ(first.batches_per_epoch(), 2);
  std::vector<std::unique_ptr<TrainingSet>> many;
  for (const int workers : {1, 2, 5}) {
    std::vector<WeightedStore> sets;
    sets.push_back({store(folder.path()), 1});
    many.push_back(std::make_unique<TrainingSet>(std::move(sets), kFeatures, options(8, 2, workers)));
  }
  for (const int64_t step : {0, 1, 2, 7, 3, 4, 5}) {
    const Batch batch = first.batch(step);
    EXPECT_TRUE(same(batch, uncached.batch(step)));
    EXPECT_TRUE(same(batch, in_memory.batch(step)));
    EXPECT_FALSE(same(batch, other.batch(step)));
    for (const std::unique_ptr<TrainingSet>& set : many) EXPECT_TRUE(same(batch, set->batch(step)));
    // The tiny data set's reference is the mean of the samples: pixels and reference were cut alike.
    EXPECT_TRUE(torch::allclose(batch.input.radiance.mean(1), batch.reference, 1e-2, 1e-3));
  }
}

TEST(TrainingSet, ThePartsOfSeveralProcessesAreTheWholeBatch) {
  const TemporaryFolder folder;
  write_tiny_dataset(folder.path(), 7);
  TrainingSet whole = training_set(folder.path(), options(8, 7));
  EXPECT_EQ(whole.batch_share(), 1);
  for (const int processes : {1, 2, 3, 7}) {
    std::vector<torch::Tensor> radiance, references;
    double shares = 0;
    for (int rank = 0; rank < processes; ++rank) {
      TrainingSetOptions part = options(8, 7);
      part.rank = rank;
      part.processes = processes;
      TrainingSet set = training_set(folder.path(), part);
      EXPECT_EQ(set.batches_per_epoch(), whole.batches_per_epoch());
      const Batch batch = set.batch(3);
      EXPECT_EQ(set.batch_share(), static_cast<double>(batch.reference.size(0)) / 7);
      shares += set.batch_share();
      radiance.push_back(batch.input.radiance);
      references.push_back(batch.reference);
    }
    EXPECT_NEAR(shares, 1, 1e-15);
    EXPECT_TRUE(torch::cat(radiance).equal(whole.batch(3).input.radiance)) << processes;
    EXPECT_TRUE(torch::cat(references).equal(whole.batch(3).reference)) << processes;
  }
  TrainingSetOptions too_many = options(8, 7);
  too_many.processes = 8;
  EXPECT_ERROR(training_set(folder.path(), too_many), "set data.batch=8 or more, or start fewer processes");
}

TEST(TrainingSet, FramesOfSeveralSizesAndNumbersOfSamples) {
  const TemporaryFolder folder;
  write_tiny_dataset(folder / "a", 3, 37, 1);
  write_tiny_dataset(folder / "b", 2, 19, 3);
  std::vector<WeightedStore> sets;
  sets.push_back({store(folder / "a"), 1});
  sets.push_back({store(folder / "b"), 3});
  TrainingSet set(std::move(sets), kFeatures, options(17, 4, 2));
  EXPECT_EQ(set.batches_per_epoch(), 1);
  for (int64_t step = 0; step < 6; ++step) {
    const Batch batch = set.batch(step);
    ASSERT_EQ(batch.input.features.sizes(), (std::vector<int64_t>{4, 3, 6, 17, 17}));
    // One crop of `a` for three of `b`; what `a` lacks is filled up with samples that are not valid.
    const torch::Tensor drawn = batch.input.valid.sum({1, 2, 3, 4});
    int few = 0;
    for (int64_t b = 0; b < 4; ++b) {
      const bool one = drawn[b].item<float>() == 17 * 17;
      few += one;
      EXPECT_EQ(drawn[b].item<float>(), (one ? 1 : 3) * 17 * 17);
      if (one) {
        EXPECT_EQ(batch.input.features[b].slice(0, 1).abs().sum().item<float>(), 0);
        EXPECT_EQ(batch.input.radiance[b].slice(0, 1).abs().sum().item<float>(), 0);
      }
    }
    EXPECT_EQ(few, 1) << "step " << step;
  }
}

/// Which of the samples of crop b of `all` are those of crop b of `drawn`, in their order; checks the rest.
SampleList drawn_of(const Batch& all, const Batch& drawn, int64_t b) {
  EXPECT_TRUE(drawn.reference[b].equal(all.reference[b])) << "another crop, or another turn";
  SampleList samples;
  for (int64_t i = 0; i < drawn.input.radiance.size(1); ++i)
    for (int64_t s = 0; s < all.input.radiance.size(1); ++s)
      if (drawn.input.radiance[b][i].equal(all.input.radiance[b][s])) {
        EXPECT_TRUE(drawn.input.features[b][i].equal(all.input.features[b][s]));
        EXPECT_TRUE(drawn.input.valid[b][i].equal(all.input.valid[b][s]));
        samples.push_back(static_cast<int>(s));
      }
  EXPECT_EQ(samples.size(), static_cast<size_t>(drawn.input.radiance.size(1)));
  for (size_t i = 1; i < samples.size(); ++i) EXPECT_LT(samples[i - 1], samples[i]);
  return samples;
}

TEST(TrainingSet, DrawsHowManySamplesAndWhich) {
  constexpr int kSpp = 6, kSteps = 300;
  const TemporaryFolder folder;
  write_tiny_dataset(folder.path(), 4, 16, kSpp);
  TrainingSetOptions some = options(8, 4);
  some.samples = {1, 4};
  TrainingSetOptions other_seed = some;
  other_seed.seed = 2;
  TrainingSetOptions threads = some;
  threads.workers = 3;
  TrainingSet all = training_set(folder.path(), options(8, 4)), set = training_set(folder.path(), some),
              uncached = training_set(folder.path(), some, {"none", 1 << 24}),
              threaded = training_set(folder.path(), threads),
              other = training_set(folder.path(), other_seed);
  std::map<int64_t, int> counts;
  std::map<int, double> often;
  int crops_alike = 0, seeds_alike = 0;
  double drawn = 0;
  for (int64_t step = 0; step < kSteps; ++step) {
    const Batch whole = all.batch(step), batch = set.batch(step);
    ASSERT_EQ(whole.input.radiance.size(1), kSpp);
    const int64_t count = batch.input.radiance.size(1);
    ++counts[count];
    std::set<SampleList> lists;
    for (int64_t b = 0; b < 4; ++b) {
      const SampleList list = drawn_of(whole, batch, b);
      for (const int s : list) ++often[s];
      drawn += static_cast<double>(list.size());
      lists.insert(list);
    }
    if (lists.size() == 1) ++crops_alike;
    if (other.batch(step).input.radiance.size(1) == count) ++seeds_alike;
    if (step % 10 != 0) continue;
    EXPECT_TRUE(same(batch, uncached.batch(step)));
    EXPECT_TRUE(same(batch, threaded.batch(step)));
    EXPECT_TRUE(same(batch, set.batch(step)));
  }
  EXPECT_EQ(counts.size(), 4u);  // 1, 4: a third each; 2, 3: a sixth
  for (const auto& [count, found] : counts)
    EXPECT_NEAR(found / double{kSteps}, count == 1 || count == 4 ? 1 / 3.0 : 1 / 6.0, 0.08) << count;
  for (int s = 0; s < kSpp; ++s) EXPECT_NEAR(often[s] / drawn * kSpp, 1, 0.12) << s;
  EXPECT_LT(crops_alike, kSteps / 20);
  EXPECT_LT(seeds_alike, kSteps / 2);
  EXPECT_NE(set.describe(0, 1).find(" of samples "), std::string::npos) << set.describe(0, 1);
  EXPECT_EQ(all.describe(0, 1).find(" of samples "), std::string::npos);
}

TEST(TrainingSet, AllRanksDrawAsOneProcessDoes) {
  const TemporaryFolder folder;
  write_tiny_dataset(folder.path(), 7, 16, 9);
  TrainingSetOptions some = options(8, 7);
  some.samples = {1, 8};
  TrainingSet whole = training_set(folder.path(), some);
  for (int64_t step = 0; step < 12; ++step) {
    std::vector<torch::Tensor> features, references;
    for (int rank = 0; rank < 3; ++rank) {
      TrainingSetOptions part = some;
      part.rank = rank;
      part.processes = 3;
      const Batch batch = training_set(folder.path(), part).batch(step);
      features.push_back(batch.input.features);
      references.push_back(batch.reference);
    }
    EXPECT_TRUE(torch::cat(features).equal(whole.batch(step).input.features));
    EXPECT_TRUE(torch::cat(references).equal(whole.batch(step).reference));
  }
}

TEST(TrainingSet, FramesWithFewerSamplesThanABatchAreFilledUp) {
  const TemporaryFolder folder;
  write_tiny_dataset(folder / "a", 2, 16, 2);
  write_tiny_dataset(folder / "b", 2, 16, 8);
  const auto both = [&] {
    std::vector<WeightedStore> sets;
    sets.push_back({store(folder / "a"), 1});
    sets.push_back({store(folder / "b"), 1});
    return sets;
  };
  TrainingSetOptions six = options(8, 4);
  six.samples = {6, 6};
  EXPECT_ERROR(TrainingSet(both(), kFeatures, six),
               "data.samples: frame frame_0 has 2 samples a pixel, fewer than the 6");
  TrainingSetOptions some = six;
  some.samples = {2, 6};
  TrainingSet set(both(), kFeatures, some);
  bool filled = false;
  for (int64_t step = 0; step < 12; ++step) {
    const Batch batch = set.batch(step);
    const int64_t count = batch.input.valid.size(1);
    const torch::Tensor drawn = batch.input.valid.sum({1, 2, 3, 4}) / 64;
    EXPECT_EQ(drawn.eq(static_cast<double>(count)).sum().item<int64_t>(), count == 2 ? 4 : 2);
    EXPECT_EQ(drawn.eq(2).sum().item<int64_t>(), count == 2 ? 4 : 2);
    filled = filled || count > 2;
    EXPECT_TRUE((batch.input.radiance * (1 - batch.input.valid)).eq(0).all().item<bool>());
  }
  EXPECT_TRUE(filled);
}

TEST(TrainingSet, OneSample) {
  const TemporaryFolder folder;
  write_tiny_dataset(folder.path(), 4, 16, 3);
  TrainingSetOptions one = options(8, 4);
  one.samples = {1, 1};
  TrainingSet all = training_set(folder.path(), options(8, 4)), set = training_set(folder.path(), one);
  for (int64_t step = 0; step < 8; ++step) {
    const Batch batch = set.batch(step);
    ASSERT_EQ(batch.input.features.sizes(), (std::vector<int64_t>{4, 1, 6, 8, 8}));
    for (int64_t b = 0; b < 4; ++b) EXPECT_EQ(drawn_of(all.batch(step), batch, b).size(), 1u);
    EXPECT_EQ(set.batch_with(step, 2).input.features.size(1), 2);
  }
}

TEST(TrainingSet, ExposureScalesSamplesAndReference) {
  const TemporaryFolder folder;
  write_tiny_dataset(folder.path(), 4);
  TrainingSetOptions exposed = options(8, 4);
  exposed.augmentation.exposure = 3;
  TrainingSet plain = training_set(folder.path(), options(8, 4)), set = training_set(folder.path(), exposed);
  const Batch before = plain.batch(0), after = set.batch(0);
  for (int64_t b = 0; b < 4; ++b) {
    const torch::Tensor factor = after.reference[b].sum() / before.reference[b].sum();
    EXPECT_GE(factor.item<float>(), 0.125F);
    EXPECT_LE(factor.item<float>(), 8.0F);
    EXPECT_GT((factor - 1).abs().item<float>(), 0.01F);
    EXPECT_TRUE(torch::allclose(after.reference[b], factor * before.reference[b], 1e-5));
    EXPECT_TRUE(torch::allclose(after.input.radiance[b], factor * before.input.radiance[b], 1e-5));
    EXPECT_TRUE(after.input.features[b].slice(1, 0, 3).equal(before.input.features[b].slice(1, 0, 3)));
    EXPECT_FALSE(after.input.features[b].slice(1, 3).equal(before.input.features[b].slice(1, 3)));
  }
}

// A factor for each channel, the same for samples and reference, so that their ratio stays.
TEST(TrainingSet, TintScalesEachChannelOfSamplesAndReference) {
  const TemporaryFolder folder;
  write_tiny_dataset(folder.path(), 4);
  TrainingSetOptions tinted = options(8, 4);
  tinted.augmentation.tint = 2;
  TrainingSet plain = training_set(folder.path(), options(8, 4)), set = training_set(folder.path(), tinted);
  const Batch before = plain.batch(0), after = set.batch(0);
  std::set<float> factors;
  for (int64_t b = 0; b < 4; ++b)
    for (int64_t c = 0; c < 3; ++c) {
      const torch::Tensor factor = after.reference[b][c].sum() / before.reference[b][c].sum();
      EXPECT_GE(factor.item<float>(), 0);
      EXPECT_LE(factor.item<float>(), 2);
      factors.insert(factor.item<float>());
      EXPECT_TRUE(torch::allclose(after.reference[b][c], factor * before.reference[b][c], 1e-5));
      const auto radiance = [&](const Batch& batch) { return batch.input.radiance[b].select(1, c); };
      EXPECT_TRUE(torch::allclose(radiance(after), factor * radiance(before), 1e-5));
    }
  EXPECT_EQ(factors.size(), 12U);
}

// A crop lacks an optional feature in its share of the time, all of it; other features and the light are as
// ever.
TEST(TrainingSet, OptionalFeaturesAreDropped) {
  const TemporaryFolder folder;
  write_tiny_dataset(folder.path(), 8);
  TrainingSetOptions dropping = options(8, 4);
  dropping.optional = {"normal"};
  dropping.drop = 0.25;
  const TrainingSet set = training_set(folder.path(), dropping),
                    whole = training_set(folder.path(), options(8, 4));
  int dropped = 0;
  for (int64_t step = 0; step < 100; ++step) {
    const Batch batch = set.batch_with(step, 0), full = whole.batch_with(step, 0);
    EXPECT_TRUE(batch.input.radiance.equal(full.input.radiance));
    EXPECT_TRUE(batch.input.features.narrow(2, 3, 3).equal(full.input.features.narrow(2, 3, 3)));
    for (int64_t b = 0; b < 4; ++b) {
      const torch::Tensor normal = batch.input.features[b].narrow(1, 0, 3);
      const bool lacks = normal.eq(0).all().item<bool>();
      dropped += lacks ? 1 : 0;
      if (!lacks) {
        EXPECT_TRUE(normal.equal(full.input.features[b].narrow(1, 0, 3)));
      }
    }
  }
  EXPECT_NEAR(dropped, 100, 44);  // five deviations
}

TEST(TrainingSet, WhatIsWrongWithAFrameReachesTheCaller) {
  const TemporaryFolder folder;
  write_tiny_dataset(folder.path(), 2);
  for (const int workers : {0, 2}) {
    TrainingSet set = training_set(folder.path(), options(8, 2, workers), {"none", 0});
    EXPECT_NO_THROW(set.batch(0));
    const auto path = reference_path(folder.path(), "frame_1");
    const std::string good = read_file(path);
    std::ofstream(path) << "no picture";
    EXPECT_ERROR(set.batch(7), "frame_1.reference.exr");
    std::ofstream(path) << good;
    EXPECT_NO_THROW(set.batch(9));
  }
}

TEST(TrainingSet, TooFewFramesAndTooLargeCropsAreErrors) {
  const TemporaryFolder folder;
  write_tiny_dataset(folder.path(), 3);
  EXPECT_THROW(training_set(folder.path(), options(8, 4)), UsageError);
  EXPECT_THROW(training_set(folder.path(), options(17, 1)), UsageError);
}

}  // namespace
}  // namespace ld
