// What can be said of a job before anything is denoised.
#pragma once

#include "filters/frame_filter.h"
#include "inference/denoise_job.h"
#include "inference/denoiser.h"

namespace ld {

/// Whether the task's picture is there already and is to be kept.
bool is_left_alone(const DenoiseJob& job, const DenoiseTask& task);

/// With one of the two, the other is null. Throws UsageError as run_denoise_job() says.
void check_job(const DenoiseJob& job, const Denoiser* denoiser, const FrameFilter* filter);

}  // namespace ld
