#include "dataset/clips.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_dataset.h"
#include "tests/support/tiny_sequences.h"

namespace ld {
namespace {

using Clips = std::vector<Clip>;

Clips clips(const std::filesystem::path& folder, int length) {
  return clips_of(FrameStore(folder, "train", {"radiance"}, {"none", 0}), length);
}

TEST(Clips, OfOneFrameAreTheFramesWhateverTheySayOfSequences) {
  const TemporaryFolder folder;
  write_tiny_dataset(folder / "stills", 3);
  write_tiny_sequences(folder / "sequences", {2, 1});
  for (const char* name : {"stills", "sequences"}) {
    EXPECT_EQ(clips(folder / name, 1), (Clips{{0}, {1}, {2}}));
    EXPECT_EQ(clips_per_epoch(clips(folder / name, 1)), 3u);
  }
}

TEST(Clips, OverlapWithinASequenceAndNeverCrossACut) {
  const TemporaryFolder folder;
  write_tiny_sequences(folder.path(), {4, 2, 3});
  EXPECT_EQ(clips(folder.path(), 3), (Clips{{0, 1, 2}, {1, 2, 3}, {6, 7, 8}}));
  EXPECT_EQ(clips_per_epoch(clips(folder.path(), 3)), 2u) << "seven frames lie in clips";
  EXPECT_EQ(clips(folder.path(), 4), (Clips{{0, 1, 2, 3}}));
  EXPECT_EQ(clips_per_epoch(clips(folder.path(), 4)), 1u);
}

TEST(Clips, ACutIsAGapOrAChangeOfSize) {
  const TemporaryFolder folder;
  write_tiny_sequences(folder.path(), {6});
  Manifest manifest = read_manifest(folder.path());
  manifest.frames[2].position = 9;  // 0 1 . 3 4 5, and 9 alone
  add_to_manifest(folder.path(), manifest);
  EXPECT_EQ(clips(folder.path(), 2), (Clips{{0, 1}, {3, 4}, {4, 5}}));
  write_numbered_frame(folder.path(), manifest.frames[4].name, 4, 12, 2);
  EXPECT_EQ(clips(folder.path(), 2), (Clips{{0, 1}}));
}

TEST(Clips, WhereNothingIsSoLongIsOneError) {
  const TemporaryFolder folder;
  write_tiny_dataset(folder / "stills", 3);
  EXPECT_ERROR(clips(folder / "stills", 2), "data.clip: no 2 frames of ");
  EXPECT_ERROR(clips(folder / "stills", 2), "at most 1 do; render sequences (sequence.length");
  write_tiny_sequences(folder / "sequences", {3, 4});
  EXPECT_ERROR(clips(folder / "sequences", 5), "set data.clip=4 or less");
  EXPECT_THROW(clips(folder / "sequences", 5), UsageError);
}

}  // namespace
}  // namespace ld
