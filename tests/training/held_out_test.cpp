#include "training/held_out.h"

#include <gtest/gtest.h>

#include "core/file_io.h"
#include "losses/relative_l2.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

/// A frame of noise about a bright square, some of its samples targets.
Batch noisy_batch(int64_t samples, int64_t height, int64_t width, double shared = 0) {
  torch::manual_seed(7);
  torch::Tensor truth = torch::full({1, 1, 3, height, width}, 0.5);
  truth.slice(4, width / 3, 2 * width / 3) = 4;
  const auto exponential = [&](int64_t count) {
    return -torch::rand({1, count, 3, height, width}).clamp_min(1e-6).log();
  };
  const torch::Tensor common = exponential(1);
  Batch batch;
  batch.input.radiance = truth * ((1 - shared) * exponential(samples) + shared * common);
  batch.input.valid = torch::ones({1, samples, 1, height, width});
  batch.reference = (truth * ((1 - shared) * exponential(2) + shared * common)).mean(1);
  return batch;
}

torch::Tensor truth_of(int64_t height, int64_t width) {
  torch::Tensor truth = torch::full({1, 3, height, width}, 0.5);
  truth.slice(3, width / 3, 2 * width / 3) = 4;
  return truth;
}

TEST(BlockErrors, AreTheMeansOfTheFormulaOverEachBlock) {
  const int64_t height = 37, width = 70;
  Batch batch = noisy_batch(3, height, width);
  batch.input.valid[0][1][0][3][4] = 0;
  const torch::Tensor denoised = 0.5 + torch::rand({1, 3, height, width});
  const std::vector<double> errors = block_errors(denoised, batch, 2);
  ASSERT_EQ(static_cast<int64_t>(errors.size()), blocks_of(70, 37));
  ASSERT_EQ(errors.size(), 6U);
  const auto radiance = batch.input.radiance.accessor<float, 5>();
  const auto valid = batch.input.valid.accessor<float, 5>();
  const auto mean = [&](int64_t c, int64_t y, int64_t x) {
    double sum = 0, drawn = 0;
    for (int64_t s = 0; s < 3; ++s)
      if (valid[0][s][0][y][x] > 0) sum += radiance[0][s][c][y][x], ++drawn;
    return sum / drawn;
  };
  const auto variance_of = [&](int64_t c, int64_t y, int64_t x) {
    double sum = 0, drawn = 0;
    for (int64_t s = 0; s < 3; ++s)
      if (valid[0][s][0][y][x] > 0) {
        const double d = radiance[0][s][c][y][x] - mean(c, y, x);
        sum += d * d, ++drawn;
      }
    return sum / std::max(drawn - 1, 1.0);
  };
  for (size_t block = 0; block < 6; ++block) {
    double sum = 0;
    int count = 0;
    const auto row = static_cast<int64_t>(block / 3), column = static_cast<int64_t>(block % 3);
    for (int64_t y = 32 * row; y < std::min(height, 32 * row + 32); ++y)
      for (int64_t x = 32 * column; x < std::min(width, 32 * column + 32); ++x)
        for (int64_t c = 0; c < 3; ++c, ++count) {
          double scale = 0, spread = 0;
          int taps = 0;
          for (int64_t j = std::max<int64_t>(y - 2, 0); j <= std::min(height - 1, y + 2); ++j)
            for (int64_t i = std::max<int64_t>(x - 2, 0); i <= std::min(width - 1, x + 2); ++i, ++taps)
              scale += mean(c, j, i);
          scale /= taps;
          for (int64_t j = std::max<int64_t>(y - 2, 0); j <= std::min(height - 1, y + 2); ++j)
            for (int64_t i = std::max<int64_t>(x - 2, 0); i <= std::min(width - 1, x + 2); ++i)
              spread += variance_of(c, j, i) / taps;
          const double error =
              denoised[0][c][y][x].item<double>() - batch.reference[0][c][y][x].item<double>();
          sum += (error * error - variance_of(c, y, x) / 2) / (scale * scale + spread + kRelativeL2Epsilon);
        }
    EXPECT_NEAR(errors[block], sum / count, 1e-5) << block;
  }
}

