// A device that is not the CPU, for machines without a GPU: what runs on it assumes nothing that only the CPU
// has.
#pragma once

#include <torch/torch.h>

#include <string>

namespace ld {

/// LibTorch's place for GPUs of Intel ("xpu:0"), which Debian's leaves empty. The CPU computes behind it.
/// (Its places for devices of others do not take the parameters of modules in LibTorch 1.13.) As on a GPU,
/// the program can neither read nor write its memory: a loop over data_ptr() ends the process with SIGSEGV.
/// And operators throw when tensors of the CPU are among their arguments, but for those without dimensions,
/// which are numbers. Its results have the bits of LibTorch's operators on the CPU.
torch::Device fake_device();

/// Why networks cannot be trained on it; empty where they can.
inline std::string no_fake_gradients() {
  return at::globalContext().hasCUDART() ? "LibTorch with CUDA asks for its streams on any device" : "";
}

}  // namespace ld
