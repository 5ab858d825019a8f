// Whether the tests run with the address sanitizer, whose own memory and quarantine outweigh what is
// measured.
#pragma once

namespace ld {

#if defined(__SANITIZE_ADDRESS__)
constexpr bool kAddressSanitizer = true;
#else
constexpr bool kAddressSanitizer = false;
#endif

}  // namespace ld
