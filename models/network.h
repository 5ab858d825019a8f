// What every denoising network is, and the registry that makes one from its configuration.
#pragma once

#include <torch/torch.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "models/check_network.h"
#include "models/network_config.h"
#include "models/network_input.h"

namespace ld {

/// What the kernels of a picture are made of, for those who watch a training.
struct Kernels {
  torch::Tensor
      logits;  // [B, N, K*K, H, W], of each layer or sample; network "optimized": at full resolution
  torch::Tensor
      log_n;  // [B, N, H, W]: pixel p sends exp(logit) n, normalised over all of its taps and layers
  bool of_layers = false;  // or of samples, or of pixels
};

/// What a network keeps from one frame of a sequence to the next: tensors [B, ...] by their names. Empty
/// before the first frame, and always for networks of single frames. Zeros of the same shapes mean the same
/// as empty.
using NetworkState = std::map<std::string, torch::Tensor>;

/// A picture, and what a loss compares.
struct Compared {
  torch::Tensor picture;            // [B, 3, H, W] as Network::forward() gives it
  torch::Tensor predicted, target;  // picture and reference, or what the network predicts in their place
};

/// What a network in two stages makes, both linear radiance [B, 3, H, W].
struct Stages {
  torch::Tensor first;    // of the first stage, whose light has been brought to full resolution
  torch::Tensor picture;  // of the second one, denoised
};

/// What the second stage reads: what the first has made, the same without a gradient through it, or a picture
/// that somebody gives.
enum class SecondReads { first, first_stopped, given };

/// A network of [MH20]: linear radiance samples and features in, the linear denoised image [B, 3, H, W] out.
class Network : public torch::nn::Module {
 public:
  explicit Network(NetworkConfig config) : config_(std::move(config)) {}

  /// Any H and W from 1, any number of samples from 1. A pixel without valid samples sends nothing and
  /// receives from its neighbours; where nothing is in reach the result is 0. Throws Error when a shape does
  /// not fit the configuration. Hand the input over with std::move where it is not needed any more: what is
  /// made of it then takes its place. An input on another device is taken to that of the weights, where the
  /// result is.
  ///
  /// Differentiable. Where radiance exceeds 1e15, the gradient of the result is bounded so that its product
  /// with the radiance, which is what reaches the kernels, stays below 1e30: sums of larger ones overflow.
  torch::Tensor forward(NetworkInput input) {
    NetworkState none;
    return forward(std::move(input), none);
  }

  /// The next frame of B sequences. `state` is what the frames before have left, and receives what this one
  /// leaves; it is at the device of the weights. Differentiable in the state, too, so that a loss over a clip
  /// goes back through its frames. Throws Error for a state of another network, batch or size.
  torch::Tensor forward(NetworkInput input, NetworkState& state);

  /// forward() of a training or validation frame with its reference [B, 3, H, W]. Most networks are compared
  /// in their pictures; one that predicts powers of light (NetworkTraits::in_powers), in these.
  Compared compare(NetworkInput input, const torch::Tensor& reference, NetworkState& state);
  /// Both stages of a network that has two (NetworkTraits::upscaling): `picture` is forward() where the
  /// second reads the first. `given` is a linear picture [B, 3, H, W]. Throws Error for other networks.
  Stages stages(NetworkInput input, SecondReads reads, const torch::Tensor& given = {});

  /// Whether it keeps anything.
  bool remembers() const { return network_traits(config_.name).remembers; }

  /// The kernels that forward() of a small picture would apply.
  Kernels kernels(NetworkInput input);

  /// What was wrong with the input of the last call.
  const InputFaults& faults() const { return faults_; }

  const NetworkConfig& config() const { return config_; }

  /// Where the weights are.
  torch::Device device() const { return parameters().front().device(); }

  /// Of a network of several resolutions: sets biases so that it begins with the full one.
  virtual void begin_sharp() {}

 private:
  /// The input checked, sanitised and at the device of the weights, its samples averaged, its exposure
  /// normalised and its radiance demodulated where the configuration says so. Every way into a network leads
  /// through here.
  NetworkInput admit(NetworkInput input);

  /// Of an admitted input. Networks of single frames leave the state alone.
  virtual torch::Tensor denoise(const NetworkInput& input, NetworkState& state) = 0;
  virtual Compared predict(const NetworkInput& input, const torch::Tensor& reference, NetworkState& state);
  virtual Kernels make_kernels(const NetworkInput& input) = 0;
  virtual Stages make_stages(const NetworkInput& input, SecondReads reads, const torch::Tensor& given);

  NetworkConfig config_;
  InputFaults faults_;
};

/// Throws what check_network() throws. Weights are zeros until
/// initialise() (models/initialise.h) or a weight file fills them.
std::shared_ptr<Network> make_network(const NetworkConfig& config);

}  // namespace ld
