// How much light a clear coat sends back, tabulated: what is left over enters the base beneath it.
#pragma once

namespace ld {

/// Directional albedo of a GGX dielectric interface seen from outside, its reflections alone: E(cos, alpha,
/// ior) of Kulla and Conty ("Revisiting physically based shading at Imageworks", SIGGRAPH courses 2017).
/// Interpolated from a table made on first use; cos in [0, 1], ior clamped to [1.01, 2.6].
class CoatAlbedo {
 public:
  CoatAlbedo(float alpha, float ior);

  float towards(float cos) const;
  /// Mean over the cosine-weighted hemisphere.
  float average() const { return average_; }

 private:
  const float* rows_[4];  // the table's rows around (alpha, ior)
  float weights_[4];
  float average_ = 0;
};

}  // namespace ld
