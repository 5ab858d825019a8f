// A Denoiser as Python calls it: arrays in, an array out, without Python's lock while it computes.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <atomic>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "embed/sequence_denoiser.h"

namespace ld {

/// [samples, height, width, channels] with any strides.
using SampleArray = nanobind::ndarray<const float, nanobind::ndim<4>, nanobind::device::cpu>;
/// [samples, height, width], 0 for a sample that was not drawn.
using ValidArray =
    nanobind::ndarray<const uint8_t, nanobind::ndim<3>, nanobind::c_contig, nanobind::device::cpu>;
/// [samples, height, width] with any strides.
using AlphaArray = nanobind::ndarray<const float, nanobind::ndim<3>, nanobind::device::cpu>;
/// [height, width, 3], and of alpha [height, width, 1].
using PictureArray = nanobind::ndarray<nanobind::numpy, float, nanobind::ndim<3>>;
/// What a frame's samples are.
struct PythonSamples {
  std::map<std::string, SampleArray> features;
  std::vector<SampleArray> parts;  // of the light, 3 channels
  AlphaArray alpha;                // may be none
  ValidArray valid;                // may be none
};

struct PythonDenoiseOptions {
  float depth_scale = 0;  // 0: the median of the depths
  int threads = 0;
  int64_t max_memory_mb = 0;
  double skip_within = 0;
  std::vector<float> world_to_camera, world_to_ndc;  // 16 numbers, or none: not known
  nanobind::object progress;                         // None or a function of the share that is done
};

class PythonDenoiser {
 public:
  explicit PythonDenoiser(const std::string& weights);
  /// A filter and its settings, "key=value".
  PythonDenoiser(const std::string& kind, const std::vector<std::string>& settings);

  const std::string& name() const { return denoiser_.name(); }
  bool remembers() const { return denoiser_.remembers(); }
  /// Of the last frame: shares of pixels, samples and layers' pixels.
  std::vector<double> skipped() const;
  void restart();

  /// Name and channels of the features that are read, in their order.
  std::vector<std::pair<std::string, int>> features() const;
  const std::vector<std::string>& required() const { return denoiser_.required(); }

  /// The picture, and filtered with its weights the parts and alpha, where there is one, in this order. The
  /// arrays have one size, and their features the channels that the schema says: the Python side of the
  /// package has checked it. Throws Cancelled when the progress function says so, and what that raised. One
  /// call at a time: another thread's, or one out of the progress function, is an Error.
  std::vector<PictureArray> denoise(const PythonSamples& samples, const PythonDenoiseOptions& how);

 private:
  SequenceDenoiser denoiser_;
  std::atomic<bool> busy_{false};
};

}  // namespace ld
