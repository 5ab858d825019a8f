#include "training/device.h"

#include <ATen/Context.h>
#include <torch/version.h>

#include "core/error.h"

namespace ld {

torch::Device device_named(const std::string& name, const std::string& place) {
  const torch::Device device(name);
  if (!device.is_cuda()) return device;
  if (!torch::cuda::is_available()) {
    const bool built_with_it = at::globalContext().hasCUDART();
    fail_usage(
        "{}: run.device: expected cpu, or cuda with a GPU that LibTorch can use, found cuda and {}; say "
        "run.device=cpu, or {}",
        place,
        built_with_it ? "no GPU that LibTorch " TORCH_VERSION " can use"
                      : "LibTorch " TORCH_VERSION " without CUDA",
        built_with_it ? "see what nvidia-smi and CUDA_VISIBLE_DEVICES say" : "build with one that has it");
  }
  // Convolutions in float32, as on the CPU: LibTorch would round their factors to 10 bits.
  at::globalContext().setAllowTF32CuDNN(false);
  return device;
}

}  // namespace ld
