#include "ops/memory_pool.h"

#include <gtest/gtest.h>
#include <torch/torch.h>

#include <thread>

#include "ops/composition.h"

namespace ld {
namespace {

constexpr int64_t kMegabyte = int64_t(1) << 20;

torch::Tensor tensor_of(int64_t bytes) {
  return torch::empty({bytes}, torch::kUInt8);
}

class MemoryPool : public testing::Test {
 protected:
  MemoryPool() {
    use_memory_pool();
    release_memory_pool();
  }
};

TEST_F(MemoryPool, GivesOutWhatCameBack) {
  torch::Tensor first = tensor_of(8 * kMegabyte);
  const void* const memory = first.data_ptr();
  EXPECT_EQ(memory_pool_state().live, 8 * kMegabyte);
  first = torch::Tensor();
  EXPECT_EQ(memory_pool_state().live, 0);
  EXPECT_EQ(memory_pool_state().pooled, 8 * kMegabyte);
  const torch::Tensor second = tensor_of(8 * kMegabyte);
  EXPECT_EQ(second.data_ptr(), memory);
  EXPECT_EQ(memory_pool_state().pooled, 0);
}

TEST_F(MemoryPool, WhatItKeepsDoesNotRaiseThePeakByMoreThanAnEighth) {
  for (int64_t size = 4; size < 120; size += 3) {  // sizes of many classes, two live at a time
    const torch::Tensor a = tensor_of(size * kMegabyte), b = tensor_of((size + 1) * kMegabyte);
    const MemoryPoolState state = memory_pool_state();
    EXPECT_LE(state.live + state.pooled, state.peak_live + state.peak_live / 8) << size;
    EXPECT_GE(state.live, (2 * size + 1) * kMegabyte);
    EXPECT_LE(state.live, (2 * size + 1) * kMegabyte * 9 / 8);
  }
}

TEST_F(MemoryPool, ReleasesAllThatIsNotInUse) {
  const torch::Tensor kept = tensor_of(4 * kMegabyte);
  { const torch::Tensor gone = tensor_of(16 * kMegabyte); }
  EXPECT_EQ(memory_pool_state().pooled, 16 * kMegabyte);
  release_memory_pool();
  EXPECT_EQ(memory_pool_state().pooled, 0);
  EXPECT_EQ(memory_pool_state().live, 4 * kMegabyte);
}

TEST_F(MemoryPool, SmallTensorsAndCompositionsPassItBy) {
  const torch::Tensor small = tensor_of(kMegabyte / 2);
  EXPECT_EQ(memory_pool_state().live, 0);
  const ComposedOperators scope;
  const torch::Tensor large = tensor_of(8 * kMegabyte);
  EXPECT_EQ(memory_pool_state().live, 0);
}

TEST_F(MemoryPool, TakesBackFromAnotherThread) {
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i)
    threads.emplace_back([t = tensor_of(2 * kMegabyte)]() mutable {
      for (int k = 0; k < 50; ++k) {
        t = tensor_of((2 + k % 3) * kMegabyte);
        t.fill_(k);
        ASSERT_EQ(t[0].item<int>(), k);
      }
    });
  for (std::thread& thread : threads) thread.join();
  threads.clear();
  EXPECT_EQ(memory_pool_state().live, 0);
}

}  // namespace
}  // namespace ld
