// The separate inference program's engine: weights in, frames in, images out. No trainer, no autograd graph.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "frame/frame.h"

namespace ld {

class Network;
struct NetworkConfig;

class Denoiser {
 public:
  /// `model` is a weight file (.safetensors), a checkpoint folder or a run folder (its `best` checkpoint).
  /// Throws Error when the file is damaged, its network unknown to this program, or its feature set another
  /// than this program's.
  explicit Denoiser(const std::filesystem::path& model);
  ~Denoiser();

  /// The features that frames must hold for this model (for read_frame).
  const std::vector<std::string>& features() const;
  const NetworkConfig& network_config() const;

  /// The denoised image [3, H, W], linear; any size from 1x1, any number of samples from 1. Takes the frame
  /// so that its memory is free as soon as the samples are encoded, and theirs as soon as the network has
  /// read them: hand over large frames with std::move. Not for several threads at once.
  Image denoise(Frame frame) const;

 private:
  std::shared_ptr<Network> network_;
};

}  // namespace ld
