// Gradients that are accumulated over several batches come from the crops of one larger batch.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <set>

#include "tests/dataset/tiny_training_set.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

TEST(TrainingSet, TheBatchesOfAStepAreTheLargerBatch) {
  const TemporaryFolder folder;
  write_tiny_dataset(folder.path(), 9, 16, 6);
  const auto with = [&](int64_t batch, int64_t accumulate, int rank = 0, int processes = 1) {
    TrainingSetOptions some = options(8, batch);
    some.accumulate = accumulate;
    some.samples = {1, 5};
    some.optional = {"normal"};
    some.drop = 0.5;
    some.rank = rank;
    some.processes = processes;
    return training_set(folder.path(), some);
  };
  TrainingSet whole = with(4, 1);
  EXPECT_EQ(whole.batches_per_epoch(), 2);
  for (const int64_t accumulate : {2, 4}) {
    TrainingSet parts = with(4 / accumulate, accumulate);
    EXPECT_EQ(parts.batches_per_epoch(), 2 * accumulate) << "the ninth frame is left out of both";
    for (int64_t step = 0; step < 7; ++step) {
      SCOPED_TRACE(fmt::format("{} batches, step {}", accumulate, step));
      std::vector<torch::Tensor> features, radiance, references;
      for (int64_t i = 0; i < accumulate; ++i) {
        const Batch part = parts.batch(step * accumulate + i);
        features.push_back(part.input.features);
        radiance.push_back(part.input.radiance);
        references.push_back(part.reference);
      }
      const Batch expected = whole.batch(step);
      EXPECT_TRUE(torch::cat(features).equal(expected.input.features));
      EXPECT_TRUE(torch::cat(radiance).equal(expected.input.radiance));
      EXPECT_TRUE(torch::cat(references).equal(expected.reference));
      EXPECT_EQ(parts.describe(step * accumulate, accumulate), whole.describe(step, 1));
    }
  }
  // Two processes share each batch: together they see the same crops.
  std::vector<torch::Tensor> references;
  for (int64_t i = 0; i < 2; ++i)
    for (int rank = 0; rank < 2; ++rank) references.push_back(with(2, 2, rank, 2).batch(2 * 5 + i).reference);
  EXPECT_TRUE(torch::cat(references).equal(whole.batch(5).reference));
}

TEST(TrainingSet, AStepMayTakeMoreCropsThanAnEpochHas) {
  const TemporaryFolder folder;
  write_tiny_dataset(folder.path(), 5);
  TrainingSetOptions many = options(8, 2);
  many.accumulate = 4;
  TrainingSet set = training_set(folder.path(), many);
  EXPECT_EQ(set.batches_per_epoch(), 2);
  std::set<std::string> seen;
  for (int64_t number = 0; number < 8; ++number) {
    EXPECT_EQ(set.batch(number).reference.size(0), 2);
    seen.insert(set.describe(number, 1));
  }
  EXPECT_EQ(seen.size(), 8u);
}

}  // namespace
}  // namespace ld
