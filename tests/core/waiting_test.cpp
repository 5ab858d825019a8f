#include "core/process/waiting.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace ld {
namespace {

/// The environment after wait_passively(); with "_" or a policy in it, which the program's is not started
/// again for.
std::vector<std::string> waiting_of(std::vector<std::string> variables) {
  std::vector<char*> environment;
  for (std::string& variable : variables) environment.push_back(variable.data());
  environment.push_back(nullptr);
  char* arguments[] = {nullptr};
  wait_passively(arguments, environment.data());
  return {environment.begin(), environment.end() - 1};
}

TEST(Waiting, TakesTheShellsSlot) {
  EXPECT_EQ(waiting_of({"HOME=/root", "_=/bin/true", "__=1"}),
            (std::vector<std::string>{"HOME=/root", "OMP_WAIT_POLICY=passive", "__=1"}));
}

TEST(Waiting, LeavesWhatIsSetAlone) {
  for (const char* set : {"OMP_WAIT_POLICY=active", "GOMP_SPINCOUNT=30"}) {
    const std::vector<std::string> variables = {"_=/bin/true", set};
    EXPECT_EQ(waiting_of(variables), variables);
  }
}

}  // namespace
}  // namespace ld
