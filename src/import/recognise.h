// Whose files they are, for those who do not say.
#pragma once

#include <string>

#include "frame/exr_reader.h"

namespace ld {

/// Frames of docs/data_format.md: samples in parts of their own.
bool is_frame(const ExrReader& exr);

/// The preset (docs/import.md) that finds the most features in the file. Throws Error where none finds
/// radiance, with the file's channels, and what the nearest preset says where it cannot tell channels apart.
std::string recognise_preset(const ExrReader& exr);

}  // namespace ld
