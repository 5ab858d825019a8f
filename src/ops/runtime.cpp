#include "ops/runtime.h"

#include <ATen/Parallel.h>
#include <torch/torch.h>

#include <algorithm>
#include <chrono>

#include "core/log.h"
#include "ops/blas_kernels.h"
#include "ops/memory_pool.h"

namespace ld {
namespace {

/// GFLOP/s of a small matrix product on one thread, the best of a few: other programs on the machine must not
/// make OpenBLAS look like the reference BLAS. A few milliseconds.
double sgemm_gflops() {
  const int64_t n = 256;
  const torch::Tensor a = torch::ones({n, n}), b = torch::ones({n, n});
  double best = 0;
  for (int i = 0; i < 5; ++i) {
    const auto start = std::chrono::steady_clock::now();
    torch::mm(a, b);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    best = std::max(best, 2e-9 * static_cast<double>(n * n * n) / seconds);
  }
  return best;
}

/// The setting belongs to a thread: one chunk of work for each of the pool's.
void flush_denormals(int threads, bool flush) {
  at::parallel_for(0, threads, 1, [flush](int64_t, int64_t) { at::globalContext().setFlushDenormal(flush); });
  at::globalContext().setFlushDenormal(flush);
}

}  // namespace

void configure_runtime(int threads) {
  choose_blas_kernels();
  use_memory_pool();
  at::set_num_threads(1);
  const double gflops = sgemm_gflops();
  at::set_num_threads(threads);
  flush_denormals(threads, true);
  // The reference BLAS reaches 4 GFLOP/s, OpenBLAS 30 and more on one old core.
  if (gflops < 8)
    spdlog::warn(
        "matrix products run at {:.1f} GFLOP/s: LibTorch uses a slow BLAS; install libopenblas0-openmp for a "
        "training 40 times faster",
        gflops);
}

}  // namespace ld
