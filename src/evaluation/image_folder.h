// Pictures that another denoiser wrote, as a method of the evaluation.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "evaluation/method.h"

namespace ld {

/// Method `name`: the picture of frame F is R, G, B (linear radiance) of the first part of FOLDER/F.exr, as
/// it stands there: negative, NaN and infinite values included, which the metrics judge. Throws Error here
/// when the folder or the file of one of `frames` is missing (naming the first, how many are, and a picture
/// of another format that lies there instead); on reading, for a damaged file, one without R, G, B, or of
/// another size than the frame. Where there is a FOLDER/cost.json, its "seconds": {FRAME: s, ...} are the
/// method's times; Error when it is damaged.
Method image_folder_method(const std::string& name, const std::filesystem::path& folder,
                           const std::vector<std::string>& frames);

}  // namespace ld
