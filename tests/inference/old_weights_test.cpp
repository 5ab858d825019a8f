// Weights that an earlier version trained still denoise as they did then.
#include <gtest/gtest.h>

#include <cmath>

#include "frame/frame_file.h"
#include "inference/denoiser.h"
#include "models/network_config.h"

namespace ld {
namespace {

TEST(OldWeights, DenoiseAsTheProgramThatTrainedThem) {
  // layer.safetensors has no key that is younger than it; denoised.exr is what ld_denoise made of frame.exr.
  const std::filesystem::path folder = std::filesystem::path(LD_SOURCE_DIR) / "tests/fixtures/before_simd";
  const Denoiser denoiser(folder / "layer.safetensors");
  EXPECT_EQ(denoiser.network_config().name, "layer");
  EXPECT_EQ(denoiser.network_config().compositing, "alpha");
  Faults faults;
  const Image found = denoiser.denoise(read_frame(folder / "frame.exr", denoiser.features(), faults)),
              expected = read_image(folder / "denoised.exr");
  ASSERT_EQ(found.width, expected.width);
  ASSERT_EQ(found.height, expected.height);
  // The file rounds to half floats: 2^-11 of the value, 2^-25 where they are subnormal. Filter exponents of
  // up to some tens, wrong by 2^-23 of themselves in either program, make 2e-5 of the values in reach.
  double largest = 0;
  for (const float value : expected.pixels) largest = std::max(largest, double(value));
  EXPECT_GT(largest, 0.5);
  for (size_t i = 0; i < expected.pixels.size(); ++i) {
    const double e = expected.pixels[i];
    ASSERT_NEAR(found.pixels[i], e, std::ldexp(e, -11) + std::ldexp(1.0, -25) + 2e-5 * largest) << i;
  }
}

}  // namespace
}  // namespace ld
