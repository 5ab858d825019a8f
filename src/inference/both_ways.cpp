#include "inference/both_ways.h"

#include <algorithm>

#include "models/network_config.h"
#include "sequence/flow_to_next.h"

namespace ld {
namespace {

std::vector<Image*> images_of(DenoisedParts& parts) {
  std::vector<Image*> images = {&parts.picture};
  for (Image& part : parts.parts) images.push_back(&part);
  images.push_back(&parts.alpha);
  return images;
}

void mix_image(Image& forwards, const Image& frames_forwards, const Image& backwards,
               const Image& frames_backwards) {
  for (size_t p = 0; p < forwards.plane_size(); ++p) {
    const double a = std::max(double(frames_forwards.pixels[p]) - 1, 0.0),
                 b = std::max(double(frames_backwards.pixels[p]) - 1, 0.0);
    if (a + b == 0) continue;
    for (int c = 0; c < forwards.channels; ++c) {
      float& value = forwards.plane(c)[p];
      value = float((a * double(value) + b * double(backwards.plane(c)[p])) / (a + b));
    }
  }
}

}  // namespace

void mix_directions(DenoisedParts& forwards, const Image& frames_forwards, const DenoisedParts& backwards,
                    const Image& frames_backwards) {
  mix_image(forwards.picture, frames_forwards, backwards.picture, frames_backwards);
  mix_image(forwards.alpha, frames_forwards, backwards.alpha, frames_backwards);
  for (size_t i = 0; i < forwards.parts.size(); ++i)
    mix_image(forwards.parts[i], frames_forwards, backwards.parts[i], frames_backwards);
}

BackwardPass::BackwardPass(const Denoiser& denoiser, const std::filesystem::path& folder)
    : denoiser_(denoiser),
      reads_flow_(first_channel(denoiser.network_config().features, "flow") >= 0),
      file_(folder) {}

BackwardPass::Kept& BackwardPass::kept(size_t key) {
  kept_.resize(std::max(kept_.size(), key + 1));
  return kept_[key];
}

void BackwardPass::add(size_t key, Frame& frame, const SequencePlace& place, bool alpha,
                       const DenoiseOptions& options) {
  state_.advance(SequencePlace{place.sequence, -place.position}, frame.width, frame.height, cut_behind_);
  cut_behind_ = frame.info.cut;
  if (reads_flow_ && frame.holds("flow")) {
    SurfaceGuides now = surface_guides(frame);
    if (state_.history() > 0 && next_) set_flow(frame, flow_to_next(now, *next_));
    next_ = std::move(now);
  } else {
    next_.reset();
  }
  DenoisedParts made = denoiser_.denoise_parts(frame, alpha, options, &state_);
  Image frames = denoiser_.frames_held(state_, frame.width, frame.height);
  Kept& entry = kept(key);
  entry.place = bytes_;
  entry.future = state_.history();
  std::vector<Image*> images = images_of(made);
  images.push_back(&frames);
  for (const Image* image : images) {
    const size_t bytes = image->pixels.size() * sizeof(float);
    file_.write(bytes_, image->pixels.data(), bytes);
    bytes_ += int64_t(bytes);
  }
}

void BackwardPass::fail_frame(size_t key, const std::string& why) {
  state_.end();
  kept(key).failure = why;
}

void BackwardPass::end() {
  state_.end();
  next_.reset();
}

int64_t BackwardPass::mix_into(size_t key, DenoisedParts& forwards, const Image& frames_forwards) const {
  const Kept& entry = kept_.at(key);
  if (!entry.failure.empty()) fail("{}", entry.failure);
  DenoisedParts backwards = forwards;  // of the same sizes
  Image frames = frames_forwards;
  std::vector<Image*> images = images_of(backwards);
  images.push_back(&frames);
  int64_t place = entry.place;
  for (Image* image : images) {
    const size_t bytes = image->pixels.size() * sizeof(float);
    file_.read(place, image->pixels.data(), bytes);
    place += int64_t(bytes);
  }
  mix_directions(forwards, frames_forwards, backwards, frames);
  return entry.future;
}

}  // namespace ld
