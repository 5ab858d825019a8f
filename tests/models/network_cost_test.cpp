#include "models/graphs/network_cost.h"

#include <gtest/gtest.h>

#include "models/network.h"

namespace ld {
namespace {

NetworkConfig named(const std::string& name) {
  NetworkConfig config;
  config.name = name;
  return config;
}

// Counted by hand from the widths of [MH20], 8 samples, 2 layers.
TEST(Cost, OfThePublishedLayerNetwork) {
  const double pixels = 256 * 256;
  const NetworkCost cost = multiply_adds(NetworkConfig(), 8, 256, 256);
  EXPECT_EQ(cost.reducer / pixels, 8 * (20 * 32 + 32 * 32 + 32 * 32));
  EXPECT_EQ(cost.partitioner / pixels, 8 * (160 * 32 + 32 * 16 + 16 * 2));
  EXPECT_EQ(cost.kernel_generator / pixels, 2 * (160 * 128 + 128 * 128 + 128 * 289));
  EXPECT_EQ(cost.filtering / pixels, 2 * 289 * 5);
  const double unet =
      9 * (32 * 64 + 64 * 64 + (64 * 128) / 4. + (128 * 256) / 16. + (256 * 512) / 64. + (512 * 512) / 256. +
           (512 * 512) / 1024. +  // encoder, bottleneck
           (1024 * 512 + 512 * 512) / 256. + (768 * 256 + 256 * 256) / 64. + (384 * 128 + 128 * 128) / 16. +
           (192 * 128 + 128 * 128) / 4. + (160 * 128 + 128 * 128) + 128 * 128);
  EXPECT_EQ(cost.unet / pixels, unet);
  EXPECT_NEAR(cost.total() / pixels / 1.01e6, 1, 0.01);
  EXPECT_EQ(cost.training(), 3 * cost.total() - 8 * 20 * 32 * pixels);
}

TEST(Cost, OnlyPerSamplePartsGrowWithTheSamples) {
  const NetworkCost one = multiply_adds(NetworkConfig(), 1, 32, 64),
                    many = multiply_adds(NetworkConfig(), 5, 32, 64);
  EXPECT_EQ(many.reducer, 5 * one.reducer);
  EXPECT_EQ(many.partitioner, 5 * one.partitioner);
  EXPECT_EQ(many.unet, one.unet);
  EXPECT_EQ(many.kernel_generator, one.kernel_generator);
  EXPECT_EQ(many.filtering, one.filtering);
}

TEST(Cost, TheUNetPadsToItsPools) {
  const NetworkCost whole = multiply_adds(NetworkConfig(), 1, 64, 32),
                    part = multiply_adds(NetworkConfig(), 1, 33, 1);
  EXPECT_EQ(part.unet, whole.unet);
  EXPECT_EQ(part.reducer, whole.reducer * 33 / (64 * 32));
}

// Per pixel at 8 samples; the U-net as that of the layer network.
TEST(Cost, OfTheOtherNetworks) {
  const double pixels = 64 * 64, unet = multiply_adds(NetworkConfig(), 8, 64, 64).unet;
  const double generator = 160 * 128 + 128 * 128 + 128 * 289;

  const NetworkCost samples = multiply_adds(named("sample_splat"), 8, 64, 64);
  EXPECT_EQ(samples.unet, unet);
  EXPECT_EQ(samples.partitioner, 0);
  EXPECT_EQ(samples.kernel_generator / pixels, 8 * generator);
  EXPECT_EQ(samples.filtering / pixels, 8 * 289 * 4);

  for (const char* name : {"pixel_gather", "pixel_splat"}) {
    const NetworkCost pixel = multiply_adds(named(name), 8, 64, 64);
    EXPECT_EQ(pixel.unet, unet) << name;
    EXPECT_EQ(pixel.reducer / pixels, 40 * 32 + 32 * 32 + 32 * 32) << name;
    EXPECT_EQ(pixel.kernel_generator / pixels, generator) << name;
    EXPECT_EQ(pixel.filtering / pixels, 289 * 4) << name;
  }

  NetworkConfig config = named("optimized");
  config.kernel_size = 5;
  config.kernel_generator = {32, 32};
  const NetworkCost optimized = multiply_adds(config, 8, 64, 64);
  EXPECT_EQ(optimized.filtering / pixels, 2 * 25 * 5 * (1 + 1 / 4. + 1 / 16.));
  const double hidden = 32 * 32 + 32 * 25;
  // All levels read 32 + 128 channels; the three level weights are made of layer 0.
  EXPECT_EQ(optimized.kernel_generator / pixels,
            2 * (160 * 32 + hidden) * (1 + 1 / 4. + 1 / 16.) + 160 * 32 + 32 * 32 + 32 * 3);
}

// A network that someone adds must be added to the table of costs.
TEST(Cost, EveryRegisteredNetworkHasOne) {
  for (const std::string& name : network_names())
    EXPECT_GT(multiply_adds(named(name), 2, 32, 32).total(), 0) << name;
}

}  // namespace
}  // namespace ld
