#include <gtest/gtest.h>

#include "sequence/sequence_runs.h"
#include "sequence/sequence_state.h"

namespace ld {
namespace {

using Runs = std::vector<std::vector<size_t>>;

ManifestFrame placed(const std::string& name, int64_t sequence, int64_t position) {
  ManifestFrame frame;
  frame.name = name;
  frame.sequence = sequence;
  frame.position = position;
  return frame;
}

ManifestFrame still(const std::string& name) {
  ManifestFrame frame;
  frame.name = name;
  return frame;
}

TEST(SequenceRuns, FramesThatFollowOneAnotherByPositionAndNotByName) {
  EXPECT_EQ(sequence_runs({}), Runs{});
  EXPECT_EQ(sequence_runs({placed("a", 0, 0), placed("b", 0, 1), placed("c", 1, 2), placed("d", 1, 3)}),
            (Runs{{0, 1}, {2, 3}}));
  EXPECT_EQ(sequence_runs({placed("a", 7, 2), placed("b", 7, 1), placed("c", 7, 0)}), (Runs{{2, 1, 0}}));
  EXPECT_EQ(sequence_runs({placed("a", 4, 0), placed("b", 3, 0), placed("c", 4, 1), placed("d", 3, 1)}),
            (Runs{{0, 2}, {1, 3}}))
      << "runs come in the order of their first frames";
}

TEST(SequenceRuns, StillsAreRunsOfTheirOwnAndAGapEndsARun) {
  ManifestFrame half = placed("b", 0, 1);
  half.position.reset();
  EXPECT_EQ(sequence_runs({still("a"), half, still("c")}), (Runs{{0}, {1}, {2}}));
  EXPECT_EQ(sequence_runs({placed("a", 0, 0), placed("b", 0, 1), still("c"), placed("d", 0, 3)}),
            (Runs{{0, 1}, {2}, {3}}));
}

TEST(SequenceRuns, NoiseInstancesAreSequencesSideBySide) {
  EXPECT_EQ(sequence_runs({placed("f0", 0, 0), placed("f0_n1", 0, 0), placed("f1", 0, 1),
                           placed("f1_n1", 0, 1), placed("f2", 0, 2)}),
            (Runs{{0, 2, 4}, {1, 3}}));
  // Where the second instance of the middle is missing, it is two runs.
  EXPECT_EQ(sequence_runs({placed("f0", 0, 0), placed("f0_n1", 0, 0), placed("f1", 0, 1), placed("f2", 0, 2),
                           placed("f2_n1", 0, 2)}),
            (Runs{{0, 2, 3}, {1}, {4}}));
}

TEST(SequenceState, StartsAdvancesAndEnds) {
  SequenceState state;
  const auto history = [&](std::optional<SequencePlace> place, int width = 8, int height = 6,
                           bool cut = false) {
    state.advance(place, width, height, cut);
    EXPECT_EQ(state.memory.has_value(), state.history() > 0) << "kept at a start, or lost within a sequence";
    state.memory = 1;
    return state.history();
  };
  EXPECT_EQ(history(SequencePlace{3, -1}), 0);
  EXPECT_EQ(history(SequencePlace{3, 0}), 1);
  EXPECT_EQ(history(SequencePlace{3, 1}), 2);
  EXPECT_EQ(history(SequencePlace{3, 3}), 0) << "frame 2 is missing";
  EXPECT_EQ(history(SequencePlace{3, 4}), 1);
  EXPECT_EQ(history(SequencePlace{4, 5}), 0) << "another sequence";
  EXPECT_EQ(history(SequencePlace{4, 5}), 0) << "the same frame again";
  EXPECT_EQ(history(SequencePlace{4, 4}), 0) << "backwards";
  EXPECT_EQ(history(SequencePlace{4, 5}), 1);
  EXPECT_EQ(history(SequencePlace{4, 6}, 9), 0) << "another size";
  EXPECT_EQ(history(SequencePlace{4, 7}, 9), 1);
  EXPECT_EQ(history(SequencePlace{4, 8}, 9, 7), 0) << "another size";
  state.end();
  EXPECT_FALSE(state.memory.has_value());
  EXPECT_EQ(history(SequencePlace{4, 9}, 9, 7), 0) << "frame 8 could not be denoised";
  EXPECT_EQ(history(SequencePlace{4, 10}, 9, 7), 1);
  EXPECT_EQ(history(SequencePlace{4, 11}, 9, 7, true), 0) << "behind a cut";
  EXPECT_EQ(history(SequencePlace{4, 12}, 9, 7), 1);
  EXPECT_EQ(history({}), 0);
  EXPECT_EQ(history({}), 0) << "stills have nothing to do with one another";
  EXPECT_EQ(history(SequencePlace{0, 0}), 0);
}

}  // namespace
}  // namespace ld
