// A run folder belongs to one configuration.
#pragma once

#include <filesystem>

#include "training/config.h"

namespace ld {

/// Writes the resolved configuration to RUN/config.yaml. Where there is one already, it must agree in all but
/// its `run:` section (which is then replaced); UsageError names the first line that differs.
void claim_run_folder(const std::filesystem::path& run, const TrainConfig& config);

}  // namespace ld
