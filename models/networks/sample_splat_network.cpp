#include "models/networks/sample_splat_network.h"

#include "models/networks/registry.h"
#include "ops/expect_tensor.h"
#include "ops/generated_filter.h"

namespace ld {

using torch::Tensor;

namespace {

/// Features in which a sample that is not valid has those of the pixel's first valid one. Its kernel weighs
/// nothing, but its logits would count in m_p; as a copy they change no bit of it.
Tensor with_valid_features(const Tensor& features, const Tensor& valid) {
  const Tensor drawn = valid.ne(0);
  if (drawn.all().item<bool>()) return features;
  const Tensor own = at::arange(valid.size(1), valid.options().dtype(torch::kInt64)).view({1, -1, 1, 1, 1});
  const Tensor first = drawn.to(torch::kUInt8).argmax(1, /*keepdim=*/true);
  return features.gather(1, at::where(drawn, own, first).expand(features.sizes()));
}

/// The input with those.
class ValidFeatures : public InputSource {
 public:
  explicit ValidFeatures(const InputSource& input) : input_(input) {}
  Sizes sizes() const override { return input_.sizes(); }
  NetworkInput rows(int64_t begin, int64_t end) const override {
    NetworkInput strip = input_.rows(begin, end);
    strip.features = with_valid_features(strip.features, strip.valid);
    return strip;
  }

 private:
  const InputSource& input_;
};

}  // namespace

SampleSplatNetwork::SampleSplatNetwork(const NetworkConfig& config)
    : ContextNetwork(config, channel_count(config.features)),
      kernel_generator_(register_module("kernel_generator",
                                        std::make_shared<KernelGenerator>(config, config.unet.context))) {}

namespace {

/// 0, or -inf for a sample that is not valid, [B, S, H, W].
Tensor log_weights(const Tensor& valid) {
  return at::zeros_like(valid).masked_fill(valid.eq(0), -kInfinity).squeeze(2);
}

}  // namespace

Kernels SampleSplatNetwork::make_kernels(const InputSource& given) {
  const ValidFeatures input(given);
  const int64_t height = input.sizes().height;
  const SampleEmbeddings embeddings(*sample_reducer_, input);
  const Context context =
      make_context([&](int64_t begin, int64_t end) { return embeddings.mean(begin, end); }, input, 1);
  const NetworkInput whole = input.rows(0, height);
  const Tensor embedding = embeddings.of_rows(whole, 0, height), c = context_rows(context, 0, height);
  return {kernel_generator_->logits(embedding, c), weighed(log_weights(whole.valid), embedding, c)};
}

Tensor SampleSplatNetwork::denoise(const InputSource& given) {
  const ValidFeatures input(given);
  const SampleEmbeddings embeddings(*sample_reducer_, input);  // E_xys
  const Context context =
      make_context([&](int64_t begin, int64_t end) { return embeddings.mean(begin, end); }, input, 1);
  const InputSource::Sizes sizes = input.sizes();
  const PictureSize size = {sizes.batch, sizes.height, sizes.width};
  return in_reaching_strips(
      size.height, second_half_rows(size, row_bytes(size, sizes.samples)), filter_reach(),
      [&](int64_t begin, int64_t end) {
        return context_rows(context, begin, end);  // C_xy
      },
      [&](const Tensor& made, int64_t first, int64_t begin, int64_t end) {
        const int64_t last = first + made.size(2);
        NetworkInput strip = input.rows(first, last);
        const Tensor embedding = embeddings.of_rows(strip, first, last);
        strip.features = Tensor();
        const Tensor log_n = weighed(log_weights(strip.valid), embedding, made);
        const Tensor filtered = generated_splat_joint(kernel_generator_->kernels(), embedding, made, log_n,
                                                      strip.radiance, first);
        const Tensor picture = modulated(filtered, modulators_of(strip), made);
        return rows(picture, begin - first, end - first);
      });
}

int64_t SampleSplatNetwork::row_bytes(const PictureSize& size, int64_t samples) const {
  const int64_t of_sample = int64_t{2} * (channel_count(config().features) + 4) +
                            config().sample_reducer.back() + 8 + 3 * (radiance_channels() - 3);
  return size.batch * (2 * config().unet.context + samples * of_sample) * size.width * int64_t(sizeof(float));
}

int64_t SampleSplatNetwork::memory_bytes(int64_t samples, int64_t height, int64_t width) const {
  const PictureSize size = {1, height, width};
  return memory_of(size, 1, row_bytes(size, samples), 3 * height * width * int64_t(sizeof(float)));
}

std::shared_ptr<Network> make_sample_splat_network(const NetworkConfig& config) {
  return std::make_shared<SampleSplatNetwork>(config);
}

}  // namespace ld
