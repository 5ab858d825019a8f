#include "inference/denoiser.h"

#include "dataset/network_input.h"
#include "models/network.h"
#include "weights/model_file.h"

namespace ld {

Denoiser::Denoiser(const std::filesystem::path& model) : network_(load_model(model)) {
  network_->eval();
}

Denoiser::~Denoiser() = default;

const std::vector<std::string>& Denoiser::features() const {
  return network_->config().features;
}

const NetworkConfig& Denoiser::network_config() const {
  return network_->config();
}

Image Denoiser::denoise(Frame frame) const {
  const torch::InferenceMode no_graph;
  std::vector<Frame> frames(1);
  frames[0] = std::move(frame);
  NetworkInput input = make_network_input(frames, features());
  frames.clear();
  return to_image(network_->forward(std::move(input)).squeeze(0));
}

}  // namespace ld
