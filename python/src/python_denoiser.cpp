#include "python_denoiser.h"

#include <algorithm>
#include <memory>

#include "arrays.h"
#include "core/threads.h"
#include "embed/floating_point.h"
#include "embed/frame_buffers.h"
#include "models/network_config.h"

namespace nb = nanobind;

namespace ld {
namespace {

/// Marks a denoiser as busy while it lives.
class OneCall {
 public:
  explicit OneCall(std::atomic<bool>& busy) : busy_(busy) {
    if (busy_.exchange(true))
      fail(
          "this denoiser is at work already, in another thread or below its own progress function; make a "
          "Denoiser for each thread");
  }
  ~OneCall() { busy_ = false; }
  OneCall(const OneCall&) = delete;
  OneCall& operator=(const OneCall&) = delete;

 private:
  std::atomic<bool>& busy_;
};

/// What denoise() asks now and then, without Python's lock: whether Python has a signal to handle, such as
/// Ctrl-C, and what the progress function says.
class Callbacks {
 public:
  Callbacks(nb::handle progress, const FloatingPointSettings& callers)
      : progress_(progress), callers_(callers) {}

  bool cancel() const {
    const nb::gil_scoped_acquire lock;
    const FloatingPointGuard settings(callers_);  // handlers are the caller's code
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
    return stop_;
  }

  void advance(double share) {
    if (progress_.is_none()) return;
    const nb::gil_scoped_acquire lock;
    const FloatingPointGuard settings(callers_);
    const nb::object answer = progress_(share);
    if (answer.is_none()) return;  // of a function that returns nothing
    const int go_on = PyObject_IsTrue(answer.ptr());
    if (go_on < 0) throw nb::python_error();
    stop_ = go_on == 0;
  }

 private:
  nb::handle progress_;
  const FloatingPointSettings& callers_;
  bool stop_ = false;
};

FrameBuffers buffers_of(const std::map<std::string, SampleArray>& samples, const ValidArray& valid) {
  FrameBuffers buffers;
  const SampleArray& radiance = samples.at("radiance");
  buffers.set_size(int(radiance.shape(2)), int(radiance.shape(1)), int(radiance.shape(0)));
  for (const auto& [name, array] : samples) {
    const LdStrides strides = {array.stride(0), array.stride(3), array.stride(1), array.stride(2)};
    buffers.set_feature(name, array.data(), &strides);
  }
  if (valid.is_valid()) buffers.set_valid(valid.data());
  return buffers;
}

Frame frame_of(const FrameBuffers& buffers, const Denoiser& denoiser, float depth_scale, int threads) {
  Frame frame = buffers.gather(denoiser.network_config().features, denoiser.features(), threads);
  if (depth_scale > 0) frame.info.depth_scale = depth_scale;
  if (std::all_of(frame.valid.begin(), frame.valid.end(), [](uint8_t drawn) { return drawn == 0; }))
    fail_usage(
        "nothing to see: every sample of every pixel is NaN or infinite in its radiance, or not valid; "
        "expected one sample at least");
  return frame;
}

}  // namespace

PythonDenoiser::PythonDenoiser(const std::string& weights) : denoiser_(weights) {}

std::vector<std::pair<std::string, int>> PythonDenoiser::features() const {
  std::vector<std::pair<std::string, int>> features;
  for (const std::string& name : network_config().features)
    features.emplace_back(name, find_feature(name).channels);
  return features;
}

PictureArray PythonDenoiser::denoise(const std::map<std::string, SampleArray>& samples,
                                     const ValidArray& valid, const PythonDenoiseOptions& how) {
  const OneCall call(busy_);
  const FrameBuffers buffers = buffers_of(samples, valid);
  const FloatingPointSettings callers;
  Callbacks callbacks(how.progress, callers);
  DenoiseOptions options;
  options.threads = how.threads > 0 ? how.threads : default_threads();
  options.max_memory_bytes = how.max_memory_mb * kBudgetMegabyte;
  options.progress = [&](double share) { callbacks.advance(share); };
  options.cancel = [&] { return callbacks.cancel(); };
  std::unique_ptr<float[]> pixels;
  {
    const nb::gil_scoped_release unlocked;
    const FloatingPointGuard settings;
    const Image picture =
        denoiser_.denoise(frame_of(buffers, denoiser_, how.depth_scale, options.threads), options);
    pixels = std::make_unique<float[]>(picture.pixels.size());
    const LdStrides interleaved = {0, 1, ptrdiff_t(3) * picture.width, 3};
    scatter(picture, pixels.get(), &interleaved, options.threads);
  }
  const nb::capsule owner(pixels.get(), [](void* data) noexcept { delete[] static_cast<float*>(data); });
  float* const data = pixels.release();
  const size_t shape[3] = {size_t(buffers.height()), size_t(buffers.width()), 3};
  return PictureArray(data, 3, shape, owner);
}

}  // namespace ld
