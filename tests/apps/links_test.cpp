// What the inference program is made of.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <memory>
#include <string>

namespace ld {
namespace {

/// The names of the functions in a program.
std::string symbols(const std::string& program) {
  const std::string command = "nm -C --defined-only " LD_BIN_DIR "/" + program;
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), &pclose);
  std::string text;
  std::array<char, 4096> buffer{};
  while (pipe && fgets(buffer.data(), buffer.size(), pipe.get()) != nullptr) text += buffer.data();
  return text;
}

TEST(Links, TheInferenceProgramHoldsNoTrainerAndNoLoss) {
  const std::string denoise = symbols("ld_denoise"), train = symbols("ld_train");
  for (const char* name : {"ld::Trainer::", "ld::read_checkpoint", "ld::make_loss"}) {
    EXPECT_NE(train.find(name), std::string::npos) << name << " has another name now: mend this test";
    EXPECT_EQ(denoise.find(name), std::string::npos) << name;
  }
  EXPECT_NE(denoise.find("ld::Denoiser::denoise"), std::string::npos);
}

}  // namespace
}  // namespace ld
