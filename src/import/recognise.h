// Whose files they are, for those who do not say.
#pragma once

#include <string>
#include <vector>

#include "frame/exr_reader.h"

namespace ld {

/// Frames of docs/data_format.md: samples in parts of their own.
bool is_frame(const ExrReader& exr);

/// The preset (docs/import.md) that finds the most features in the file, seen from `view` (the hero where
/// that is empty), in channels with names of their own: plain R or Z could be anybody's.
/// `assignments` come on top of each preset. Throws Error where none finds radiance, with the file's
/// channels, and what the nearest preset says where it cannot tell channels apart; UsageError for a view that
/// is not there.
std::string recognise_preset(const ExrReader& exr, const std::string& view = {},
                             const std::vector<std::string>& assignments = {});

}  // namespace ld
