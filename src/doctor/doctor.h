// Looks for what spoils a data set without making a program fail: wrong units and spaces, references that
// are not independent, pictures in two splits, ... (docs/doctor.md lists the checks and their thresholds).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "doctor/evidence.h"
#include "doctor/finding.h"
#include "frame/manifest.h"

namespace ld {

struct DoctorOptions {
  int threads = 1;
  int64_t frames = 0;  // look at so many of them, spread over the manifest; 0: at all
};

/// Examines the frames of a data set and their references. Memory: one frame a thread, and about a kilobyte
/// for every frame. A frame that cannot be read becomes a problem of the check "files". Of the others only
/// the headers are read, whose faults are thrown as Error. Ends early when a stop is requested
/// (core/signals.h): what it says is then of some frames only.
Diagnosis examine_dataset(const std::filesystem::path& folder, const Manifest& manifest,
                          const DoctorOptions& options);

/// Examines one frame (doctor/evidence.h reads it).
Diagnosis examine_frame(const Evidence& evidence);

/// The names of the checks in the order of the report.
std::vector<std::string> check_names();

}  // namespace ld
