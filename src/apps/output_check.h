// Outputs that cannot be are refused before any work.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace ld {

/// Throws UsageError, which names the option, unless the file's name ends in one of the extensions, in
/// capitals or not. An empty path counts for nothing, and neither does a device or pipe.
void require_extension(const std::string& option, const std::filesystem::path& path,
                       const std::vector<std::string>& extensions);

/// Throws UsageError where one of the files is a folder or cannot be made: it tries to make a file in each of
/// their folders, or, where that is missing and would be made, in the nearest one that is there. Empty paths
/// count for nothing, and neither do devices and pipes.
void require_writable(const std::vector<std::filesystem::path>& files);

}  // namespace ld
