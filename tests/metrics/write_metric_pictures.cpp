// Writes pairs of pictures and what our metrics say about them, for tests/metrics/skimage_test.py:
// write_metric_pictures FOLDER. A pair is FOLDER/N.denoised and N.reference, float32 [3, height, width];
// scores.json lists them.
#include <nlohmann/json.hpp>

#include <cstdio>
#include <filesystem>
#include <string>

#include "core/file_io.h"
#include "metrics/psnr.h"
#include "metrics/relmse.h"
#include "metrics/smape.h"
#include "metrics/ssim.h"
#include "plain_metrics.h"

namespace {

void write_picture(const std::filesystem::path& path, const ld::Image& image) {
  ld::write_file_atomically(path, std::string(reinterpret_cast<const char*>(image.pixels.data()),
                                              image.pixels.size() * sizeof(float)));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: write_metric_pictures FOLDER\n");
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  nlohmann::json scores = nlohmann::json::array();
  uint32_t number = 0;
  for (const auto& [width, height] : {std::pair{64, 48}, {31, 33}, {11, 11}, {128, 128}, {12, 200}})
    for (const double noise : {0.01, 0.3, 1.5}) {
      const ld::Image reference = ld::plain::random_image(width, height, number);
      ld::Image denoised = ld::plain::with_noise(reference, noise, number);
      denoised.at(1, width / 2, height / 2) = -0.5F;
      denoised.at(2, width / 3, height / 3) = 60000;
      const std::string name = std::to_string(number++);
      write_picture(folder / (name + ".denoised"), denoised);
      write_picture(folder / (name + ".reference"), reference);
      scores.push_back({{"name", name},
                        {"width", width},
                        {"height", height},
                        {"relmse", ld::relmse(denoised, reference)},
                        {"smape", ld::smape(denoised, reference)},
                        {"ssim", ld::ssim(denoised, reference)},
                        {"psnr", ld::psnr(denoised, reference)}});
    }
  ld::write_file_atomically(folder / "scores.json", scores.dump());
  return 0;
}