TEST(BlockErrors, TheTruthHasLessThanAnythingElseInTheMean) {
  const Batch batch = noisy_batch(6, 256, 256);
  const torch::Tensor truth = truth_of(256, 256);
  const std::vector<double> best = block_errors(truth, batch, 2);
  for (const double factor : {0.8, 0.95, 1.05, 1.2}) {
    const HeldOutComparison comparison = compare_blocks(best, block_errors(truth * factor, batch, 2));
    EXPECT_GT(comparison.now, comparison.beginning) << factor;
    EXPECT_FALSE(comparison.better());
  }
  EXPECT_TRUE(compare_blocks(block_errors(truth * 0.8, batch, 2), best).better());
}

TEST(BlockErrors, DifferByTheSquaredErrorInTheMean) {
  // 0.2 of the truth, over s^2 + v, both of which are about the truth's square.
  const Batch batch = noisy_batch(6, 512, 512);
  const torch::Tensor truth = truth_of(512, 512);
  const HeldOutComparison comparison =
      compare_blocks(block_errors(truth, batch, 2), block_errors(1.2 * truth, batch, 2));
  EXPECT_NEAR(comparison.now - comparison.beginning, 0.2 * 0.2 / 2, 0.005);
}

TEST(BlockErrors, AreFiniteWhateverTheRadiance) {
  for (const float value : {0.0F, 1e-40F, 1e-38F, 65504.0F, 3e38F}) {
    Batch batch = noisy_batch(2, 9, 9);
    batch.input.radiance.fill_(value);
    batch.reference.fill_(3e38F);
    for (const double error : block_errors(torch::full({1, 3, 9, 9}, -3e38F), batch, 1))
      EXPECT_TRUE(std::isfinite(error)) << value;
  }
}

TEST(SampleCorrelation, IsThatOfSamplesThatShareNoiseAlone) {
  const torch::Tensor truth = truth_of(128, 128);
  EXPECT_NEAR(*sample_correlation(truth, noisy_batch(6, 128, 128)), 0, 0.02);
  // Of two sums of independent noise of equal spread, a (1 - s) and b s.
  const auto expected = [](double s) { return s * s / (s * s + (1 - s) * (1 - s)); };
  for (const double shared : {0.3, 0.5})
    EXPECT_NEAR(*sample_correlation(truth, noisy_batch(6, 128, 128, shared)), expected(shared), 0.05)
        << shared;
  Batch repeated = noisy_batch(1, 128, 128);
  repeated.input.radiance = repeated.input.radiance.repeat({1, 4, 1, 1, 1});
  repeated.input.valid = repeated.input.valid.repeat({1, 4, 1, 1, 1});
  EXPECT_NEAR(*sample_correlation(truth, repeated), 1, 1e-6);
}

TEST(SampleCorrelation, APictureThatIsWrongEverywhereChangesLittle) {
  EXPECT_NEAR(*sample_correlation(0.7 * truth_of(128, 128), noisy_batch(6, 128, 128)), 0, 0.02);
}

TEST(SampleCorrelation, NeedsTwoSamplesAndNoise) {
  EXPECT_FALSE(sample_correlation(truth_of(16, 16), noisy_batch(1, 16, 16)));
  Batch still = noisy_batch(3, 16, 16);
  still.input.radiance = truth_of(16, 16).unsqueeze(1).repeat({1, 3, 1, 1, 1});
  EXPECT_FALSE(sample_correlation(truth_of(16, 16), still));
}

TEST(HeldOutFile, KeepsEveryBitAndDamageIsNoticed) {
  const TemporaryFolder folder;
  const std::vector<double> errors = {0.1, 1.0 / 3, 1e-300, 3.4e38, 0};
  write_beginning(folder.path(), errors);
  EXPECT_EQ(read_beginning(folder.path()), errors);
  const std::string whole = read_file(folder.path() / "held_out.csv");
  for (const std::string& damaged :
       {whole.substr(0, whole.size() - 3), std::string("block"), whole + "x\n"}) {
    write_file_atomically(folder.path() / "held_out.csv", damaged);
    EXPECT_ERROR(read_beginning(folder.path()), "damaged");
    EXPECT_ERROR(read_beginning(folder.path()), "begin a new run");
  }
  EXPECT_ERROR(compare_blocks({1, 2}, {1}), "1 blocks");
  EXPECT_ERROR(compare_blocks({1, 2}, {1}), "2 when the run began");
}

}  // namespace
}  // namespace ld
