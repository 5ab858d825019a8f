// The C++ interface in one page: interleaved pixels, a memory bound, progress, errors as exceptions.
//   denoise_cpp WEIGHTS.safetensors
#include <cmath>
#include <cstdio>
#include <exception>
#include <map>
#include <random>
#include <vector>

#include <layered_denoiser/layered_denoiser.hpp>

namespace {

constexpr int kWidth = 80, kHeight = 60, kSpp = 4;

/// A renderer's own layout: all samples of a pixel side by side, each with its channels.
struct SampleBuffer {
  int channels;
  std::vector<float> data;

  explicit SampleBuffer(int c) : channels(c), data(size_t(kWidth) * kHeight * kSpp * size_t(c)) {}
  float* at(int x, int y, int s) {
    return &data[((size_t(y) * kWidth + size_t(x)) * kSpp + size_t(s)) * size_t(channels)];
  }
  LdStrides strides() const {
    return {channels, 1, ptrdiff_t(kWidth) * kSpp * channels, ptrdiff_t(kSpp) * channels};
  }
};

/// A grey floor of brightness 0.5 in a fog of noise: what the denoiser should give back is known.
void render(std::map<std::string, SampleBuffer>& buffers) {
  std::mt19937 random(1);
  std::exponential_distribution<float> noise(1);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      for (int s = 0; s < kSpp; ++s)
        for (auto& [name, buffer] : buffers) {
          float* sample = buffer.at(x, y, s);
          if (name == "radiance") sample[0] = sample[1] = sample[2] = 0.5F * noise(random);
          if (name == "albedo") sample[0] = sample[1] = sample[2] = 0.5F;
          if (name == "normal") sample[1] = 1;
          if (name == "depth") sample[0] = 10;
          if (name == "roughness") sample[0] = 1;
        }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: %s WEIGHTS.safetensors\n", argv[0]);
    return 2;
  }
  try {
    layered_denoiser::Denoiser denoiser(argv[1]);
    denoiser.set_size(kWidth, kHeight, kSpp);
    std::map<std::string, SampleBuffer> buffers;
    for (const auto& [name, channels] : denoiser.features()) buffers.emplace(name, SampleBuffer(channels));
    render(buffers);
    for (auto& [name, buffer] : buffers) {
      const LdStrides strides = buffer.strides();
      denoiser.set_feature(name, buffer.data.data(), &strides);
    }
    denoiser.set_max_memory(2000);
    denoiser.set_progress([](double) { return true; });
    std::vector<float> picture(size_t(3) * kWidth * kHeight);
    const LdStrides interleaved = {0, 1, ptrdiff_t(3) * kWidth, 3};
    denoiser.denoise(picture.data(), &interleaved);

    double sum = 0;
    for (const float value : picture) sum += (value - 0.5) * (value - 0.5);
    std::printf("root mean square error of the denoised picture: %.4f (a sample's noise: 0.5)\n",
                std::sqrt(sum / double(picture.size())));
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
