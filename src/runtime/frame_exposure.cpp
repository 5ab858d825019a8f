#include "runtime/frame_exposure.h"

#include "models/log_luminance.h"
#include "runtime/parallel.h"

namespace ld {
namespace {

LogLuminance log_luminance_of_row(const Frame& frame, int64_t y) {
  LogLuminance sum;
  for (int64_t p = y * frame.width; p < (y + 1) * frame.width; ++p) {
    double light = 0;
    int64_t drawn = 0;
    for (int s = 0; s < frame.spp; ++s) {
      if (frame.valid_plane(s)[p] == 0) continue;
      const auto radiance = [&](int c) { return double(frame.plane(s, kRadianceOffset + c)[p]); };
      light += luminance(radiance(0), radiance(1), radiance(2));
      ++drawn;
    }
    sum.add(light / double(std::max<int64_t>(drawn, 1)));
  }
  return sum;
}

}  // namespace

double frame_exposure(const Frame& frame, int threads) {
  std::vector<LogLuminance> rows(static_cast<size_t>(frame.height));
  parallel_for(threads, frame.height,
               [&](int64_t y, int) { rows[size_t(y)] = log_luminance_of_row(frame, y); });
  LogLuminance sum;
  for (const LogLuminance& row : rows) sum.add(row);
  return sum.exposure();
}

}  // namespace ld
