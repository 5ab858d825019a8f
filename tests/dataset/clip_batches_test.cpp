// Batches of clips: one crop and one turn a clip, the frames in their order, samples drawn for each frame.
#include <gtest/gtest.h>

#include <set>

#include "core/error.h"
#include "tests/dataset/tiny_training_set.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_sequences.h"

namespace ld {
namespace {

const std::vector<std::string> kMoving = {"radiance", "normal", "flow"};

TrainingSet clip_set(const std::filesystem::path& folder, const TrainingSetOptions& options,
                     const std::vector<std::string>& features = kMoving) {
  std::vector<WeightedStore> sets;
  sets.push_back({std::make_unique<FrameStore>(folder, "train", features, CacheOptions{}), 1});
  return TrainingSet(std::move(sets), features, options);
}

TrainingSetOptions clip_options(int clip, int64_t batch) {
  TrainingSetOptions some = options(8, batch);
  some.clip = clip;
  return some;
}

bool equal(const Batch& a, const Batch& b) {
  return a.input.features.equal(b.input.features) && a.input.radiance.equal(b.input.radiance) &&
         a.input.valid.equal(b.input.valid) && a.reference.equal(b.reference);
}

/// What a batch of single frames has always been: crop, turn and samples from the streams of its slot.
Batch batch_by_hand(FrameStore& frames, int64_t step, int64_t count, const SampleRange& range) {
  const auto stream = [&](int64_t place, uint32_t purpose) {
    return RandomStream(1, RandomPurpose::augmentation, static_cast<uint32_t>(step),
                        static_cast<uint32_t>(place), purpose);
  };
  const auto size = static_cast<int64_t>(frames.size()), steps = size / count;
  RandomStream order_stream(1, RandomPurpose::data_order, static_cast<uint32_t>(step / steps)),
      how_many = stream(0, 2);
  const std::vector<uint32_t> order = random_permutation(order_stream, static_cast<uint32_t>(size));
  const int samples = range.all() ? 0 : draw_sample_count(how_many, range);
  std::vector<FrameCrop> crops;
  for (int64_t place = 0; place < count; ++place) {
    const auto frame = frames.get(order[static_cast<size_t>(step % steps * count + place)]);
    RandomStream crop = stream(place, 0), which = stream(place, 1);
    const Augmentation augmentation =
        random_augmentation(crop, {frame.get()}, options(8, count).augmentation);
    crops.push_back(
        {frame, augmentation, samples == 0 ? SampleList() : draw_samples(which, frame->spp, samples)});
  }
  return make_batch(crops, kMoving);
}

TEST(ClipBatches, OfOneFrameAreThoseOfSingleFramesBitForBit) {
  const TemporaryFolder folder;
  write_tiny_sequences(folder.path(), {5, 3, 1}, "train", 16, 6);
  FrameStore frames(folder.path(), "train", kMoving, {});
  for (const SampleRange range : {SampleRange{}, SampleRange{1, 4}}) {
    TrainingSetOptions one = clip_options(1, 4);
    one.samples = range;
    TrainingSet set = clip_set(folder.path(), one);
    EXPECT_EQ(set.batches_per_epoch(), 2);
    for (int64_t step = 0; step < 9; ++step) {
      const Batch batch = set.batch(step);
      EXPECT_EQ(batch.clip, 1);
      EXPECT_TRUE(equal(batch, batch_by_hand(frames, step, 4, range))) << step;
    }
  }
}

TEST(ClipBatches, OneCropAndTurnForAllFramesInTheirOrder) {
  constexpr int kClip = 5;
  const TemporaryFolder folder;
  write_tiny_sequences(folder.path(), {8, 3, 7, 5});
  TrainingSet set = clip_set(folder.path(), clip_options(kClip, 3));
  EXPECT_EQ(set.batches_per_epoch(), 1) << "20 frames lie in clips, which makes 4 clips an epoch";
  std::set<int> starts;
  std::set<std::vector<float>> turns;
  for (int64_t step = 0; step < 40; ++step) {
    const Batch batch = set.batch(step);
    ASSERT_EQ(batch.reference.sizes(), (std::vector<int64_t>{3 * kClip, 3, 8, 8}));
    const torch::Tensor reference = batch.by_clip(batch.reference),
                        radiance = batch.by_clip(batch.input.radiance),
                        flow = batch.by_clip(batch.input.features).narrow(3, 6, 2);
    ASSERT_EQ(reference.sizes(), (std::vector<int64_t>{3, kClip, 3, 8, 8}));
    ASSERT_EQ(radiance.sizes(), (std::vector<int64_t>{3, kClip, 2, 3, 8, 8}));
    for (int64_t b = 0; b < 3; ++b) {
      const auto start = static_cast<int>(reference[b][0][2].min().item<float>());
      starts.insert(start);
      for (int64_t t = 0; t < kClip; ++t) {
        EXPECT_TRUE(reference[b][t].narrow(0, 0, 2).equal(reference[b][0].narrow(0, 0, 2))) << "another crop";
        EXPECT_TRUE(reference[b][t][2].eq(static_cast<double>(start + t)).all().item<bool>())
            << "not the next frame of this sequence";
        EXPECT_TRUE(radiance[b][t][0][1].equal(reference[b][t][2])) << "samples of another frame";
        EXPECT_TRUE(flow[b][t].equal(flow[b][0]));
      }
      // To the right by 16 pixels is where x grows in the turned picture; the network sees half of the bound.
      const torch::Tensor x = reference[b][0][0];
      const std::vector<float> right = {(x[0][1] - x[0][0]).item<float>(), (x[1][0] - x[0][0]).item<float>()};
      for (int64_t c = 0; c < 2; ++c)
        EXPECT_TRUE(flow[b][0][0][c].eq(0.5 * right[static_cast<size_t>(c)]).all().item<bool>());
      turns.insert(right);
    }
  }
  EXPECT_EQ(turns.size(), 4u);
  EXPECT_EQ(starts, (std::set<int>{0, 1, 2, 3, 200, 201, 202, 300}));
}

/// The numbers of the samples of each row [S, 3, H, W].
std::vector<int> samples_of(const torch::Tensor& radiance) {
  std::vector<int> numbers;
  for (int64_t s = 0; s < radiance.size(0); ++s)
    numbers.push_back(static_cast<int>(radiance[s][0].min().item<float>()) - 1);
  return numbers;
}

TEST(ClipBatches, SamplesOfEachFrameAreDrawnIndependently) {
  constexpr int kSteps = 150, kSpp = 8;
  const TemporaryFolder folder;
  write_tiny_sequences(folder.path(), {6, 6}, "train", 8, kSpp);
  TrainingSetOptions some = clip_options(3, 4);
  some.samples = {2, 2};
  TrainingSet set = clip_set(folder.path(), some);
  int alike[3] = {}, often[3][kSpp] = {};
  for (int64_t step = 0; step < kSteps; ++step) {
    const Batch batch = set.batch(step);
    for (int64_t b = 0; b < 4; ++b) {
      std::vector<int> drawn[3];
      for (int64_t t = 0; t < 3; ++t) {
        drawn[t] = samples_of(batch.by_clip(batch.input.radiance)[b][t]);
        ASSERT_EQ(drawn[t].size(), 2u);
        for (const int s : drawn[t]) ++often[t][s];
      }
      for (int t = 0; t < 3; ++t) alike[t] += drawn[t] == drawn[(t + 1) % 3] ? 1 : 0;
    }
  }
  // Two of eight: 28 pairs, so two frames draw the same one in 28 times; five deviations.
  constexpr double kDraws = 4 * kSteps;
  for (const int times : alike) EXPECT_NEAR(times, kDraws / 28, 23);
  for (const auto& of_frame : often)
    for (const int times : of_frame) EXPECT_NEAR(times, kDraws / 4, 53);
}

TEST(ClipBatches, ProcessesAndAccumulatedBatchesShareWholeClips) {
  const TemporaryFolder folder;
  write_tiny_sequences(folder.path(), {6, 6, 6, 6}, "train", 16, 4);
  const auto with = [&](int64_t batch, int64_t accumulate, int rank, int processes, int workers = 0) {
    TrainingSetOptions some = clip_options(3, batch);
    some.accumulate = accumulate;
    some.samples = {1, 3};
    some.optional = {"flow"};
    some.drop = 0.5;
    some.rank = rank;
    some.processes = processes;
    some.workers = workers;
    return some;
  };
  TrainingSet whole = clip_set(folder.path(), with(4, 1, 0, 1)),
              threads = clip_set(folder.path(), with(4, 1, 0, 1, 2));
  int dropped = 0;
  for (int64_t step = 0; step < 6; ++step) {
    const Batch expected = whole.batch(step);
    EXPECT_TRUE(equal(expected, threads.batch(step)));
    std::vector<torch::Tensor> features, references;
    for (int64_t part = 0; part < 2; ++part)
      for (int rank = 0; rank < 2; ++rank) {
        const Batch batch = clip_set(folder.path(), with(2, 2, rank, 2)).batch(2 * step + part);
        EXPECT_EQ(batch.reference.size(0), 3);
        features.push_back(batch.input.features);
        references.push_back(batch.reference);
      }
    EXPECT_TRUE(torch::cat(features).equal(expected.input.features));
    EXPECT_TRUE(torch::cat(references).equal(expected.reference));
    // A clip lacks a feature in all of its frames or in none; something moves in every pixel.
    const torch::Tensor flow = expected.by_clip(expected.input.features).narrow(3, 6, 2);
    for (int64_t b = 0; b < 4; ++b) {
      const torch::Tensor moves = flow[b].abs().amax({1, 2, 3, 4}).gt(0);
      EXPECT_TRUE(moves.eq(moves[0]).all().item<bool>());
      dropped += moves[0].item<bool>() ? 0 : 1;
    }
  }
  EXPECT_GT(dropped, 4);
  EXPECT_LT(dropped, 20);
}

TEST(ClipBatches, HalfOfThemRunBackwardsWhereAsked) {
  const TemporaryFolder folder;
  write_tiny_sequences(folder.path(), {6, 6});
  TrainingSetOptions both = clip_options(4, 2);
  both.augmentation.reversal = true;
  EXPECT_ERROR(clip_set(folder.path(), both), "data.reversal: the network reads 'flow'");
  TrainingSet forwards = clip_set(folder.path(), clip_options(4, 2), {"radiance", "time"}),
              set = clip_set(folder.path(), both, {"radiance", "time"});
  int backwards = 0;
  for (int64_t step = 0; step < 60; ++step) {
    const Batch expected = forwards.batch(step), batch = set.batch(step);
    for (int64_t b = 0; b < 2; ++b) {
      const torch::Tensor frames = batch.by_clip(batch.reference)[b],
                          plain = expected.by_clip(expected.reference)[b];
      const bool reversed = !frames.equal(plain);
      EXPECT_TRUE(frames.equal(reversed ? plain.flip(0) : plain));
      EXPECT_TRUE(
          batch.by_clip(batch.input.features)[b].narrow(2, 3, 1).eq(reversed ? 1 : 0).all().item<bool>())
          << "all samples were drawn when the shutter opened";
      backwards += reversed ? 1 : 0;
    }
  }
  EXPECT_NEAR(backwards, 60, 27);
}

// The blue of a reference is the number of its frame, the red of a sample is its own number plus one.
TEST(ClipBatches, SomeStopAndSomeFreezeWithOtherSamplesInEachFrame) {
  const TemporaryFolder folder;
  write_tiny_sequences(folder.path(), {9}, "train", 16, 8);
  TrainingSetOptions still = clip_options(5, 1);
  still.samples = {1, 1};
  still.augmentation.stop = 0.3F;
  still.augmentation.freeze = 0.3F;
  const std::vector<std::string> features = {"radiance", "normal"};
  const TrainingSet set = clip_set(folder.path(), still, features);
  int stopped = 0, frozen = 0, moving = 0;
  std::set<int> frozen_at;
  constexpr int kClips = 400;
  for (int64_t number = 0; number < kClips; ++number) {
    const Batch batch = set.batch_with(number, 1);
    std::vector<int> frames;
    std::set<int> of_last;
    for (int64_t t = 0; t < 5; ++t) {
      frames.push_back(int(batch.reference[t][2].max().item<float>()));
      EXPECT_EQ(batch.input.radiance[t][0][1].max().item<float>(), float(frames.back()));
    }
    int stay = 4;
    while (stay > 0 && frames[size_t(stay - 1)] == frames[4]) --stay;
    for (int t = stay; t < 5; ++t) of_last.insert(int(batch.input.radiance[t][0][0].max().item<float>()));
    EXPECT_EQ(of_last.size(), size_t(5 - stay)) << "no sample twice";
    for (int t = 1; t <= stay; ++t) EXPECT_EQ(frames[size_t(t)], frames[size_t(t - 1)] + 1);
    (stay == 0 ? stopped : stay == 4 ? moving : frozen) += 1;
    if (stay > 0 && stay < 4) frozen_at.insert(stay);
    EXPECT_TRUE(equal(batch, set.batch_with(number, 1)));
  }
  EXPECT_NEAR(stopped, 0.3 * kClips, 30);
  EXPECT_NEAR(frozen, 0.3 * kClips, 30);
  EXPECT_NEAR(moving, 0.4 * kClips, 30);
  EXPECT_EQ(frozen_at, (std::set<int>{1, 2, 3}));
  // Crops and turns are those of clips that move on.
  TrainingSetOptions plain = still;
  plain.augmentation.stop = plain.augmentation.freeze = 0;
  const TrainingSet moving_set = clip_set(folder.path(), plain, features);
  for (int64_t number = 0; number < 20; ++number)
    EXPECT_TRUE(set.batch_with(number, 1).reference[0].equal(moving_set.batch_with(number, 1).reference[0]));
  EXPECT_ERROR(clip_set(folder.path(), still), "data.stop");
  still.augmentation.stop = 0.8F;
  EXPECT_ERROR(clip_set(folder.path(), still, features), "more than all clips");
}

TEST(ClipBatches, WhatCannotBeIsAnError) {
  const TemporaryFolder folder;
  write_tiny_sequences(folder.path(), {6});
  EXPECT_ERROR(clip_set(folder.path(), clip_options(7, 1)), "set data.clip=6 or less");
  EXPECT_ERROR(clip_set(folder.path(), clip_options(3, 3)),
               "come from different clips, but an epoch of the split has 2");
  FrameStore frames(folder.path(), "train", kMoving, {});
  Augmentation corner;
  corner.width = corner.height = 8;
  const FrameCrop crop = {frames.get(0), corner};
  EXPECT_ERROR(make_batch({crop, crop, crop}, kMoving, 2), "3 crops is not one of whole clips of 2");
  EXPECT_EQ(make_batch({crop, crop}, kMoving, 2).clip, 2);
  TrainingSet set = clip_set(folder.path(), clip_options(3, 1));
  EXPECT_NE(set.describe(0, 1).find("train_0_00+train_0_01+train_0_02 at "), std::string::npos)
      << set.describe(0, 1);
}

}  // namespace
}  // namespace ld
