#include "models/networks/optimized_network.h"

#include "models/compositor.h"
#include "models/networks/registry.h"
#include "ops/expect_tensor.h"

namespace ld {

using torch::Tensor;

OptimizedNetwork::OptimizedNetwork(const NetworkConfig& config) : LayeredNetwork(config) {
  for (int64_t i = 0; i < config.levels; ++i)
    kernel_generators_.push_back(
        register_module("kernel_generator" + std::to_string(i),
                        std::make_shared<KernelGenerator>(config, UNet::feature_channels(config.unet, i),
                                                          i == 0 ? config.levels : 0)));  // lambda_i
}

struct OptimizedNetwork::Levels {
  Tensor logits;                 // of lambda_i [B, levels, H, W]
  std::vector<Tensor> pictures;  // G_i [B, C, H / 2^i, W / 2^i]
  std::vector<Tensor> received;  // 1 where a level received something, else 0 [B, 1, H / 2^i, W / 2^i]
  Tensor factors;                // of models/demodulation.h [B, 4, H, W]; undefined without
};

namespace {

/// Of the finest level; names as in Levels.
struct FinestRows {
  Tensor logits, picture, received, factors;
  friend std::vector<Tensor*> tensors_of(FinestRows& r) {
    return {&r.logits, &r.picture, &r.received, &r.factors};
  }
};

}  // namespace

Tensor OptimizedNetwork::denoise(const InputSource& input) {
  const Levels levels = filter_levels(input);
  const int64_t height = levels.logits.size(2), width = levels.logits.size(3), count = config().levels;
  const int64_t multiple = int64_t(1) << (count - 1);
  const int64_t row_bytes = levels.logits.size(0) * count * 32 * radiance_channels() / 3 * width *
                            int64_t(levels.logits.element_size());
  const int64_t step = (strip_rows(height, row_bytes) + multiple - 1) / multiple * multiple;
  return in_strips(height, step,
                   [&](int64_t begin, int64_t end) { return blend_rows(levels, begin, end, width); });
}

OptimizedNetwork::Levels OptimizedNetwork::filter_levels(const InputSource& input) const {
  const SampleEmbeddings embeddings(*sample_reducer_, input);
  const Context context = make_context(
      [&](int64_t begin, int64_t end) { return embeddings.mean(begin, end); }, input, config().levels);
  const InputSource::Sizes sizes = input.sizes();
  const PictureSize size = {sizes.batch, sizes.height, sizes.width};
  const int64_t count = config().levels;
  const int64_t multiple = int64_t(1) << (count - 1);  // whole pixels of the coarsest level
  const int64_t step = (second_half_rows(size, layers_row_bytes(size)) + multiple - 1) / multiple * multiple;

  std::vector<std::vector<PyramidLevel>> coarser(static_cast<size_t>(count));  // [level][strip]
  const FinestRows finest = in_reaching_strips(
      size.height, step, filter_reach(),
      [&](int64_t begin, int64_t end) { return make_layers(input, embeddings, context, begin, end); },
      [&](const Layers& layers, int64_t first, int64_t begin, int64_t end) {
        const Layers here = rows_of(layers, begin - first, end - first);
        const std::vector<PyramidLevel> pyramid = layer_pyramid(here.partition, count);
        for (size_t i = 1; i < pyramid.size(); ++i) coarser[i].push_back(pyramid[i]);
        const Tensor picture = filter_and_composite(kernel_generators_[0]->kernels(), layers.partition,
                                                    layers.context, compositing(), first);  // G_0
        const Tensor pixels = layer_pyramid(layers.partition, 1)[0].pixels;
        FinestRows made;
        made.logits = fully_connected(here.partition.embedding.narrow(1, 0, 1), here.context,
                                      kernel_generators_[0]->further(), /*activate_last=*/false)
                          .squeeze(1);
        made.picture = rows(picture, begin - first, end - first);
        made.received = rows(received(pixels), begin - first, end - first);
        if (modulation_)
          made.factors =
              rows(modulation_->factors(layers.modulators, layers.context), begin - first, end - first);
        return made;
      });
  Levels levels{finest.logits, {finest.picture}, {finest.received}, finest.factors};
  for (int64_t i = 1; i < count; ++i) {
    const PyramidLevel level = stacked_rows(std::move(coarser[size_t(i)]));
    levels.pictures.push_back(filter_and_composite(kernel_generators_[size_t(i)]->kernels(), level.layers,
                                                   context.coarse.features[size_t(i)],
                                                   compositing()));  // G_i
    levels.received.push_back(received(level.pixels));
  }
  return levels;
}

/// eq. 10 of rows [begin, end), `begin` at a whole pixel of the coarsest level.
Tensor OptimizedNetwork::blend_rows(const Levels& levels, int64_t begin, int64_t end, int64_t width) const {
  std::vector<Tensor> pictures, log_coverage;
  for (int64_t i = 0; i < config().levels; ++i) {
    // A pixel that received nothing is 0 in G_i. Upscaling blends it with its neighbours, and dividing by
    // what the upscaled pixel has of those that received something leaves their mean.
    const Tensor coverage = upscale(levels.received[size_t(i)], i, begin, end, width);
    pictures.push_back(upscale(levels.pictures[size_t(i)], i, begin, end, width) /
                       coverage.masked_fill(coverage.eq(0), 1));
    log_coverage.push_back(coverage.log());
  }
  const Tensor known = at::cat(log_coverage, 1);  // -inf for a level without anything to say
  const Tensor nothing = known.eq(-kInfinity).all(1, /*keepdim=*/true);
  const Tensor logits = rows(levels.logits, begin, end) + known.masked_fill(nothing, 0);
  const Tensor lambda = at::softmax(logits, 1).unsqueeze(2);                       // [B, levels, 1, H, W]
  const Tensor picture = weighted_sum(lambda, at::stack(pictures, 1)).squeeze(1);  // eq. 10
  return modulation_ ? Modulation::apply(picture, rows(levels.factors, begin, end)) : picture;
}

/// 1 where the kernels of a level reach from a pixel with samples, else 0, [B, 1, H, W]: such a weight is
/// never 0, however small (ops/kernel_splat.h).
Tensor OptimizedNetwork::received(const Tensor& pixels) const {
  const int64_t kernel = config().kernel_size;
  return at::max_pool2d(pixels.gt(0).to(pixels.scalar_type()), kernel, /*stride=*/1, kernel / 2);
}

/// Rows [begin, end) of a picture of level `level` at full resolution, [B, C, end - begin, width].
Tensor OptimizedNetwork::upscale(const Tensor& coarse, int64_t level, int64_t begin, int64_t end,
                                 int64_t width) const {
  if (level == 0) return rows(coarse, begin, end);
  // One more row on either side: what bilinear upsampling blends the outermost rows with.
  const int64_t first = std::max<int64_t>((begin >> level) - 1, 0),
                last = std::min(((end - 1) >> level) + 2, coarse.size(2));
  const Tensor part = rows(coarse, first, last);
  const std::vector<int64_t> size = {part.size(2) << level, part.size(3) << level};
  const Tensor fine = config().unet.upsampling == "bilinear"
                          ? at::upsample_bilinear2d(part, size, /*align_corners=*/false)
                          : at::upsample_nearest2d(part, size);
  return rows(fine, begin - (first << level), end - (first << level)).narrow(3, 0, width);
}

void OptimizedNetwork::begin_sharp() {
  const torch::NoGradGuard no_gradient;
  Tensor bias = kernel_generators_[0]->further().biases.back();
  bias.narrow(0, 0, 1).fill_(3);
}

Kernels OptimizedNetwork::make_kernels(const InputSource& input) {
  return kernels_of_layers(input, *kernel_generators_[0]);
}

int64_t OptimizedNetwork::memory_bytes(int64_t, int64_t height, int64_t width) const {
  const PictureSize size = {1, height, width};
  const int64_t further = radiance_channels() - 3;
  const int64_t floats_of_layers =
      config().layers * (config().sample_reducer.back() + 6 + 12 + 3 * further) + 8;
  // Results of the finest level and of all; the coarser levels' layers, twice while they are put together.
  const int64_t floats = 2 * (3 + 1 + config().levels + 3 * further) + 2 * floats_of_layers / 3 + 1;
  return memory_of(size, config().levels, layers_row_bytes(size),
                   floats * height * width * int64_t(sizeof(float)));
}

std::shared_ptr<Network> make_optimized_network(const NetworkConfig& config) {
  return std::make_shared<OptimizedNetwork>(config);
}

}  // namespace ld
