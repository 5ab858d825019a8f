#include "render/geometry/sample_numbers.h"

namespace ld {
namespace {

uint32_t reverse_bits(uint32_t x) {
  x = __builtin_bswap32(x);
  x = ((x >> 4) & 0x0F0F0F0FU) | ((x & 0x0F0F0F0FU) << 4);
  x = ((x >> 2) & 0x33333333U) | ((x & 0x33333333U) << 2);
  return ((x >> 1) & 0x55555555U) | ((x & 0x55555555U) << 1);
}

/// Owen's scrambling in base 2 of a bit-reversed number: each bit flips depending on the bits below it (Laine
/// and Karras 2011, with the constants of Vegdahl, "Building a better LK hash", 2021).
uint32_t scramble_reversed(uint32_t x, uint32_t seed) {
  x ^= x * 0x3D20ADEAU;
  x += seed;
  x *= (seed >> 16) | 1;
  x ^= x * 0x05526C56U;
  x ^= x * 0x53A22864U;
  return x;
}

uint32_t hash(uint32_t x) {  // the finaliser of MurmurHash3
  x = (x ^ (x >> 16)) * 0x85EBCA6BU;
  x = (x ^ (x >> 13)) * 0xC2B2AE35U;
  return x ^ (x >> 16);
}

/// Second dimension of Sobol's sequence, bit-reversed: the direction numbers are the rows of Pascal's
/// triangle modulo 2, so with the index's bits as a polynomial's coefficients it is p(x + 1) modulo 2, half
/// by half: the upper half of each block is added to its lower one (Ahmed, "An implementation algorithm of 2D
/// Sobol sequence", 2024). The first dimension, bit-reversed, is the index.
uint32_t sobol_second_reversed(uint32_t index) {
  index ^= index >> 16;
  index ^= (index & 0xFF00FF00U) >> 8;
  index ^= (index & 0xF0F0F0F0U) >> 4;
  index ^= (index & 0xCCCCCCCCU) >> 2;
  return index ^ ((index & 0xAAAAAAAAU) >> 1);
}

}  // namespace

Vec2 SampleNumbers::two() {
  if (spread_) return next_point();
  const float first = stream_.uniform();
  return {first, stream_.uniform()};
}

Vec2 SampleNumbers::next_point() {
  const uint32_t seed = hash(seed_ + 0x9E3779B9U * ++pair_);
  // Shuffling the index by a scramble keeps every aligned run of 2^k samples together.
  const uint32_t index = reverse_bits(scramble_reversed(reverse_bits(index_), seed));
  const uint32_t x = reverse_bits(scramble_reversed(index, hash(seed ^ 0x2C1B3C6DU)));
  const uint32_t y = reverse_bits(scramble_reversed(sobol_second_reversed(index), hash(seed ^ 0x297A2D39U)));
  return {to_unit(x), to_unit(y)};
}

}  // namespace ld
