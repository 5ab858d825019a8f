// The separate inference program's engine: weights in, frames in, images out. Free of LibTorch.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/error.h"
#include "frame/sample_arrays.h"
#include "runtime/skipped.h"
#include "sequence/sequence_state.h"

namespace ld {

struct NetworkConfig;

/// What budgets and the messages about them call an MB.
inline constexpr int64_t kBudgetMegabyte = int64_t(1) << 20;

/// How a frame is denoised; nothing here but skip_within above 0 changes a bit of the result.
struct DenoiseOptions {
  int threads = 0;  // 0: default_threads()
  /// What the process may take while it denoises, the frame itself aside: program, libraries, weights and
  /// everything that is computed. 0: no limit.
  int64_t max_memory_bytes = 0;
  /// What else the process has that the limit does not count; below 0: what it will take beside and after it,
  /// and the limit counts.
  int64_t memory_aside_bytes = 0;
  /// Work whose result is known beforehand is left out. So the picture x is another by at most skip_within (1
  /// + |x|): absolute for dark and relative for bright light. 0: by no bit. Nothing: no work is left out.
  /// Networks that remember, blend resolutions or predict light have nothing to leave out but what is the
  /// same bit for bit. What was left out: Denoiser::skipped().
  std::optional<double> skip_within = 0;
  /// Called from the calling thread with the share that is done, 0 to 1, a few dozen times a frame.
  std::function<void(double)> progress;
  /// Asked as often; true ends denoise() with Cancelled.
  std::function<bool()> cancel;
};

/// Throws UsageError unless the bound of DenoiseOptions::skip_within is a number from 0 to 1.
void check_skip_within(double within);

/// What denoise() throws when DenoiseOptions::cancel said so.
class Cancelled : public Error {
 public:
  Cancelled() : Error("cancelled") {}
};

/// A layer of a layered network, for looking ([MH20] figure 3 and 8). Radiance is premultiplied: L_l / n_l is
/// what the layer adds to a picture in which nothing lies in front of it, its colour times its opacity. With
/// the weighted compositor n_l is w_l, the opacity 1 and the radiance the colour. With demodulation, the
/// layers are those of the radiance as it is; what they add to the output has the texture
/// (models/demodulation.h).
struct LayerPicture {
  Image unfiltered;    // L_l / n_l [3, H, W]
  Image radiance;      // filtered L_l over filtered n_l, eq. 4 [3, H, W]: premultiplied with alpha
  Image alpha;         // filtered w_l over filtered n_l, eq. 4 [1, H, W]
  Image weight;        // the share of the layer's colour in the output [1, H, W]; the sum over layers is 1
  Image contribution;  // what the layer adds to the output [3, H, W]; the sum over layers is the output
};

/// A picture and what was filtered with its weights.
struct DenoisedParts {
  Image picture;             // [3, H, W]: what denoise() gives, bit for bit, or to skip_within
  std::vector<Image> parts;  // of Frame::parts, [3, H, W] each
  Image alpha;               // [1, H, W] within [0, 1]; empty unless asked for
};

class Denoiser {
 public:
  /// `model` is a weight file (.safetensors), a checkpoint folder or a run folder (its `best` checkpoint).
  /// Throws Error when the file is damaged, its network unknown to this program, or its feature set another
  /// than this program's.
  explicit Denoiser(const std::filesystem::path& model);
  ~Denoiser();

  /// The features that frames must hold for this model (for read_frame). It reads more where its network has
  /// optional ones (network_config().features).
  const std::vector<std::string>& features() const { return required_; }
  const NetworkConfig& network_config() const;
  /// Whether frames of a sequence have something of those before.
  bool remembers() const;

  /// The denoised image [3, H, W], linear; any size from 1x1, any number of samples from 1. The frame has
  /// been sanitised (read_frame and import_frame do) and has a depth scale. Its samples are encoded row by
  /// row as the network reads them: no second copy of them is made. What was planned for a frame is kept for
  /// the next of its size. Light parts are left alone. Throws Error for a frame without samples and for a
  /// budget that is too small, naming the smallest that will do; Cancelled. Not for several threads at once.
  ///
  /// A network that remembers takes what the frame before has left from `sequence`, whose advance() has been
  /// told of this frame, and leaves there what the next one needs. Without, the frame is the first of its
  /// own.
  Image denoise(const Frame& frame, const DenoiseOptions& options = {},
                SequenceState* sequence = nullptr) const;

  /// The same, and with the same kernels all of the frame's light parts and, with `alpha`, its alpha. Every
  /// network is linear in the radiance that it filters once the radiance has decided on the weights, so parts
  /// that sum to the radiance of every sample come out as parts that sum to the picture, to rounding. Throws
  /// Error as denoise(), and for `alpha` of a frame that has none.
  DenoisedParts denoise_parts(const Frame& frame, bool alpha, const DenoiseOptions& options = {},
                              SequenceState* sequence = nullptr) const;

  /// The same of samples where they lie, with all of their parts and, where they have it, alpha: no copy of
  /// them is made, and nothing but features() must be there. They count as memory of the process.
  DenoisedParts denoise_parts(const SampleArrays& arrays, const DenoiseOptions& options = {},
                              SequenceState* sequence = nullptr) const;

  /// How many frames of independent noise each pixel of the picture counts for that was denoised last with
  /// this state, [1, H, W], at most 32, 0 or 1 where it has nothing of other frames: what a `layer_history`
  /// counts itself (models/history.h). The state of a `recurrent` has no such number: there, and of networks
  /// that do not remember, the frames since the start, which weighs the directions of a film but promises no
  /// noise.
  Image frames_held(const SequenceState& sequence, int width, int height) const;
  /// What the last denoise() or denoise_parts() has left out.
  Skipped skipped() const;

  /// The smallest max_memory_bytes that denoise() takes for frames of this size, in this process, now.
  int64_t least_memory_bytes(int width, int height, int spp) const;

  /// Front to back. Throws UsageError unless the network is "layer".
  std::vector<LayerPicture> layers(const Frame& frame, const DenoiseOptions& options = {}) const;

  /// The kernels that pixel (x, y) scatters its light with, one [1, K, K] for each layer, as shares of all
  /// that it sends: they add up to 1 over layers and taps. Throws UsageError unless the network is "layer",
  /// and for a pixel outside.
  std::vector<Image> kernels_at(const Frame& frame, int x, int y) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
  std::vector<std::string> required_;
};

}  // namespace ld
