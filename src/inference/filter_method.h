// Filters without weights as methods of the evaluation.
#pragma once

#include "evaluation/method.h"
#include "filters/frame_filter.h"

namespace ld {

/// The filter on so many threads. Throws UsageError as FrameFilter does.
Method filter_method(const FilterArgument& argument, int threads);

}  // namespace ld
