#include "filters/eaw.h"

#include <utility>

#include "filters/kernels/eaw_level.h"
#include "filters/levels.h"
#include "runtime/denormals.h"

namespace ld {

void eaw_level(const Surfaces& surfaces, const RowPlanes& in, RowPlanes& out, int64_t level,
               const EawSettings& settings, int threads) {
  const std::array<float, 3> taps = a_trous_taps(settings.kernel);
  const double fourths = settings.narrow ? double(int64_t{1} << (2 * level)) : 1;
  EawPrecision precision;
  precision.light = float(fourths / settings.sigma_light);
  precision.normal = float(1 / (settings.sigma_normal * fourths));
  precision.place = float(1 / settings.sigma_place / (double(surfaces.unit) * double(surfaces.unit)));
  for_each_piece(threads, in.width(), in.height(), level, [&](const LevelPiece& piece) {
    eaw_level_row(level_row(surfaces, in, out, piece, level, taps), precision, in.planes() / 3,
                  settings.range == "luminance", settings.place == "depth" || !surfaces.has_position);
  });
}

void eaw(const Surfaces& surfaces, RowPlanes& signals, RowPlanes& spare, const EawSettings& settings,
         int threads) {
  const FlushedDenormals flushed(threads);
  resize(spare, signals.width(), signals.height(), signals.planes());
  for (int64_t level = 0; level < settings.levels; ++level) {
    eaw_level(surfaces, signals, spare, level, settings, threads);
    std::swap(signals, spare);
  }
}

}  // namespace ld
