#include "core/unique_name.h"

#include <fmt/format.h>
#include <unistd.h>

#include <random>

namespace ld {

std::string unique_name() {
  std::random_device random;  // the system's; a seed of this process would be its children's, too
  return fmt::format("{}-{:08x}{:08x}", getpid(), random(), random());
}

}  // namespace ld
