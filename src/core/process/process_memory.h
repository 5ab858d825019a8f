// The memory of this process, as Linux's /proc tells it; bytes.
#pragma once

#include <cstdint>

namespace ld {

/// What is resident now. All three: -1 where /proc does not say.
int64_t resident_bytes();

/// The most that was resident at any time since the program started, or since reset_peak_resident().
int64_t peak_resident_bytes();

/// Throws Error where the system does not allow it.
void reset_peak_resident();

/// What the machine could still give without swapping. Limits of a container are
/// not known here.
int64_t available_bytes();

}  // namespace ld
