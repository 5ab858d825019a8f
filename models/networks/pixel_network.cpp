#include "models/networks/pixel_network.h"

#include "models/sample_statistics.h"
#include "ops/expect_tensor.h"
#include "ops/weighted_sum.h"

namespace ld {

using torch::Tensor;

namespace {

/// What the filter reads of some rows.
struct Pixels {
  Tensor log_n;       // [B, 1, H, W]
  Tensor radiance;    // the aggregate [B, C, H, W]
  Tensor embedding;   // of the pixel [B, E, H, W]
  Tensor context;     // C_xy [B, C, H, W]
  Tensor modulators;  // undefined without demodulation

  friend std::vector<Tensor*> tensors_of(Pixels& p) {
    return {&p.log_n, &p.radiance, &p.embedding, &p.context, &p.modulators};
  }
};

/// 0, or -inf for a pixel without samples, [B, 1, H, W].
Tensor log_weights_of_pixels(const NetworkInput& strip) {
  const Tensor drawn = strip.valid.ne(0).any(1);
  return at::zeros(drawn.sizes(), strip.radiance.options()).masked_fill(drawn.logical_not(), -kInfinity);
}

}  // namespace

PixelNetwork::PixelNetwork(const NetworkConfig& config)
    : ContextNetwork(config, 2 * channel_count(config.features)),
      kernel_generator_(register_module("kernel_generator",
                                        std::make_shared<KernelGenerator>(config, config.unet.context))) {}

Tensor PixelNetwork::denoise(const InputSource& input) {
  const InputSource::Sizes sizes = input.sizes();
  const PictureSize size = {sizes.batch, sizes.height, sizes.width};
  const int64_t sample_bytes = sizes.batch * sizes.samples * sizes.width * sizes.element_bytes *
                               (2 * (channel_count(config().features) + 4));
  const auto embedding_rows = [&](int64_t begin, int64_t end) {
    return in_strips(
        begin, end, short_strip_rows(end - begin, sample_bytes), [&](int64_t first, int64_t last) {
          const NetworkInput strip = input.rows(first, last);
          return sample_reducer_->forward(sample_statistics(strip.features, strip.valid)).squeeze(1);
        });  // of the pixel, [B, E, rows, W]
  };
  const Context context = make_context(embedding_rows, input, 1);
  return in_reaching_strips(
      size.height, second_half_rows(size, row_bytes(size)), filter_reach(),
      [&](int64_t begin, int64_t end) {
        Pixels made = in_strips(begin, end, short_strip_rows(end - begin, sample_bytes),
                                [&](int64_t first, int64_t last) {
                                  const NetworkInput strip = input.rows(first, last);
                                  Pixels pixels;
                                  pixels.log_n = log_weights_of_pixels(strip);
                                  pixels.radiance = masked_mean(strip.radiance, strip.valid);
                                  pixels.modulators = modulators_of(strip);
                                  return pixels;
                                });
        made.context = context_rows(context, begin, end);
        made.embedding = context.picture(begin, end);
        return made;
      },
      [&](const Pixels& made, int64_t first, int64_t begin, int64_t end) {
        const Tensor embedding = made.embedding.unsqueeze(1),
                     log_n = weighed(made.log_n, embedding, made.context);
        const Tensor filtered = filter(kernel_generator_->kernels(), embedding, made.context,
                                       log_n.squeeze(1), made.radiance, first);
        const Tensor picture = modulated(filtered, made.modulators, made.context);
        return rows(picture, begin - first, end - first);
      });
}

Kernels PixelNetwork::make_kernels(const InputSource& input) {
  const InputSource::Sizes sizes = input.sizes();
  const NetworkInput whole = input.rows(0, sizes.height);
  const Tensor embedding = sample_reducer_->forward(sample_statistics(whole.features, whole.valid));
  const Context context = make_context(
      [&](int64_t begin, int64_t end) { return rows(embedding.squeeze(1), begin, end); }, input, 1);
  const Tensor c = context_rows(context, 0, sizes.height);
  return {kernel_generator_->logits(embedding, c), weighed(log_weights_of_pixels(whole), embedding, c)};
}

int64_t PixelNetwork::row_bytes(const PictureSize& size) const {
  return 2 * size.batch *
         (config().unet.context + config().sample_reducer.back() + 32 + 5 * (radiance_channels() - 3)) *
         size.width * int64_t(sizeof(float));
}

int64_t PixelNetwork::memory_bytes(int64_t, int64_t height, int64_t width) const {
  const PictureSize size = {1, height, width};
  return memory_of(size, 1, row_bytes(size), 3 * height * width * int64_t(sizeof(float)));
}

}  // namespace ld
