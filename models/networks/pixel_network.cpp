#include "models/networks/pixel_network.h"

#include "models/sample_statistics.h"
#include "ops/expect_tensor.h"
#include "ops/weighted_sum.h"

namespace ld {

using torch::Tensor;

PixelNetwork::PixelNetwork(const NetworkConfig& config)
    : ContextNetwork(config, int64_t{2} * channel_count(config.features)) {}

/// Memory of a row of samples.
int64_t PixelNetwork::sample_row_bytes(const InputSource& input) const {
  const InputSource::Sizes sizes = input.sizes();
  const int64_t channels = channel_count(config().features) + 4;
  return sizes.batch * sizes.samples * sizes.width * sizes.element_bytes * 2 * channels;
}

ContextNetwork::Context PixelNetwork::make_pixel_context(const InputSource& input) const {
  const int64_t bytes = sample_row_bytes(input);
  const PictureRows embedding_rows = [this, &input, bytes](int64_t begin, int64_t end) {
    return in_strips(begin, end, short_strip_rows(end - begin, bytes), [&](int64_t first, int64_t last) {
      const NetworkInput strip = input.rows(first, last);
      return sample_reducer_->forward(sample_statistics(strip.features, strip.valid)).squeeze(1);
    });
  };
  return make_context(embedding_rows, input, 1);
}

PixelNetwork::Pixels PixelNetwork::pixels_of_rows(const InputSource& input, const Context& context,
                                                  int64_t begin, int64_t end) const {
  const int64_t step = short_strip_rows(end - begin, sample_row_bytes(input));
  Pixels pixels = in_strips(begin, end, step, [&](int64_t first, int64_t last) {
    const NetworkInput strip = input.rows(first, last);
    const Tensor drawn = strip.valid.ne(0).any(1);
    Pixels made;
    made.log_n =
        at::zeros(drawn.sizes(), strip.radiance.options()).masked_fill(drawn.logical_not(), -kInfinity);
    made.radiance = masked_mean(strip.radiance, strip.valid);
    made.modulators = modulators_of(strip);
    return made;
  });
  pixels.context = context_rows(context, begin, end);
  pixels.embedding = context.picture(begin, end).unsqueeze(1);
  return pixels;
}

Tensor PixelNetwork::denoise(const InputSource& input) {
  const Context context = make_pixel_context(input);
  const InputSource::Sizes sizes = input.sizes();
  const PictureSize size = {sizes.batch, sizes.height, sizes.width};
  return in_reaching_strips(
      size.height, second_half_rows(size, row_bytes(size)), filter_reach(),
      [&](int64_t begin, int64_t end) { return pixels_of_rows(input, context, begin, end); },
      [&](const Pixels& made, int64_t first, int64_t begin, int64_t end) {
        Pixels pixels = made;
        pixels.log_n = weighed(made.log_n, made.embedding, made.context);
        const Tensor picture = modulated(filter(pixels, first), made.modulators, made.context);
        return rows(picture, begin - first, end - first);
      });
}

Kernels PixelNetwork::make_kernels(const InputSource& input) {
  const Pixels pixels = pixels_of_rows(input, make_pixel_context(input), 0, input.sizes().height);
  return {logits(pixels), weighed(pixels.log_n, pixels.embedding, pixels.context)};
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
