#include "core/random.h"

#include <cmath>
#include <numeric>
#include <utility>

namespace ld {
namespace {

/// The finaliser of SplitMix64: spreads a small change of the seed over all bits of the key.
uint64_t mix(uint64_t x) {
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31);
}

}  // namespace

RandomStream::RandomStream(uint64_t seed, RandomPurpose purpose, uint32_t a, uint32_t b, uint32_t c) {
  const uint64_t key = mix(seed + 0x9E3779B97F4A7C15ULL * (static_cast<uint64_t>(purpose) + 1));
  key_ = {static_cast<uint32_t>(key), static_cast<uint32_t>(key >> 32)};
  counter_ = {0, c, b, a};
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
