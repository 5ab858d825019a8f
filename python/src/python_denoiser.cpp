#include "python_denoiser.h"

#include <algorithm>
#include <memory>

#include "arrays.h"
#include "core/threads.h"
#include "embed/floating_point.h"
#include "embed/frame_buffers.h"

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

/// A picture on its way to Python, channels last.
struct Pixels {
  int width, height, channels;
  std::unique_ptr<float[]> memory =
      std::make_unique<float[]>(size_t(width) * size_t(height) * size_t(channels));

  LdStrides strides() const { return {0, 1, ptrdiff_t(channels) * width, channels}; }
  PictureArray array() {
    const nb::capsule owner(memory.get(), [](void* data) noexcept { delete[] static_cast<float*>(data); });
    float* const data = memory.release();
    const size_t shape[3] = {size_t(height), size_t(width), size_t(channels)};
    return PictureArray(data, 3, shape, owner);
  }
};

LdStrides strides_of(const SampleArray& array) {
  return {array.stride(0), array.stride(3), array.stride(1), array.stride(2)};
}

/// `pixels` receives where the picture, the parts and alpha go.
FrameBuffers buffers_of(const PythonSamples& samples, std::vector<Pixels>& pixels) {
  FrameBuffers buffers;
  const SampleArray& radiance = samples.features.at("radiance");
  const int width = int(radiance.shape(2)), height = int(radiance.shape(1));
  buffers.set_size(width, height, int(radiance.shape(0)));
  for (const auto& [name, array] : samples.features) {
    const LdStrides strides = strides_of(array);
    buffers.set_feature(name, array.data(), &strides);
  }
  pixels.push_back({width, height, 3});
  for (const SampleArray& part : samples.parts) {
    pixels.push_back({width, height, 3});
    const LdStrides from = strides_of(part), to = pixels.back().strides();
    buffers.add_part(part.data(), &from, pixels.back().memory.get(), &to);
  }
  if (samples.alpha.is_valid()) {
    const AlphaArray& alpha = samples.alpha;
    pixels.push_back({width, height, 1});
    const LdStrides from = {alpha.stride(0), 0, alpha.stride(1), alpha.stride(2)},
                    to = pixels.back().strides();
    buffers.set_alpha(alpha.data(), &from, pixels.back().memory.get(), &to);
  }
  if (samples.valid.is_valid()) buffers.set_valid(samples.valid.data());
  return buffers;
}

SampleArrays arrays_of(const FrameBuffers& buffers, const SequenceDenoiser& denoiser, float depth_scale) {
  SampleArrays arrays = buffers.arrays(denoiser.features(), denoiser.required());
  arrays.depth_scale = depth_scale;
  if (!arrays.any_valid())
    fail_usage(
        "nothing to see: every sample of every pixel is NaN or infinite in its radiance, or not valid; "
        "expected one sample at least");
  return arrays;
}

std::optional<Matrix4> matrix_of(const std::vector<float>& values) {
  Matrix4 matrix;
  if (values.size() != matrix.size()) return std::nullopt;
  std::copy(values.begin(), values.end(), matrix.begin());
  return matrix;
}

}  // namespace

PythonDenoiser::PythonDenoiser(const std::string& weights) : denoiser_(weights) {}

PythonDenoiser::PythonDenoiser(const std::string& kind, const std::vector<std::string>& settings)
    : denoiser_(FilterArgument{kind, kind, settings}) {}

void PythonDenoiser::restart() {
  const OneCall call(busy_);
  denoiser_.restart();
}

std::vector<double> PythonDenoiser::skipped() const {
  const Skipped skipped = denoiser_.skipped();
  return {skipped.pixels, skipped.samples, skipped.layers};
}

std::vector<std::pair<std::string, int>> PythonDenoiser::features() const {
  std::vector<std::pair<std::string, int>> features;
  for (const std::string& name : denoiser_.features())
    features.emplace_back(name, find_feature(name).channels);
  return features;
}

std::vector<PictureArray> PythonDenoiser::denoise(const PythonSamples& samples,
                                                  const PythonDenoiseOptions& how) {
  const OneCall call(busy_);
  std::vector<Pixels> pixels;
  const FrameBuffers buffers = buffers_of(samples, pixels);
  const FloatingPointSettings callers;
  Callbacks callbacks(how.progress, callers);
  DenoiseOptions options;
  options.threads = how.threads > 0 ? how.threads : default_threads();
  options.max_memory_bytes = how.max_memory_mb * kBudgetMegabyte;
  options.skip_within = how.skip_within;
  options.progress = [&](double share) { callbacks.advance(share); };
  options.cancel = [&] { return callbacks.cancel(); };
  {
    const nb::gil_scoped_release unlocked;
    const FloatingPointGuard settings;
    denoiser_.set_camera(matrix_of(how.world_to_camera), matrix_of(how.world_to_ndc));
    const DenoisedParts denoised = denoiser_.denoise(arrays_of(buffers, denoiser_, how.depth_scale), options);
    const LdStrides interleaved = pixels[0].strides();
    scatter(denoised.picture, pixels[0].memory.get(), &interleaved, options.threads);
    buffers.scatter_parts(denoised, options.threads);
  }
  std::vector<PictureArray> arrays;
  for (Pixels& picture : pixels) arrays.push_back(picture.array());
  return arrays;
}

}  // namespace ld
