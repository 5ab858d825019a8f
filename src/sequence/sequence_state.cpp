#include "sequence/sequence_state.h"

namespace ld {

void SequenceState::advance(const std::optional<SequencePlace>& place, int width, int height, bool cut) {
  const bool follows = !cut && place && last_ && place->sequence == last_->sequence &&
                       place->position == last_->position + 1 && width == width_ && height == height_;
  if (!follows) end();
  history_ = follows ? history_ + 1 : 0;
  last_ = place;
  width_ = width;
  height_ = height;
}

void SequenceState::end() {
  last_.reset();
  memory.reset();
  history_ = 0;
}

}  // namespace ld
