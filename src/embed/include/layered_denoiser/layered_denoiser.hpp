// The C++ interface: layered_denoiser.h with exceptions and ownership. Header only, so that no ABI of a
// compiler or of LibTorch comes between library and user.
#pragma once

#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "layered_denoiser/layered_denoiser.h"

namespace layered_denoiser {

/// A call that failed; what() is one line: what, where, expected, found.
class Failure : public std::runtime_error {
 public:
  Failure(LdStatus status, const char* message) : std::runtime_error(message), status_(status) {}
  LdStatus status() const { return status_; }

 private:
  LdStatus status_;
};

inline void check(LdStatus status) {
  if (status != LD_OK) throw Failure(status, ld_error());
}

struct Feature {
  std::string name;
  int channels;
};

class Denoiser {
 public:
  /// A weight file, a checkpoint folder or a run folder. Throws Failure.
  explicit Denoiser(const std::string& weights) {
    LdDenoiser* denoiser = nullptr;
    check(ld_create(weights.c_str(), &denoiser));
    denoiser_.reset(denoiser);
  }

  /// "eaw" or "svgf" with settings "key=value" (ld_create_filter). Throws Failure.
  static Denoiser filter(const std::string& kind, const std::vector<std::string>& settings = {}) {
    std::vector<const char*> texts;
    for (const std::string& setting : settings) texts.push_back(setting.c_str());
    texts.push_back(nullptr);
    LdDenoiser* denoiser = nullptr;
    check(ld_create_filter(kind.c_str(), texts.data(), &denoiser));
    return Denoiser(denoiser);
  }

  /// What these weights read; all must be set before denoise() but for those that they do without.
  std::vector<Feature> features() const {
    std::vector<Feature> features;
    for (int i = 0; i < ld_feature_count(denoiser_.get()); ++i)
      features.push_back({ld_feature_name(denoiser_.get(), i), ld_feature_channels(denoiser_.get(), i)});
    return features;
  }

  /// Pixels and samples a pixel of the following frames. Forgets all buffers.
  void set_size(int width, int height, int spp) { check(ld_set_size(denoiser_.get(), width, height, spp)); }

  /// [spp][channels][height][width] unless `strides` says otherwise; read by denoise().
  void set_feature(const std::string& name, const float* data, const LdStrides* strides = nullptr) {
    check(ld_set_feature(denoiser_.get(), name.c_str(), data, strides));
  }
  /// A part of the light, [spp][3][height][width], whose filtered picture denoise() writes to `picture`,
  /// [3][height][width], both unless strides say otherwise; ld_add_part() says the rest.
  void add_part(const float* samples, float* picture, const LdStrides* strides = nullptr,
                const LdStrides* picture_strides = nullptr) {
    check(ld_add_part(denoiser_.get(), samples, strides, picture, picture_strides));
  }
  /// Alpha, [spp][1][height][width], likewise: to [1][height][width].
  void set_alpha(const float* samples, float* picture, const LdStrides* strides = nullptr,
                 const LdStrides* picture_strides = nullptr) {
    check(ld_set_alpha(denoiser_.get(), samples, strides, picture, picture_strides));
  }
  void set_valid(const uint8_t* valid) { check(ld_set_valid(denoiser_.get(), valid)); }
  /// Of the following frames (ld_set_camera); null pointers: not known.
  void set_camera(const float* world_to_camera, const float* world_to_ndc) {
    check(ld_set_camera(denoiser_.get(), world_to_camera, world_to_ndc));
  }
  /// Whether frames have something of those before (ld_create).
  bool remembers() const { return ld_remembers(denoiser_.get()) != 0; }
  /// The next frame follows none of those before.
  void restart() { check(ld_restart(denoiser_.get())); }
  void set_max_memory(size_t megabytes) { check(ld_set_max_memory(denoiser_.get(), megabytes)); }
  /// The picture x may be another by within (1 + |x|), so that less is to compute (ld_set_skip_within).
  void set_skip_within(double within) { check(ld_set_skip_within(denoiser_.get(), within)); }
  /// What was left out of the last frame.
  LdSkipped skipped() const { return ld_skipped(denoiser_.get()); }

  /// Called with the share done; returning false cancels: denoise() then throws a Failure of LD_CANCELLED.
  /// It must not throw.
  void set_progress(std::function<bool(double)> progress) {
    progress_ = std::make_unique<std::function<bool(double)>>(std::move(progress));
    check(ld_set_progress(
        denoiser_.get(),
        [](double share, void* user) {
          return (*static_cast<std::function<bool(double)>*>(user))(share) ? 1 : 0;
        },
        progress_.get()));
  }

  /// Linear R, G, B into `picture`, [3][height][width] unless `strides` says otherwise.
  void denoise(float* picture, const LdStrides* strides = nullptr) {
    check(ld_denoise(denoiser_.get(), picture, strides));
  }

 private:
  explicit Denoiser(LdDenoiser* denoiser) : denoiser_(denoiser) {}

  struct Destroy {
    void operator()(LdDenoiser* denoiser) const { ld_destroy(denoiser); }
  };
  std::unique_ptr<std::function<bool(double)>> progress_;
  std::unique_ptr<LdDenoiser, Destroy> denoiser_;
};

}  // namespace layered_denoiser
