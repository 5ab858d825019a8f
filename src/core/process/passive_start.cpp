// Linked into every program and every test program: wait_passively() before any library is loaded.
#include "core/process/waiting.h"

namespace ld {
namespace {

void before_all_libraries(int, char** argv, char** environment) {
  wait_passively(argv, environment);
}
__attribute__((section(".preinit_array"), used)) void (*const preinit)(int, char**,
                                                                       char**) = before_all_libraries;

}  // namespace
}  // namespace ld
