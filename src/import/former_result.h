// Pictures that ld_denoise made are no samples: they carry an attribute by which they are told.
#pragma once

#include <string>

#include "frame/exr_reader.h"
#include "import/file_views.h"

namespace ld {

/// The name of the attribute for the picture whose channels have this prefix (FileViews::prefix()): views
/// that lie in one part are denoised one by one.
std::string denoised_attribute(const std::string& prefix);

/// Whether the picture that the part holds of the views' chosen one was denoised.
bool is_denoised(const ExrReader& exr, const FileViews& views, int part);

/// Whether the file is a result of ld_denoise, seen from `view` (the hero where that is empty): it holds no
/// samples beside, and its picture comes first. False where that cannot be told, which whoever reads it next
/// complains of.
bool is_former_result(const std::string& path, const std::string& view);

/// What to say of such a file.
extern const char* const kDenoisedAlready;

}  // namespace ld
