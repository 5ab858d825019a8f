// What the tests share that denoise files of other programs with a small network of radiance alone.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "frame/exr_reader.h"
#include "tests/models/small_network.h"
#include "tests/support/temporary_folder.h"
#include "weights/model_file.h"

namespace ld {

/// The part of that name; -1 where there is none.
inline int part_of(const ExrReader& exr, const std::string& name) {
  for (int part = 0; part < exr.parts(); ++part)
    if (exr.part_name(part) == name) return part;
  return -1;
}

inline std::vector<float> channel_of(const ExrReader& exr, int part, const std::string& name) {
  std::vector<float> pixels(size_t(exr.width(part)) * size_t(exr.height(part)));
  exr.read(part, std::vector<ExrPlane>{{name, pixels.data(), pixels.size()}});
  return pixels;
}

/// A folder for all tests of a suite, with the weights model.safetensors in it.
class DenoisingTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared_ = new TemporaryFolder;
    NetworkConfig config = small_config();
    config.features = {"radiance"};
    save_network(path("model.safetensors"), *small_network(config, torch::kFloat32), "{}", DType::f32);
  }
  static void TearDownTestSuite() { delete shared_; }
  static std::string path(const std::string& name) { return (*shared_ / name).string(); }

 private:
  inline static TemporaryFolder* shared_ = nullptr;
};

}  // namespace ld
