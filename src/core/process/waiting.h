// How OpenMP's threads wait for each other.
#pragma once

namespace ld {

/// Sets OMP_WAIT_POLICY=passive, unless the environment says already how to wait (OMP_WAIT_POLICY, or GCC's
/// GOMP_SPINCOUNT). By default OpenMP's threads spin for each other, and where another process is busy they
/// burn the time that the one they wait for needs (docs/performance.md).
///
/// To be called from .preinit_array, whose functions the dynamic loader calls before any library's: OpenMP
/// reads the environment once, when it is loaded, and main() comes too late. There setenv() is too early: the
/// C library will still take `environment` for its own. So a slot of it is needed: that of the variable "_",
/// which shells set and nobody reads. Where there is none the program is started again (a quarter of a second
/// with LibTorch), and where that fails nothing changes.
void wait_passively(char** argv, char** environment);

}  // namespace ld
