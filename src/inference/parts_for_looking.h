// What lies behind a picture, as further parts of its file.
#pragma once

#include <vector>

#include "inference/denoise_job.h"
#include "inference/denoiser.h"
#include "inference/picture_file.h"

namespace ld {

/// The layers and kernels that the job asks for. Throws as Denoiser::layers() and kernels_at() do.
std::vector<PicturePart> parts_for_looking(const DenoiseJob& job, const Denoiser& denoiser,
                                           const Frame& frame, DenoiseOptions how);

}  // namespace ld
