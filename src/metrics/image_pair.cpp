#include "metrics/image_pair.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/tone_map.h"

namespace ld {
namespace {

void check_shape(const Image& image, const char* role) {
  if (image.channels != 3)
    fail("the {} picture has {} channels; a metric needs 3 (R, G, B)", role, image.channels);
  if (image.width < 1 || image.height < 1)
    fail("the {} picture is {}x{}; a metric needs at least one pixel", role, image.width, image.height);
  if (image.pixels.size() != image.plane_size() * 3)
    fail("the {} picture of {}x{} holds {} values; expected {}", role, image.width, image.height,
         image.pixels.size(), image.plane_size() * 3);
}

}  // namespace

int64_t count_not_finite(const Image& image) {
  return std::count_if(image.pixels.begin(), image.pixels.end(), [](float x) { return !std::isfinite(x); });
}

bool comparable(const Image& denoised, const Image& reference) {
  check_shape(denoised, "denoised");
  check_shape(reference, "reference");
  if (denoised.width != reference.width || denoised.height != reference.height)
    fail("the denoised picture is {}x{}, its reference {}x{}; a metric needs equal sizes", denoised.width,
         denoised.height, reference.width, reference.height);
  if (const int64_t bad = count_not_finite(reference))
    fail("the reference picture holds {} NaN or infinite values; nothing can be measured against it", bad);
  return count_not_finite(denoised) == 0;
}

std::vector<double> display_values(const Image& image) {
  std::vector<double> shown(image.pixels.size());
  std::transform(image.pixels.begin(), image.pixels.end(), shown.begin(),
                 [](float x) { return std::min(tone_map(static_cast<double>(x)), 1.0); });
  return shown;
}

}  // namespace ld
