#include "layered_denoiser/layered_denoiser.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <functional>
#include <memory>
#include <new>
#include <optional>
#include <string>

#include "core/error.h"
#include "core/threads.h"
#include "embed/floating_point.h"
#include "embed/frame_buffers.h"
#include "filters/frame_filter.h"
#include "inference/denoiser.h"
#include "models/network_config.h"

struct LdDenoiser {
  std::optional<ld::Denoiser> model;  // or:
  std::optional<ld::FrameFilter> filter;
  std::vector<std::string> features, required;

  ld::FrameBuffers buffers;
  std::optional<ld::Matrix4> world_to_camera, world_to_ndc;
  ld::SequenceState state;
  int64_t position = 0;  // of the next frame in its sequence
  ld::DenoiseOptions options;
  bool cancelled = false;             // by the progress function of the call that runs
  ld::FloatingPointSettings callers;  // of the call that runs
};

namespace {

thread_local std::string last_error;
std::atomic<int> chosen_threads{0};  // 0: default_threads(); any thread may set it while others denoise

LdStatus refuse(LdStatus status, const std::string& why) {
  last_error = why;
  return status;
}

/// No exception leaves the library: C cannot catch it. Nor do floating-point settings.
LdStatus guarded(const std::function<void()>& body) {
  const ld::FloatingPointGuard settings;
  try {
    body();
    return LD_OK;
  } catch (const ld::Cancelled& cancelled) {
    return refuse(LD_CANCELLED, cancelled.what());
  } catch (const ld::UsageError& error) {
    return refuse(LD_INVALID_ARGUMENT, error.what());
  } catch (const std::bad_alloc&) {
    return refuse(LD_FAILED, "out of memory; set a bound with ld_set_max_memory");
  } catch (const std::exception& error) {
    return refuse(LD_FAILED, error.what());
  }
}

int threads() {
  const int chosen = chosen_threads;
  return chosen > 0 ? chosen : ld::default_threads();
}

const std::string* feature(const LdDenoiser* denoiser, int index) {
  if (denoiser == nullptr || index < 0) return nullptr;
  return size_t(index) < denoiser->features.size() ? &denoiser->features[size_t(index)] : nullptr;
}

std::optional<ld::Matrix4> matrix_of(const float* values) {
  if (values == nullptr) return std::nullopt;
  ld::Matrix4 matrix;
  std::copy_n(values, matrix.size(), matrix.begin());
  return matrix;
}

/// The picture and its parts; a filter takes it for the next one of its sequence.
ld::DenoisedParts denoised(LdDenoiser& denoiser, const ld::SampleArrays& arrays) {
  if (denoiser.model) return denoiser.model->denoise_parts(arrays, denoiser.options);
  if (!arrays.parts.empty() || arrays.alpha)
    ld::fail_usage("parts of the light and alpha go with models; ld_create_filter makes none");
  ld::Frame frame = ld::gather(arrays, denoiser.options.threads);
  frame.info.world_to_camera = denoiser.world_to_camera;
  frame.info.world_to_ndc = denoiser.world_to_ndc;
  denoiser.state.advance(ld::SequencePlace{0, denoiser.position}, frame.width, frame.height);
  ++denoiser.position;
  return {denoiser.filter->denoise(frame, denoiser.state, denoiser.options.threads), {}, {}};
}

constexpr const char* kNoDenoiser = "the denoiser is a null pointer; ld_create and ld_create_filter make one";

}  // namespace

