// What every denoising network takes, and the one place where it is checked and made safe.
#pragma once

#include <torch/torch.h>

#include "models/network_config.h"

namespace ld {

/// A batch of frames or crops, float32 or float64.
struct NetworkInput {
  torch::Tensor features;  // [B, S, F, H, W] encoded (frame/schema.h), channels in the order of
                           // NetworkConfig::features
  torch::Tensor radiance;  // [B, S, 3, H, W] linear, >= 0; as admitted, all forms of it that are filtered:
                           // [B, S, 6, H, W] with demodulation (models/demodulation.h)
  torch::Tensor valid;     // [B, S, 1, H, W] 1 for a sample that was drawn, 0 for a missing or masked one,
                           // whose features and radiance count for nothing
  torch::Tensor demodulator = {};  // [B, S, 3, H, W] as admitted with demodulation, else undefined
};

/// What was wrong with the samples of an input, and what was done about it.
struct InputFaults {
  int64_t not_finite = 0;  // samples with a NaN or infinite feature or radiance, removed as if not drawn
  int64_t negative = 0;    // radiance channels below 0, set to 0
  int64_t clamped = 0;     // feature channels beyond +-65504, set to that: the first layer could overflow
};

/// Throws Error when a shape or type does not fit the configuration, or when there is no sample at all.
void check_input(const NetworkInput& input, const NetworkConfig& config);

/// The input with its faults removed; `faults` receives their numbers, those of the first `uncounted_rows`
/// rows left out. Differentiable. An input without faults is returned as it is and costs two reductions.
NetworkInput sanitise(NetworkInput input, InputFaults& faults, int64_t uncounted_rows = 0);

/// Input that is handed out in strips of rows, which may overlap and come more than once: a large frame need
/// never exist in the form of NetworkInput as a whole.
class InputSource {
 public:
  struct Sizes {
    int64_t batch, samples, height, width;
    int64_t element_bytes;  // 4 for float32, 8 for float64
  };
  virtual ~InputSource() = default;
  virtual Sizes sizes() const = 0;
  /// Rows [begin, end) of every tensor of the input.
  virtual NetworkInput rows(int64_t begin, int64_t end) const = 0;
  /// The same, for callers that need radiance and validity alone; features may be undefined.
  virtual NetworkInput radiance_rows(int64_t begin, int64_t end) const { return rows(begin, end); }
};

/// An input that exists as a whole.
class WholeInput : public InputSource {
 public:
  explicit WholeInput(NetworkInput input) : input_(std::move(input)) {}
  Sizes sizes() const override;
  NetworkInput rows(int64_t begin, int64_t end) const override;

 private:
  NetworkInput input_;
};

/// A source as networks admit it: each strip checked and sanitised, its samples averaged, its exposure
/// normalised and its radiance demodulated where the configuration says so. `faults` receives what was wrong,
/// each row counted once provided that rows are first asked for from top to bottom.
class AdmittedInput : public InputSource {
 public:
  /// Throws Error when there is no sample or pixel.
  AdmittedInput(const InputSource& source, const NetworkConfig& config, InputFaults& faults);
  /// With NetworkConfig::means, rows() have one sample whatever this says: it is what the source holds at a
  /// time.
  Sizes sizes() const override { return source_.sizes(); }
  NetworkInput rows(int64_t begin, int64_t end) const override;

 private:
  const InputSource& source_;
  const NetworkConfig& config_;
  InputFaults& faults_;
  mutable int64_t counted_rows_ = 0;
  torch::Tensor exposure_;  // [B]; undefined without normalisation
};

}  // namespace ld
