#include "ops/runtime.h"

#include <ATen/Parallel.h>
#include <torch/torch.h>

#include <chrono>

#include "core/log.h"

namespace ld {
namespace {

/// GFLOP/s of a small matrix product; about a millisecond with OpenBLAS.
double sgemm_gflops() {
  const int64_t n = 256;
  const torch::Tensor a = torch::ones({n, n}), b = torch::ones({n, n});
  torch::mm(a, b);  // starts the threads
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < 4; ++i) torch::mm(a, b);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return 4 * 2e-9 * static_cast<double>(n * n * n) / seconds;
}

}  // namespace

void configure_runtime(int threads) {
  at::set_num_threads(threads);
  // The setting belongs to a thread: one chunk of work for each of the pool's.
  at::parallel_for(0, threads, 1, [](int64_t, int64_t) { at::globalContext().setFlushDenormal(true); });
  at::globalContext().setFlushDenormal(true);
  const double gflops = sgemm_gflops();
  // The reference BLAS reaches 4 GFLOP/s, OpenBLAS 30 and more on one old core.
  if (gflops < 8)
    spdlog::warn(
        "matrix products run at {:.1f} GFLOP/s: LibTorch uses a slow BLAS; install libopenblas0-openmp for a "
        "training 40 times faster",
        gflops);
}

}  // namespace ld
