// What ld_denoise does, apart from its command line.
#pragma once

#include <nlohmann/json.hpp>

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "filters/frame_filter.h"
#include "inference/input_frame.h"
#include "inference/sequence_names.h"

namespace ld {

struct DenoiseJob {
  std::filesystem::path model;           // or:
  std::optional<FilterArgument> filter;  // a denoiser without weights
  std::vector<DenoiseTask> tasks;
  RenderInput render;
  int threads = 0;                           // 0: default_threads()
  int64_t max_memory_bytes = 0;              // 0: no limit
  std::optional<double> skip_within = 1e-4;  // DenoiseOptions::skip_within
  int samples = 0;                           // the first so many of each frame; 0: all
  bool skip_existing = false;                // pictures that are there are left alone
  bool full_float = false;
  bool blend = false;         // towards the samples' mean, as far as it is the better one (inference/blend.h)
  bool both_ways = false;     // sequences forwards and backwards in time (inference/both_ways.h)
  bool filter_alpha = false;  // like a light part; else it is the mean of the samples'
  std::filesystem::path
      noisy;  // of a single picture: where the mean of its samples goes, too; empty: nowhere
  // EXR parts for looking, of layer networks: filtered layers, what they add to the picture, unfiltered ones,
  // kernels of pixels.
  bool layers = false, contributions = false, unfiltered = false;
  std::vector<std::pair<int, int>> kernels_at;

  bool wants_parts() const { return layers || contributions || unfiltered || !kernels_at.empty(); }
};

struct DenoiseReport {
  nlohmann::ordered_json frames = nlohmann::ordered_json::array();  // an object for each that was tried
  int64_t skipped = 0;
  std::vector<std::string> failed;  // inputs of frames that could not be done, in sequences only
  bool stopped = false;             // by a signal, before the last frame

  /// Pictures that are there.
  size_t finished() const { return frames.size() - failed.size() + static_cast<size_t>(skipped); }
};

/// Frame after frame, with progress, and with one state that starts anew where a frame does not follow the
/// one before: at the first of a sequence, and after one that is missing, failed or was left alone. How many
/// frames before it a frame follows stands in the report as `history`, with both_ways how many frames behind
/// it were known as `future`: then each sequence is gone through backwards first, and what that gives lies on
/// the disk of its first picture, in a file without a name, until the pictures are written. Ends early, with
/// whole files only, when a stop is requested (core/signals.h). In a sequence a frame that fails does not
/// keep the others from being done. Throws Error as Denoiser, read_input() and write_picture() say;
/// UsageError, before anything is denoised, for parts that the network or the format of the output cannot
/// have, for a filter's settings, and for both_ways of stills and of what does not remember.
DenoiseReport run_denoise_job(const DenoiseJob& job);

}  // namespace ld
