// Validation tells how steady sequences are.
#include <gtest/gtest.h>

#include <mutex>

#include "metrics/metric.h"
#include "tests/support/moving_frame.h"
#include "tests/support/ranks.h"
#include "tests/training/tiny_training.h"
#include "training/sequence_watch.h"
#include "training/validation.h"

namespace ld {
namespace {

/// Sequences of so many moving frames, behind what is in the folder; their references are of one brightness
/// each.
void add_moving_sequences(const std::filesystem::path& folder, const std::vector<int>& lengths) {
  std::filesystem::create_directories(folder);
  Manifest manifest;
  for (size_t q = 0; q < lengths.size(); ++q)
    for (int i = 0; i < lengths[q]; ++i) {
      ManifestFrame entry;
      entry.name = fmt::format("moving_{}_{}", q, i);
      entry.split = "validation";
      entry.sequence = 100 + static_cast<int64_t>(q);
      entry.position = i;
      const Frame frame = moving_frame(16, 16, 2, static_cast<uint32_t>(10 * q) + static_cast<uint32_t>(i));
      write_frame(frame_path(folder, entry.name), frame);
      Image reference(16, 16, 3);
      std::fill(reference.pixels.begin(), reference.pixels.end(), 0.5F);
      write_image(reference_path(folder, entry.name), reference);
      manifest.frames.push_back(entry);
    }
  add_to_manifest(folder, manifest);
}

const std::vector<std::string> kFeatures = {"radiance", "normal"};  // no flow: what moved is in the files

Validation sequences_of(const std::filesystem::path& folder, bool measured = true, int64_t pictures = 1,
                        ValidationSamples samples = {}) {
  std::vector<std::unique_ptr<FrameStore>> stores;
  stores.push_back(std::make_unique<FrameStore>(folder, "validation", kFeatures, CacheOptions{"none", 0}));
  return Validation(std::move(stores), pictures, samples, measured);
}

Compared mean_of(const NetworkInput& input, const torch::Tensor& reference, SequenceState& /*state*/) {
  const torch::Tensor mean = input.radiance.mean(1);
  return {mean, mean, reference};
}

std::optional<ValidationResult> run_on(const Validation& validation, ProcessGroup& group) {
  return validation.run(mean_of, kFeatures, make_loss("l1"), group, [] { return false; });
}

TEST(SequenceValidation, MeasuresWhatTheMeterDoes) {
  const TemporaryFolder folder;
  add_moving_sequences(folder.path(), {5, 1, 4});
  ProcessGroup alone{ProcessGroupOptions{}};
  const auto result = run_on(sequences_of(folder.path()), alone);
  std::vector<double> sums(sequence_measures().size()), counts(sums.size());
  for (const auto& [q, length] : {std::pair(0, 5), std::pair(2, 4)}) {
    SequenceGround ground;
    SequenceMeter meter;
    for (int i = 0; i < length; ++i) {
      Faults faults;
      const Frame frame =
          read_frame(frame_path(folder.path(), fmt::format("moving_{}_{}", q, i)), {"radiance"}, faults);
      Image reference(16, 16, 3);
      std::fill(reference.pixels.begin(), reference.pixels.end(), 0.5F);
      ground.advance(surface_guides(frame), reference);
      meter.add(ground, mean_radiance(frame));
    }
    const std::vector<double> values = meter.scores(ground, meter).values;
    for (size_t m = 0; m < values.size(); ++m)
      if (std::isfinite(values[m])) {
        sums[m] += values[m];
        counts[m] += 1;
      }
  }
  EXPECT_EQ(counts[0], 2) << "both sequences have a TE";
  for (size_t m = 0; m < sums.size(); ++m) {
    const std::string& name = sequence_measures()[m].name;
    ASSERT_EQ(result->scores.count(name), counts[m] > 0 ? 1U : 0U) << name;
    if (counts[m] > 0) {
      EXPECT_NEAR(result->scores.at(name), sums[m] / counts[m], 1e-4 * std::abs(sums[m])) << name;
    }
  }
  ASSERT_TRUE(result->strip);
  EXPECT_EQ(result->strip->name, "moving_0_0");
  EXPECT_EQ(result->strip->image.width, 5 * 16);
  EXPECT_EQ(result->strip->image.height, 3 * 16);
  EXPECT_EQ(result->strip->image.at(1, 79, 47), 0.5F) << "the last reference";
}

TEST(SequenceValidation, NothingIsMeasuredWhereNobodyAsksOrNothingFollows) {
  const TemporaryFolder folder;
  add_moving_sequences(folder / "sequence", {3});
  add_moving_sequences(folder / "stills", {1, 1});
  ProcessGroup alone{ProcessGroupOptions{}};
  EXPECT_TRUE(sequences_of(folder / "sequence").measures_sequences());
  for (const Validation& validation :
       {sequences_of(folder / "sequence", false), sequences_of(folder / "stills")}) {
    EXPECT_FALSE(validation.measures_sequences());
    const auto result = run_on(validation, alone);
    EXPECT_FALSE(result->strip);
    EXPECT_EQ(result->scores.size(), 1 + metrics().size());
  }
  EXPECT_FALSE(sequences_of(folder / "sequence", true, 1, {0, true}).measures_sequences());
  EXPECT_FALSE(run_on(sequences_of(folder / "sequence", true, 0), alone)->strip) << "run.images: 0";
}

TEST(SequenceValidation, TheScoresDoNotDependOnTheProcesses) {
  const TemporaryFolder folder;
  add_moving_sequences(folder.path(), {3, 4, 2});
  const Validation validation = sequences_of(folder.path());
  ProcessGroup alone{ProcessGroupOptions{}};
  const auto expected = run_on(validation, alone);
  EXPECT_EQ(expected->scores.count("te"), 1U);
  std::mutex mutex;
  run_ranks(2, [&](std::unique_ptr<ProcessGroup> group) {
    const auto result = run_on(validation, *group);
    const std::lock_guard<std::mutex> lock(mutex);
    EXPECT_EQ(result->scores, expected->scores);
    EXPECT_EQ(result->strip.has_value(), group->is_root());
  });
}

// metrics.csv has the columns, and an interrupted run the same bytes.
TEST(SequenceValidation, ATrainingOnClipsWritesThemDown) {
  const TemporaryFolder folder;
  TrainConfig config = two_sequences(folder / "data");
  add_moving_sequences(folder / "data", {3});
  config.run = {4, 1, 2, 1};
  const auto train = [&](const char* run, int64_t steps) {
    config.run.max_steps = steps;
    Trainer(config, folder / run).train();
    return read_file(folder / run / "metrics.csv");
  };
  const std::string whole = train("whole", 4);
  train("parts", 2);  // the end of a part is validated, so it is where the whole is, too
  EXPECT_EQ(train("parts", 4), whole);
  const std::string header = whole.substr(0, whole.find('\n'));
  EXPECT_NE(header.find(",te,tpsnr,trmae,"), std::string::npos) << header;
  // The rows of validations have a TE, the others none.
  const auto column = static_cast<size_t>(std::count(
                          header.begin(), header.begin() + std::ptrdiff_t(header.find(",te,")), ',')) +
                      1;
  std::istringstream rows(whole.substr(header.size() + 1));
  int64_t step = 0;
  for (std::string row; std::getline(rows, row);) {
    std::istringstream cells(row);
    std::string cell;
    for (size_t i = 0; i <= column; ++i) std::getline(cells, cell, ',');
    EXPECT_EQ(!cell.empty(), ++step % 2 == 0) << row;
  }
  EXPECT_EQ(step, 4);
  config.data.clip = 1;
  const std::string stills = train("stills", 4);
  EXPECT_EQ(stills.find(",te,"), std::string::npos);
}

TEST(SequenceWatch, StripsAreMadeSmaller) {
  Image image(5, 3, 1);
  for (size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = static_cast<float>(i);
  EXPECT_EQ(shrunk(image, 1).pixels, image.pixels);
  const Image small = shrunk(image, 2);
  EXPECT_EQ(small.width, 3);
  EXPECT_EQ(small.height, 2);
  EXPECT_EQ(small.at(0, 0, 0), 3);     // 0, 1, 5, 6
  EXPECT_EQ(small.at(0, 2, 0), 6.5F);  // 4, 9
  EXPECT_EQ(small.at(0, 2, 1), 14);
  SequenceWatch watch;
  SurfaceGuides guides;
  guides.width = 520;
  guides.height = 4;
  guides.surface.resize(size_t{520} * 4);
  for (std::vector<float>* plane : {&guides.depth, &guides.flow_x, &guides.flow_y, &guides.flow_z})
    plane->assign(size_t{520} * 4, 1);
  const Image wide(520, 4, 3);
  EXPECT_EQ(watch.strip().width, 0);
  for (int i = 0; i < kStripFrames + 3; ++i) watch.add(guides, wide, wide, wide, true);
  EXPECT_EQ(watch.strip().width, kStripFrames * 174) << "a third of 520 each";
  EXPECT_EQ(watch.strip().height, 3 * 2);
}

}  // namespace
}  // namespace ld