extern "C" {

const char* ld_version(void) {
  return LD_VERSION;
}

const char* ld_error(void) {
  return last_error.c_str();
}

LdStatus ld_set_threads(int count) {
  if (count < 0 || count > 4096)
    return refuse(LD_INVALID_ARGUMENT, std::to_string(count) + " threads; expected 0 (all) to 4096");
  chosen_threads = count;
  return LD_OK;
}

LdStatus ld_create(const char* weights, LdDenoiser** denoiser) {
  if (denoiser == nullptr)
    return refuse(LD_INVALID_ARGUMENT, "ld_create: there is nowhere to put the denoiser");
  *denoiser = nullptr;
  if (weights == nullptr)
    return refuse(LD_INVALID_ARGUMENT, "ld_create: the path of the weights is a null pointer");
  return guarded([&] {
    auto made = std::make_unique<LdDenoiser>();
    made->model.emplace(weights);
    made->features = made->model->network_config().features;
    made->required = made->model->features();
    *denoiser = made.release();
  });
}

LdStatus ld_create_filter(const char* kind, const char* const* settings, LdDenoiser** denoiser) {
  if (denoiser == nullptr)
    return refuse(LD_INVALID_ARGUMENT, "ld_create_filter: there is nowhere to put the denoiser");
  *denoiser = nullptr;
  if (kind == nullptr) return refuse(LD_INVALID_ARGUMENT, "ld_create_filter: the kind is a null pointer");
  return guarded([&] {
    std::vector<std::string> none;
    ld::FilterArgument argument = ld::parse_filter_arguments({kind}, none).front();
    for (; settings != nullptr && *settings != nullptr; ++settings)
      argument.assignments.emplace_back(*settings);
    auto made = std::make_unique<LdDenoiser>();
    made->filter.emplace(argument);
    made->features = ld::filter_features();
    made->features.insert(made->features.begin(), "radiance");
    made->required = {"radiance"};
    *denoiser = made.release();
  });
}

LdStatus ld_set_camera(LdDenoiser* denoiser, const float* world_to_camera, const float* world_to_ndc) {
  if (denoiser == nullptr) return refuse(LD_INVALID_ARGUMENT, kNoDenoiser);
  denoiser->world_to_camera = matrix_of(world_to_camera);
  denoiser->world_to_ndc = matrix_of(world_to_ndc);
  return LD_OK;
}

LdStatus ld_restart(LdDenoiser* denoiser) {
  if (denoiser == nullptr) return refuse(LD_INVALID_ARGUMENT, kNoDenoiser);
  denoiser->state.end();
  return LD_OK;
}

void ld_destroy(LdDenoiser* denoiser) {
  delete denoiser;
}

int ld_feature_count(const LdDenoiser* denoiser) {
  return denoiser == nullptr ? 0 : int(denoiser->features.size());
}

const char* ld_feature_name(const LdDenoiser* denoiser, int index) {
  const std::string* name = feature(denoiser, index);
  return name == nullptr ? nullptr : name->c_str();
}

int ld_feature_channels(const LdDenoiser* denoiser, int index) {
  const std::string* name = feature(denoiser, index);
  return name == nullptr ? 0 : ld::find_feature(*name).channels;
}

LdStatus ld_set_size(LdDenoiser* denoiser, int width, int height, int spp) {
  if (denoiser == nullptr) return refuse(LD_INVALID_ARGUMENT, kNoDenoiser);
  return guarded([&] { denoiser->buffers.set_size(width, height, spp); });
}

LdStatus ld_set_feature(LdDenoiser* denoiser, const char* name, const float* data, const LdStrides* strides) {
  if (denoiser == nullptr) return refuse(LD_INVALID_ARGUMENT, kNoDenoiser);
  if (name == nullptr) return refuse(LD_INVALID_ARGUMENT, "the name of the feature is a null pointer");
  return guarded([&] { denoiser->buffers.set_feature(name, data, strides); });
}

LdStatus ld_add_part(LdDenoiser* denoiser, const float* samples, const LdStrides* strides, float* picture,
                     const LdStrides* picture_strides) {
  if (denoiser == nullptr) return refuse(LD_INVALID_ARGUMENT, kNoDenoiser);
  return guarded([&] { denoiser->buffers.add_part(samples, strides, picture, picture_strides); });
}

LdStatus ld_set_alpha(LdDenoiser* denoiser, const float* samples, const LdStrides* strides, float* picture,
                      const LdStrides* picture_strides) {
  if (denoiser == nullptr) return refuse(LD_INVALID_ARGUMENT, kNoDenoiser);
  return guarded([&] { denoiser->buffers.set_alpha(samples, strides, picture, picture_strides); });
}

LdStatus ld_set_valid(LdDenoiser* denoiser, const uint8_t* valid) {
  if (denoiser == nullptr) return refuse(LD_INVALID_ARGUMENT, kNoDenoiser);
  denoiser->buffers.set_valid(valid);
  return LD_OK;
}

LdStatus ld_set_max_memory(LdDenoiser* denoiser, size_t megabytes) {
  if (denoiser == nullptr) return refuse(LD_INVALID_ARGUMENT, kNoDenoiser);
  denoiser->options.max_memory_bytes = int64_t(std::min(megabytes, size_t(1) << 30)) * ld::kBudgetMegabyte;
  return LD_OK;
}

LdStatus ld_set_progress(LdDenoiser* denoiser, LdProgress progress, void* user) {
  if (denoiser == nullptr) return refuse(LD_INVALID_ARGUMENT, kNoDenoiser);
  denoiser->options.progress = nullptr;
  denoiser->options.cancel = nullptr;
  if (progress != nullptr) {
    denoiser->options.progress = [denoiser, progress, user](double share) {
      const ld::FloatingPointGuard callers(denoiser->callers);  // it is the caller's code
      denoiser->cancelled = progress(share, user) == 0;
    };
    denoiser->options.cancel = [denoiser] { return denoiser->cancelled; };
  }
  return LD_OK;
}

LdStatus ld_denoise(LdDenoiser* denoiser, float* picture, const LdStrides* strides) {
  if (denoiser == nullptr) return refuse(LD_INVALID_ARGUMENT, kNoDenoiser);
  if (picture == nullptr) return refuse(LD_INVALID_ARGUMENT, "the picture to write is a null pointer");
  denoiser->callers = ld::FloatingPointSettings();
  return guarded([&] {
    denoiser->options.threads = threads();
    denoiser->cancelled = false;
    const ld::DenoisedParts result =
        denoised(*denoiser, denoiser->buffers.arrays(denoiser->features, denoiser->required));
    ld::scatter(result.picture, picture, strides, threads());
    denoiser->buffers.scatter_parts(result, threads());
  });
}

}  // extern "C"
