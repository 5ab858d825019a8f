// What a denoiser keeps from one frame of a sequence to the next: who denoises frames in order holds one of
// these for each denoiser, and says before each frame where it stands.
#pragma once

#include <any>
#include <cstdint>
#include <optional>

namespace ld {

/// A frame's place among those that follow one another: which sequence, where in it.
struct SequencePlace {
  int64_t sequence = 0, position = 0;
};

/// Starts, advances and ends. A still frame has no place and is a sequence of its own.
class SequenceState {
 public:
  /// To be called before each frame, with its place and size in pixels. A frame that does not come right
  /// after the one before in the same sequence, or behind a cut, or has another size, starts anew: nothing is
  /// remembered then.
  void advance(const std::optional<SequencePlace>& place, int width, int height, bool cut = false);

  /// The frame that was announced last could not be denoised, or is the last one: the next one starts anew.
  void end();

  /// How many frames lie between the start and the present one; 0: nothing is known of those before.
  int64_t history() const { return history_; }

  /// The denoiser's own, empty at each start.
  std::any memory;

 private:
  std::optional<SequencePlace> last_;
  int width_ = 0, height_ = 0;
  int64_t history_ = 0;
};

}  // namespace ld
