// Sequences through SVGF, for its tests.
#pragma once

#include <algorithm>
#include <vector>

#include "filter_scenes.h"
#include "filters/svgf.h"

namespace ld {

/// A filter and its state, as a sequence needs them.
struct Sequence {
  SvgfSettings settings;
  int threads = 1;
  SvgfState state = {};
  SvgfMemory memory = {};

  RowPlanes operator()(Surfaces surfaces, const RowPlanes& signals) {
    return svgf(surfaces, signals, state, memory, settings, threads);
  }
  float length(int x, int y) const { return state.length_row(y)[x]; }
};

inline bool same_bits(const RowPlanes& a, const RowPlanes& b) {
  for (int y = 0; y < a.height(); ++y)
    for (int p = 0; p < a.planes(); ++p)
      if (!std::equal(a.row(y, p), a.row(y, p) + a.width(), b.row(y, p))) return false;
  return true;
}

inline SvgfSettings no_feedback() {
  SvgfSettings settings;
  settings.feedback = -1;
  settings.antilag = "none";
  return settings;
}

/// The accumulated light (before the levels) of frames of a scene; feedback is off, so it is the state's.
template <class Scene>
std::vector<RowPlanes> accumulated(int frames, const SvgfSettings& settings, const Scene& scene) {
  Sequence sequence{settings};
  std::vector<RowPlanes> out;
  for (int f = 0; f < frames; ++f) {
    auto [surfaces, signals] = scene(f);
    sequence(surfaces, signals);
    out.push_back(sequence.state.light);
  }
  return out;
}

}  // namespace ld
