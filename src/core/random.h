// Counter-based random numbers: Philox4x32-10 (Salmon et al., "Parallel random numbers: as easy as 1, 2, 3",
// SC 2011). A number depends only on its key and counter, never on what was drawn before or by which thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace ld {

/// One block of Philox4x32-10: 128 random bits from a 128-bit counter and a 64-bit key. Multipliers and Weyl
/// constants of Salmon et al., table 2 and section 4.3. Inline, as are draws: paths spend a tenth of their
/// time here.
inline std::array<uint32_t, 4> philox4x32(std::array<uint32_t, 4> counter, std::array<uint32_t, 2> key) {
  constexpr uint32_t kMultiplier0 = 0xD2511F53U, kMultiplier1 = 0xCD9E8D57U;
  constexpr uint32_t kWeyl0 = 0x9E3779B9U, kWeyl1 = 0xBB67AE85U;
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

/// The upper 24 bits as a number in [0, 1), so that float represents every value exactly.
inline float to_unit(uint32_t bits) {
  return static_cast<float>(bits >> 8) * 0x1p-24F;
}

/// What a stream is for. Two purposes never share a number, whatever the seed and indices.
enum class RandomPurpose : uint32_t {
  scene = 1,          // layout, materials and camera of a random scene
  input_samples = 2,  // the noisy samples of a frame
  reference = 3,      // the samples of the reference image
  initial_weights = 4,
  data_order = 5,    // shuffling of the training frames
  augmentation = 6,  // crops, flips, rotations
  test = 7,
};

/// A stream of numbers keyed by (seed, purpose, three indices), for instance (seed, samples, frame, pixel,
/// sample).
class RandomStream {
 public:
  RandomStream(uint64_t seed, RandomPurpose purpose, uint32_t a = 0, uint32_t b = 0, uint32_t c = 0);

  uint32_t bits() {
    if (used_ == 4) {
      block_ = philox4x32(counter_, key_);
      ++counter_[0];
      used_ = 0;
    }
    return block_[static_cast<size_t>(used_++)];
  }
  /// Uniform in [0, 1).
  float uniform() { return to_unit(bits()); }
  float uniform(float low, float high) { return low + (high - low) * uniform(); }
  /// Uniform in {0, ..., count - 1}; count at least 1. Unbiased (Lemire's rejection).
  uint32_t below(uint32_t count);
  /// Standard normal (Box-Muller, both values used).
  double normal();

 private:
  std::array<uint32_t, 2> key_;
  std::array<uint32_t, 4> counter_;
  std::array<uint32_t, 4> block_{};
  int used_ = 4;
  double spare_normal_ = 0;
  bool has_spare_normal_ = false;
};

/// A permutation of 0 .. count - 1 (Fisher-Yates).
std::vector<uint32_t> random_permutation(RandomStream& stream, uint32_t count);

}  // namespace ld
