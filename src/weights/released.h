// The weights that come with the programs, by name.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace ld {

/// The file of "common_fine", or of "common", which stands for the best that there is of that name (_fine,
/// else _fast); empty where no released weights are called so. Looked for beside an installed program
/// (../share/layer_denoiser/models), then where this one was built (models/pretrained).
std::filesystem::path released_model(const std::string& name);

/// Of a package that brings the weights along: they are looked for there alone. To be called once, before all
/// else.
void keep_released_models_in(const std::filesystem::path& folder);

/// All names, sorted.
std::vector<std::string> released_models();

}  // namespace ld
