// What a memory budget changes: nothing but the memory.
#include <gtest/gtest.h>

#include <regex>

#include "inference/denoiser.h"
#include "runtime/executor.h"
#include "tests/models/small_network.h"
#include "tests/support/expect_error.h"
#include "tests/support/random_frame.h"
#include "tests/support/sanitized.h"
#include "tests/support/temporary_folder.h"
#include "weights/model_file.h"
#include "weights/network_weights.h"

namespace ld {
namespace {

/// Every network, with kernels that reach over blocks of rows and a U-net of three resolutions.
std::vector<NetworkConfig> reaching_configs() {
  std::vector<NetworkConfig> configs = every_config();
  for (NetworkConfig& config : configs) {
    config.kernel_size = 7;
    config.unet.encoder = {{8, 8}, {8}, {8}};
    config.unet.decoder = {{8, 8}, {8}, {8, 8}};
    config.unet.context = 16;
    config.exposure_normalisation = config.name == "layer";
  }
  return configs;
}

Frame some_frame(int width, int height, int spp) {
  Frame frame = random_frame(width, height, spp, 7);
  for (size_t i = 3; i < frame.valid.size(); i += 5) frame.valid[i] = 0;
  sanitise(frame);
  return frame;
}

TEST(MemoryBudget, AnyGivesTheSameBitsOnOddSizes) {
  for (const NetworkConfig& config : reaching_configs()) {
    const TemporaryFolder folder;
    save_network(folder / "model.safetensors", *small_network(config, torch::kFloat32), "{}", DType::f32);
    const Denoiser denoiser(folder / "model.safetensors");
    const NetworkWeights network = read_network_weights(folder / "model.safetensors");
    for (const auto& [width, height, spp] : {std::tuple{37, 53, 2}, {129, 65, 1}, {1, 1, 1}, {3, 150, 3}}) {
      const Frame frame = some_frame(width, height, spp);
      const Image expected = denoiser.denoise(frame);
      for (const int64_t rows : {1, 3, 8, 1000}) {
        Execution execution(network.graph, network.weights, {spp, height, width}, {1, rows});
        EXPECT_EQ(execution.run(frame)[0].pixels, expected.pixels)
            << title(config) << ", " << width << "x" << height << ", " << rows << " rows at a time";
      }
    }
  }
}

class Budget : public ::testing::Test {
 protected:
  void SetUp() override {
    NetworkConfig config = reaching_configs()[0];
    config.unet.context = 64;
    save_network(folder_ / "model.safetensors", *small_network(config, torch::kFloat32), "{}", DType::f32);
  }
  TemporaryFolder folder_;
};

TEST_F(Budget, OneThatIsTooSmallNamesTheSmallestThatWillDo) {
  if (kAddressSanitizer)
    GTEST_SKIP() << "the sanitizer keeps what was freed, so that the smallest budget grows";
  const Denoiser denoiser(folder_ / "model.safetensors");
  const Frame frame = some_frame(161, 127, 2);
  const Image unlimited = denoiser.denoise(frame);
  DenoiseOptions options;
  options.max_memory_bytes = int64_t{1} << 20;
  const std::string text = error_text([&] { denoiser.denoise(frame, options); });
  EXPECT_NE(text.find("budget of 1 MB is too small for 161x127 pixels at 2 samples"), std::string::npos)
      << text;
  std::smatch smallest;
  ASSERT_TRUE(std::regex_search(text, smallest, std::regex("smallest is ([0-9]+) MB"))) << text;
  for (const int64_t more : {2, 20, 2000}) {
    options.max_memory_bytes = (std::stoll(smallest[1]) + more) << 20;
    EXPECT_EQ(denoiser.denoise(frame, options).pixels, unlimited.pixels) << more;
  }
}

TEST_F(Budget, ProgressRisesToTheEndAndCancellingEndsIt) {
  const Denoiser denoiser(folder_ / "model.safetensors");
  const Frame frame = some_frame(64, 200, 2);
  std::vector<double> shares;
  DenoiseOptions options;
  options.progress = [&](double share) { shares.push_back(share); };
  denoiser.denoise(frame, options);
  ASSERT_GE(shares.size(), 3u);
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
  EXPECT_GE(shares.front(), 0);
  EXPECT_EQ(shares.back(), 1);
  int asked = 0;
  options.cancel = [&] { return ++asked == 2; };
  EXPECT_THROW(denoiser.denoise(frame, options), Cancelled);
  options.cancel = nullptr;
  EXPECT_NO_THROW(denoiser.denoise(frame, options)) << "a cancelled run leaves nothing behind";
}

/// The network "layer" with both compositors, with and without demodulation.
std::vector<NetworkConfig> layer_configs() {
  std::vector<NetworkConfig> configs;
  for (const NetworkConfig& config : reaching_configs())
    for (const char* compositing : {"alpha", "weighted"})
      if (config.name == "layer" && config.compositing == "alpha") {
        configs.push_back(config);
        configs.back().compositing = compositing;
      }
  return configs;
}

TEST(Layers, AddUpToThePictureAndKernelsToOne) {
  ASSERT_EQ(layer_configs().size(), 4u);
  for (const NetworkConfig& config : layer_configs()) {
    SCOPED_TRACE(title(config));
    const TemporaryFolder folder;
    save_network(folder / "model.safetensors", *small_network(config, torch::kFloat32), "{}", DType::f32);
    const Denoiser denoiser(folder / "model.safetensors");
    const Frame frame = some_frame(40, 33, 3);
    const Image image = denoiser.denoise(frame);
    const float largest = *std::max_element(image.pixels.begin(), image.pixels.end());
    const std::vector<LayerPicture> layers = denoiser.layers(frame);
    ASSERT_EQ(layers.size(), 2u);
    for (size_t i = 0; i < image.pixels.size(); ++i)
      ASSERT_NEAR(layers[0].contribution.pixels[i] + layers[1].contribution.pixels[i], image.pixels[i],
                  1e-5 * largest);
    for (size_t p = 0; p < image.plane_size(); ++p) {
      ASSERT_NEAR(layers[0].weight.pixels[p] + layers[1].weight.pixels[p], 1, 1e-5);
      ASSERT_NEAR(layers[1].alpha.pixels[p], 1, 1e-5) << "nothing shines through the last layer";
    }
    for (const auto& [x, y] : {std::pair{0, 0}, {39, 32}, {20, 7}}) {
      const std::vector<Image> kernels = denoiser.kernels_at(frame, x, y);
      ASSERT_EQ(kernels.size(), 2u);
      double sum = 0;
      for (const Image& kernel : kernels)
        for (const float share : kernel.pixels) sum += share;
      bool drawn = false;
      for (int s = 0; s < 3; ++s) drawn = drawn || frame.valid_plane(s)[y * 40 + x] != 0;
      EXPECT_NEAR(sum, drawn ? 1 : 0, 1e-5);
    }
    EXPECT_ERROR(denoiser.kernels_at(frame, 40, 0), "no pixel (40, 0)");
  }
}

}  // namespace
}  // namespace ld
