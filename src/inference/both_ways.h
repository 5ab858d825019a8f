// Sequences that are denoised forwards and backwards in time, for films: what is behind a frame tells as much
// of it as what is before it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/process/unnamed_file.h"
#include "inference/denoiser.h"
#include "sequence/surface_guides.h"

namespace ld {

/// Makes each pixel of `forwards` and all that goes with it (a P_f + b P_b) / (a + b), with P_f and P_b what
/// either direction made, and the weights a = n_f - 1 and b = n_b - 1, n frames of independent noise
/// (Denoiser::frames_held, [1, H, W]). Both directions have the present frame. P_f and P_b are means of n_f
/// and n_b frames with the variances v / n_f and v / n_b and, by that frame, the covariance v / (n_f n_b); so
/// these are the weights of least variance. Where neither has another frame, `forwards` stays as it is, bit
/// for bit; the result lies between the two, and is the same whichever is called forwards.
void mix_directions(DenoisedParts& forwards, const Image& frames_forwards, const DenoisedParts& backwards,
                    const Image& frames_backwards);

/// The backward direction of one sequence, kept on the disk until the forward one comes by.
class BackwardPass {
 public:
  /// `folder`: on whose disk.
  BackwardPass(const Denoiser& denoiser, const std::filesystem::path& folder);

  /// Frames of the sequence from the last to the first, each once: `place` counts forwards. Their flow is
  /// turned around (sequence/flow_to_next.h) where the network reads it and the frame behind knows it. A
  /// frame knows nothing of those behind a cut. Throws as Denoiser::denoise_parts does.
  void add(size_t key, Frame& frame, const SequencePlace& place, bool alpha, const DenoiseOptions& options);
  /// In place of a frame that could not be had: the one before it knows nothing of those behind.
  void fail_frame(size_t key, const std::string& why);

  /// After the first frame: what one frame leaves for the next is of no use any more.
  void end();

  /// What add() made of the frame is mixed into `forwards`, made of the same frame, as mix_directions() says.
  /// Returns how many frames right behind it were known. Throws Error with the reason of fail_frame().
  int64_t mix_into(size_t key, DenoisedParts& forwards, const Image& frames_forwards) const;

 private:
  struct Kept {
    int64_t place = 0, future = 0;
    std::string failure;
  };
  Kept& kept(size_t key);

  const Denoiser& denoiser_;
  bool reads_flow_;
  SequenceState state_;
  bool cut_behind_ = false;
  std::optional<SurfaceGuides> next_;  // of the frame that was added last
  UnnamedFile file_;
  int64_t bytes_ = 0;
  std::vector<Kept> kept_;
};

}  // namespace ld
