#include "inference/filter_method.h"

#include <memory>

namespace ld {

Method filter_method(const FilterArgument& argument, int threads) {
  const auto filter = std::make_shared<FrameFilter>(argument);
  return {argument.name,
          [filter, threads](const Frame& frame, SequenceState& state) {
            return filter->denoise(frame, state, threads);
          },
          {0, std::nullopt}};
}

}  // namespace ld
