#include "metrics/floor.h"

#include "metrics/image_pair.h"
#include "metrics/metric.h"

namespace ld {

ReferenceFloor reference_floor(const Image& first, const Image& second) {
  if (count_not_finite(first) > 0 || count_not_finite(second) > 0) return {};
  comparable(first, second);  // for its complaints
  Image mean = first;
  for (size_t i = 0; i < mean.pixels.size(); ++i)
    mean.pixels[i] = static_cast<float>((double{first.pixels[i]} + second.pixels[i]) / 2);
  ReferenceFloor floor;
  for (const Metric& metric : metrics())
    floor[metric.name] = (metric.compute(first, mean) + metric.compute(second, mean)) / 2;
  return floor;
}

}  // namespace ld
