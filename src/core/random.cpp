#include "core/random.h"

#include <cmath>
#include <numeric>
#include <utility>

namespace ld {
namespace {

// Multipliers and Weyl constants of Salmon et al., table 2 and section 4.3.
constexpr uint32_t kMultiplier0 = 0xD2511F53U, kMultiplier1 = 0xCD9E8D57U;
constexpr uint32_t kWeyl0 = 0x9E3779B9U, kWeyl1 = 0xBB67AE85U;

/// The finaliser of SplitMix64: spreads a small change of the seed over all bits of the key.
uint64_t mix(uint64_t x) {
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31);
}

}  // namespace

std::array<uint32_t, 4> philox4x32(std::array<uint32_t, 4> counter, std::array<uint32_t, 2> key) {
  for (int round = 0; round < 10; ++round) {
    const uint64_t product0 = uint64_t{kMultiplier0} * counter[0];
    const uint64_t product1 = uint64_t{kMultiplier1} * counter[2];
    counter = {static_cast<uint32_t>(product1 >> 32) ^ counter[1] ^ key[0], static_cast<uint32_t>(product1),
               static_cast<uint32_t>(product0 >> 32) ^ counter[3] ^ key[1], static_cast<uint32_t>(product0)};
    key[0] += kWeyl0;
    key[1] += kWeyl1;
  }
  return counter;
}

RandomStream::RandomStream(uint64_t seed, RandomPurpose purpose, uint32_t a, uint32_t b, uint32_t c) {
  const uint64_t key = mix(seed + 0x9E3779B97F4A7C15ULL * (static_cast<uint64_t>(purpose) + 1));
  key_ = {static_cast<uint32_t>(key), static_cast<uint32_t>(key >> 32)};
  counter_ = {0, c, b, a};
}

uint32_t RandomStream::bits() {
  if (used_ == 4) {
    block_ = philox4x32(counter_, key_);
    ++counter_[0];
    used_ = 0;
  }
  return block_[static_cast<size_t>(used_++)];
}

float RandomStream::uniform() {
  return static_cast<float>(bits() >> 8) * 0x1p-24F;
}

uint32_t RandomStream::below(uint32_t count) {
  uint64_t product = uint64_t{bits()} * count;
  const uint32_t threshold = (0U - count) % count;
  while (static_cast<uint32_t>(product) < threshold) product = uint64_t{bits()} * count;
  return static_cast<uint32_t>(product >> 32);
}

double RandomStream::normal() {
  if (has_spare_normal_) {
    has_spare_normal_ = false;
    return spare_normal_;
  }
  const double u = (static_cast<double>(bits()) + 1.0) * 0x1p-32;  // in (0, 1]: the logarithm is finite
  const double v = static_cast<double>(bits()) * 0x1p-32;
  const double radius = std::sqrt(-2.0 * std::log(u));
  const double angle = 6.283185307179586 * v;
  spare_normal_ = radius * std::sin(angle);
  has_spare_normal_ = true;
  return radius * std::cos(angle);
}

std::vector<uint32_t> random_permutation(RandomStream& stream, uint32_t count) {
  std::vector<uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0U);
  for (uint32_t i = count; i > 1; --i) std::swap(order[i - 1], order[stream.below(i)]);
  return order;
}

}  // namespace ld
