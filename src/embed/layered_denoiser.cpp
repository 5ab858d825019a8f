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
#include "embed/sequence_denoiser.h"

struct LdDenoiser {
  /// Of weights or a filter.
  template <class Source>
  explicit LdDenoiser(const Source& source) : engine(source) {}

  ld::SequenceDenoiser engine;
  ld::FrameBuffers buffers;
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
  const std::vector<std::string>& features = denoiser->engine.features();
  return size_t(index) < features.size() ? &features[size_t(index)] : nullptr;
}

std::optional<ld::Matrix4> matrix_of(const float* values) {
  if (values == nullptr) return std::nullopt;
  ld::Matrix4 matrix;
  std::copy_n(values, matrix.size(), matrix.begin());
  return matrix;
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
  return guarded([&] { *denoiser = std::make_unique<LdDenoiser>(std::string(weights)).release(); });
}

LdStatus ld_create_filter(const char* kind, const char* const* settings, LdDenoiser** denoiser) {
  if (denoiser == nullptr)
    return refuse(LD_INVALID_ARGUMENT, "ld_create_filter: there is nowhere to put the denoiser");
  *denoiser = nullptr;
  if (kind == nullptr) return refuse(LD_INVALID_ARGUMENT, "ld_create_filter: the kind is a null pointer");
  return guarded([&] {
    ld::FilterArgument argument{kind, kind, {}};
    for (; settings != nullptr && *settings != nullptr; ++settings)
      argument.assignments.emplace_back(*settings);
    *denoiser = std::make_unique<LdDenoiser>(argument).release();
  });
}

LdStatus ld_set_camera(LdDenoiser* denoiser, const float* world_to_camera, const float* world_to_ndc) {
  if (denoiser == nullptr) return refuse(LD_INVALID_ARGUMENT, kNoDenoiser);
  denoiser->engine.set_camera(matrix_of(world_to_camera), matrix_of(world_to_ndc));
  return LD_OK;
}

LdStatus ld_restart(LdDenoiser* denoiser) {
  if (denoiser == nullptr) return refuse(LD_INVALID_ARGUMENT, kNoDenoiser);
  denoiser->engine.restart();
  return LD_OK;
}

int ld_remembers(const LdDenoiser* denoiser) {
  return denoiser != nullptr && denoiser->engine.remembers() ? 1 : 0;
}

void ld_destroy(LdDenoiser* denoiser) {
  delete denoiser;
}

int ld_feature_count(const LdDenoiser* denoiser) {
  return denoiser == nullptr ? 0 : int(denoiser->engine.features().size());
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

LdStatus ld_set_skip_within(LdDenoiser* denoiser, double within) {
  if (denoiser == nullptr) return refuse(LD_INVALID_ARGUMENT, kNoDenoiser);
  return guarded([&] {
    ld::check_skip_within(within);
    denoiser->options.skip_within = within;
  });
}

LdSkipped ld_skipped(const LdDenoiser* denoiser) {
  const ld::Skipped skipped = denoiser == nullptr ? ld::Skipped() : denoiser->engine.skipped();
  return {skipped.pixels, skipped.samples, skipped.layers};
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
    ld::SequenceDenoiser& engine = denoiser->engine;
    const ld::DenoisedParts result =
        engine.denoise(denoiser->buffers.arrays(engine.features(), engine.required()), denoiser->options);
    ld::scatter(result.picture, picture, strides, threads());
    denoiser->buffers.scatter_parts(result, threads());
  });
}

}  // extern "C"
