// What the programs are made of, and what they load.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "tests/support/run_program.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

/// What a command prints.
std::string said(const std::string& command) {
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), &pclose);
  std::string text;
  std::array<char, 4096> buffer{};
  while (pipe && fgets(buffer.data(), buffer.size(), pipe.get()) != nullptr) text += buffer.data();
  return text;
}

/// The names of the functions in a program.
std::string symbols(const std::string& program) {
  return said("nm -C --defined-only " LD_BIN_DIR "/" + program);
}

TEST(Links, TheInferenceProgramHoldsNoTrainerAndNoLoss) {
  const std::string denoise = symbols("ld_denoise"), train = symbols("ld_train");
  for (const char* name : {"ld::Trainer::", "ld::read_checkpoint", "ld::make_loss"}) {
    EXPECT_NE(train.find(name), std::string::npos) << name << " has another name now: mend this test";
    EXPECT_EQ(denoise.find(name), std::string::npos) << name;
  }
  EXPECT_NE(denoise.find("ld::Denoiser::denoise"), std::string::npos);
}

/// Programs start at once: what loads many libraries is in modules (core/module.h).
TEST(Links, ProgramsWithoutLibTorchLoadFewLibraries) {
  for (const char* program : {"ld_denoise", "ld_eval", "ld_import", "ld_inspect", "ld_render"}) {
    const std::string libraries = said(std::string("ldd " LD_BIN_DIR "/") + program);
    EXPECT_NE(libraries.find("libOpenEXR"), std::string::npos) << libraries;
    EXPECT_LT(std::count(libraries.begin(), libraries.end(), '\n'), 40) << program << "\n" << libraries;
    for (const char* name : {"libOpenImageIO", "libhdf5", "libembree", "libtorch"})
      EXPECT_EQ(libraries.find(name), std::string::npos) << program << " loads " << name;
  }
}

/// Of a program that was copied without its modules.
TEST(Links, AMissingModuleIsOneErrorWhereItIsNeeded) {
  const TemporaryFolder folder;
  const fs::path program = folder / "ld_import";
  fs::copy_file(fs::path(LD_BIN_DIR) / "ld_import", program);
  const std::string file = std::string(LD_SOURCE_DIR) + "/tests/fixtures/hdf5/fault.h5";
  const std::string out = (folder / "data").string();
  expect_failure(run_program(program.string(), {"--from-hdf5", file, "--reference", file, "--out", out,
                                                "--split", "test", "--name", "f"}),
                 1, {"libld_hdf5.so", "reads and writes HDF5 files", "no such file", "install"});
  EXPECT_FALSE(fs::exists(out));
  EXPECT_EQ(run_program(program.string(), {"--version"}).exit_code, 0);
}

}  // namespace
}  // namespace ld
