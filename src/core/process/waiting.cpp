#include "core/process/waiting.h"

#include <limits.h>
#include <string.h>
#include <unistd.h>

#include <vector>

namespace ld {

void wait_passively(char** argv, char** environment) {
  static char passive[] = "OMP_WAIT_POLICY=passive";
  std::vector<char*> variables;
  char** shells_own = nullptr;  // where "_" stands, in which shells tell a program its path
  for (char** variable = environment; *variable != nullptr; ++variable) {
    if (strncmp(*variable, "OMP_WAIT_POLICY=", 16) == 0 || strncmp(*variable, "GOMP_SPINCOUNT=", 15) == 0)
      return;
    if (strncmp(*variable, "_=", 2) == 0) shells_own = variable;
    variables.push_back(*variable);
  }
  if (shells_own != nullptr) {
    *shells_own = passive;
    return;
  }
  variables.push_back(passive);
  variables.push_back(nullptr);
  char program[PATH_MAX];
  const ssize_t length = readlink("/proc/self/exe", program, sizeof program);
  if (length <= 0 || length == sizeof program) return;
  program[length] = '\0';
  execve(program, argv, variables.data());
}

}  // namespace ld
