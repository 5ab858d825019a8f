#include "models/networks/pixel_network.h"

#include <limits>

#include "models/sample_statistics.h"
#include "ops/weighted_sum.h"

namespace ld {

using torch::Tensor;

PixelNetwork::PixelNetwork(const NetworkConfig& config)
    : ContextNetwork(config, int64_t{2} * channel_count(config.features)),
      kernel_generator_(register_module("kernel_generator",
                                        std::make_shared<KernelGenerator>(config, config.unet.context))) {}

Tensor PixelNetwork::denoise(const InputSource& input) {
  const InputSource::Sizes sizes = input.sizes();
  const PictureSize size = {sizes.batch, sizes.height, sizes.width};
  const int64_t sample_bytes = sizes.batch * sizes.samples * sizes.width * sizes.element_bytes *
                               (int64_t{2} * (channel_count(config().features) + 4));
  const auto embedding_rows = [&](int64_t begin, int64_t end) {
    return in_strips(
        begin, end, short_strip_rows(end - begin, sample_bytes), [&](int64_t first, int64_t last) {
          const NetworkInput strip = input.rows(first, last);
          return std::vector<Tensor>{
              sample_reducer_->forward(sample_statistics(strip.features, strip.valid)).squeeze(1)};
        })[0];  // of the pixel, [B, E, rows, W]
  };
  const Context context = make_context(embedding_rows, input, 1);
  return in_reaching_strips(
      size.height, second_half_rows(size, row_bytes(size)), filter_reach(),
      [&](int64_t begin, int64_t end) {
        std::vector<Tensor> made = in_strips(
            begin, end, short_strip_rows(end - begin, sample_bytes), [&](int64_t first, int64_t last) {
              const NetworkInput strip = input.rows(first, last);
              const Tensor drawn = strip.valid.ne(0).any(1);  // [B, 1, rows, W]
              const Tensor log_n =
                  at::zeros(drawn.sizes(), strip.radiance.options())
                      .masked_fill(drawn.logical_not(), -std::numeric_limits<double>::infinity());
              std::vector<Tensor> pixels = {log_n,
                                            masked_mean(strip.radiance, strip.valid)};  // the aggregate
              if (modulation_) pixels.push_back(modulators_of(strip));
              return pixels;
            });
        const Tensor of_pixels = modulation_ ? made.back() : Tensor();
        made.resize(2);
        made.push_back(context_rows(context, begin, end));  // C_xy
        made.push_back(context.picture(begin, end));
        if (modulation_) made.push_back(of_pixels);
        return made;
      },
      [&](const std::vector<Tensor>& made, int64_t first, int64_t begin, int64_t end) {
        const Tensor embedding = made[3].unsqueeze(1), log_n = weighed(made[0], embedding, made[2]);
        const Tensor filtered =
            filter(kernel_generator_->kernels(), embedding, made[2], log_n.squeeze(1), made[1], first);
        const Tensor picture = modulated(filtered, modulation_ ? made[4] : Tensor(), made[2]);
        return std::vector<Tensor>{rows(picture, begin - first, end - first)};
      })[0];
}

Kernels PixelNetwork::make_kernels(const InputSource& input) {
  const InputSource::Sizes sizes = input.sizes();
  const NetworkInput whole = input.rows(0, sizes.height);
  const Tensor embedding = sample_reducer_->forward(sample_statistics(whole.features, whole.valid));
  const Context context = make_context(
      [&](int64_t begin, int64_t end) { return rows(embedding.squeeze(1), begin, end); }, input, 1);
  const Tensor drawn = whole.valid.ne(0).any(1);  // [B, 1, H, W]
  const Tensor log_n = at::zeros(drawn.sizes(), whole.radiance.options())
                           .masked_fill(drawn.logical_not(), -std::numeric_limits<double>::infinity());
  const Tensor c = context_rows(context, 0, sizes.height);
  return {kernel_generator_->logits(embedding, c), weighed(log_n, embedding, c)};
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
