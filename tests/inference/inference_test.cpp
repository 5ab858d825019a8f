#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/file_io.h"
#include "dataset/input_tensors.h"
#include "inference/denoiser.h"
#include "models/initialise.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_dataset.h"
#include "weights/model_file.h"
#include "weights/weight_file.h"

namespace ld {
namespace {

struct TinyFile {
  NetworkConfig network;
  template <class Visitor>
  void visit(Visitor& v) {
    v.section("network", network);
  }
};

std::shared_ptr<Network> tiny_network() {
  std::shared_ptr<Network> network =
      make_network(config_from_tree<TinyFile>(parse_config(tiny_network_yaml(), "tiny")).network);
  initialise(*network, 3);
  return network;
}

class Inference : public ::testing::Test {
 protected:
  void SetUp() override { save_network(model(), *network_, "{}", DType::f32); }
  std::filesystem::path model() const { return folder_ / "model.safetensors"; }

  /// The model file with one tensor replaced (an undefined one: removed), or added under a new name.
  std::filesystem::path changed(const std::string& name, const torch::Tensor& tensor) {
    const SafetensorsFile file(model());
    NamedTensors tensors;
    for (const TensorView& view : file.tensors())
      if (view.name != name) tensors.emplace_back(view.name, read_tensor(view));
    if (tensor.defined()) tensors.emplace_back(name, tensor);
    write_tensors(folder_ / "changed.safetensors", tensors, file.metadata());
    return folder_ / "changed.safetensors";
  }
  std::string first_name() const { return network_->named_parameters()[0].key(); }

  TemporaryFolder folder_;
  std::shared_ptr<Network> network_ = tiny_network();
};

TEST_F(Inference, DenoisesEverySizeAsTheNetworkThatWasSaved) {
  const Denoiser denoiser(model());
  for (const auto& [width, height, spp] : {std::tuple{1, 1, 1}, {1, 2, 3}, {31, 33, 2}, {64, 5, 8}}) {
    const Frame frame = random_frame(width, height, spp, 9);
    const Image image = denoiser.denoise(frame);
    ASSERT_EQ(image.width, width);
    ASSERT_EQ(image.height, height);
    const torch::NoGradGuard no_graph;
    const Image expected =
        to_image(network_->forward(make_network_input({frame}, network_->config().features)).squeeze(0));
    const float largest = *std::max_element(expected.pixels.begin(), expected.pixels.end());
    for (size_t i = 0; i < image.pixels.size(); ++i)
      ASSERT_NEAR(image.pixels[i], expected.pixels[i], 1e-5F * largest);
  }
}

TEST_F(Inference, MaskedSamplesAreAsIfNeverDrawn) {
  Frame two = random_frame(12, 9, 2, 4), one(12, 9, 1);
  std::copy_n(two.plane(0, 0), one.samples.size(), one.plane(0, 0));
  std::fill_n(two.valid_plane(1), two.plane_size(), uint8_t{0});
  std::fill_n(two.plane(1, 0), one.samples.size(), 0.0F);
  one.info.depth_scale = two.info.depth_scale;
  const Denoiser denoiser(model());
  const Image with = denoiser.denoise(two), without = denoiser.denoise(one);
  for (size_t i = 0; i < with.pixels.size(); ++i) EXPECT_NEAR(with.pixels[i], without.pixels[i], 1e-6);
}

TEST_F(Inference, AFrameMayLackAnOptionalFeature) {
  NetworkConfig config = network_->config();
  config.optional = {"specular", "albedo"};
  const auto network = make_network(config);
  initialise(*network, 3);
  save_network(folder_ / "optional.safetensors", *network, "{}", DType::f32);
  const Denoiser denoiser(folder_ / "optional.safetensors");
  EXPECT_EQ(denoiser.features().size() + 2, config.features.size());
  Frame frame = random_frame(9, 7, 3, 4);
  for (const char* name : {"specular", "albedo"})
    for (int s = 0; s < frame.spp; ++s)
      for (int c = 0; c < find_feature(name).channels; ++c)
        std::fill_n(frame.plane(s, find_feature(name).offset + c), frame.plane_size(), 0.0F);
  const Image zeros = denoiser.denoise(frame);
  // Written without them and read again.
  frame.features.erase(
      std::remove_if(frame.features.begin(), frame.features.end(),
                     [](const std::string& name) { return name == "specular" || name == "albedo"; }),
      frame.features.end());
  write_frame(folder_ / "frame.exr", frame);
  Faults faults;
  const Frame read = read_frame(folder_ / "frame.exr", denoiser.features(), faults);
  EXPECT_FALSE(read.holds("albedo"));
  const Image without = denoiser.denoise(read);
  for (size_t i = 0; i < zeros.pixels.size(); ++i) EXPECT_NEAR(without.pixels[i], zeros.pixels[i], 2e-2);
  EXPECT_THROW(read_frame(folder_ / "frame.exr", config.features, faults), Error);
}

TEST_F(Inference, AModelFileKeepsEveryBitAndItsConfiguration) {
  const std::shared_ptr<Network> loaded = load_network(model());
  EXPECT_EQ(config_to_yaml(loaded->config()), config_to_yaml(network_->config()));
  const auto expected = network_->named_parameters();
  for (const auto& parameter : loaded->named_parameters())
    EXPECT_TRUE(parameter.value().equal(expected[parameter.key()])) << parameter.key();
}

TEST_F(Inference, WeightsThatDoNotFitTheirConfigurationAreErrors) {
  const torch::Tensor first = network_->named_parameters()[0].value().detach().clone();
  EXPECT_NO_THROW(Denoiser(changed(first_name(), first)));
  EXPECT_THROW(Denoiser(changed(first_name(), torch::Tensor())), Error);
  EXPECT_THROW(Denoiser(changed(first_name(), torch::zeros({2, 2}))), Error);
  EXPECT_THROW(Denoiser(changed("surplus", torch::zeros({2, 2}))), Error);
  torch::Tensor broken = first.clone();
  broken.view(-1)[0] = std::nan("");
  EXPECT_THROW(Denoiser(changed(first_name(), broken)), Error);
}

}  // namespace
}  // namespace ld
