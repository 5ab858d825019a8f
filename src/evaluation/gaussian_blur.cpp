#include "evaluation/gaussian_blur.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/error.h"

namespace ld {
namespace {

/// Weights of the offsets 0, 1, ... radius, not normalised.
std::vector<double> half_gaussian(double sigma) {
  const int radius = static_cast<int>(std::ceil(3 * sigma));
  std::vector<double> weights;
  for (int i = 0; i <= radius; ++i) weights.push_back(std::exp(-0.5 * i * i / (sigma * sigma)));
  return weights;
}

/// Where the window of each position of an axis begins and ends inside the picture, and what its weights sum
/// to there.
struct Window {
  int first, last;
  double sum;
};

std::vector<Window> windows(int length, const std::vector<double>& weights) {
  const int radius = static_cast<int>(weights.size()) - 1;
  std::vector<Window> result;
  for (int i = 0; i < length; ++i) {
    Window window{std::max(i - radius, 0), std::min(i + radius, length - 1), 0};
    for (int j = window.first; j <= window.last; ++j) window.sum += weights[size_t(std::abs(i - j))];
    result.push_back(window);
  }
  return result;
}

}  // namespace

Image gaussian_blur(const Image& image, double sigma) {
  if (!(sigma > 0) || !std::isfinite(sigma))
    fail("a Gaussian blur of sigma {}; expected a number above 0", sigma);
  const std::vector<double> weights = half_gaussian(sigma);
  const std::vector<Window> columns = windows(image.width, weights), rows = windows(image.height, weights);
  const auto width = static_cast<size_t>(image.width);

  Image result(image.width, image.height, image.channels);
  std::vector<double> horizontal(image.plane_size()), line(width);
  for (int c = 0; c < image.channels; ++c) {
    // Along each row.
    for (int y = 0; y < image.height; ++y) {
      const float* in = image.plane(c) + size_t(y) * width;
      for (int x = 0; x < image.width; ++x) {
        const Window& window = columns[size_t(x)];
        double sum = 0;
        for (int j = window.first; j <= window.last; ++j) sum += weights[size_t(std::abs(x - j))] * in[j];
        horizontal[size_t(y) * width + size_t(x)] = sum / window.sum;
      }
    }
    // Along each column, a whole row at a time.
    for (int y = 0; y < image.height; ++y) {
      const Window& window = rows[size_t(y)];
      std::fill(line.begin(), line.end(), 0.0);
      for (int j = window.first; j <= window.last; ++j) {
        const double weight = weights[size_t(std::abs(y - j))] / window.sum;
        const double* in = horizontal.data() + size_t(j) * width;
        for (size_t x = 0; x < width; ++x) line[x] += weight * in[x];
      }
      std::transform(line.begin(), line.end(), result.plane(c) + size_t(y) * width,
                     [](double x) { return static_cast<float>(x); });
    }
  }
  return result;
}

}  // namespace ld
