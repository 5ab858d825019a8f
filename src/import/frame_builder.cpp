#include "import/frame_builder.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "core/checksum.h"
#include "core/error.h"
#include "frame/exr_check.h"
#include "frame/frame_attributes.h"
#include "frame/frame_file.h"
#include "import/former_result.h"

namespace ld {
namespace {

/// Parts that make features of a frame: what they leave of the radiance is its indirect light.
bool makes_feature(const SourcePart& part) {
  return part.name == "direct" || part.name == "emission";
}

void add_matrices(const ViewCamera& camera, const Picture& picture, FrameInfo& info) {
  const auto triple = [](const Imath::V3d& v) { return std::array<double, 3>{v.x, v.y, v.z}; };
  const CameraPlace place = {triple(camera.position), triple(camera.right), triple(camera.up),
                             triple(camera.back)};
  info.world_to_camera = world_to_camera(place);
  if (!camera.fov_y) return;
  const double half_height = std::tan(0.5 * *camera.fov_y);
  info.world_to_ndc = world_to_ndc(place, half_height * picture.width / picture.height, half_height);
}

}  // namespace

FrameBuilder::FrameBuilder(ImportMapping mapping, std::optional<ViewCamera> camera, bool allow_identical,
                           std::vector<std::string> also)
    : mapping_(std::move(mapping)),
      camera_(std::move(camera)),
      allow_identical_(allow_identical),
      also_(std::move(also)) {}

void FrameBuilder::survey(const std::filesystem::path& path) {
  const ExrReader exr(path);
  const std::vector<SourceSample> samples = plan_for(exr);
  if (spp_ == 0) start(exr, samples[0]);
  if (const std::vector<std::string> parts = names_of(chosen_parts(exr)); parts != parts_)
    fail("{}: holds the light parts {}, but {} {}; expected the same in all samples", exr.path(),
         fmt::join(parts, ", "), first_file_, fmt::join(parts_, ", "));
  if (split_parts(exr).empty() == splits_)
    fail("{}: holds direct and emitted light, but {} does not; expected the same in all samples",
         splits_ ? first_file_ : exr.path(), splits_ ? exr.path() : first_file_);
  for (const SourceSample& sample : samples) {
    for (const SourceChannel& channel : sample.features[0].channels)
      if (is_denoised(exr, FileViews(exr, mapping_.view), channel.part))
        fail("{}: {}", exr.path(), kDenoisedAlready);
    window_.add(exr, sample);
    if (feature_list(sample) != features_ || (sample.alpha.mapping != nullptr) != has_alpha_)
      fail("{}: holds {}{}, but {} {}{}; expected the same in all samples", exr.path(),
           fmt::join(feature_list(sample), ", "), sample.alpha.mapping != nullptr ? ", alpha" : "",
           first_file_, fmt::join(features_, ", "), has_alpha_ ? ", alpha" : "");
  }
  spp_ += static_cast<int>(samples.size());
  const Extent extent = window_.extent();
  if (spp_ > kMaxSamples || int64_t{extent.width} * extent.height * spp_ > kMaxFrameSamples)
    fail("{}: with it the frame has {} samples a pixel of {} x {}; expected at most {} and {} in all",
         exr.path(), spp_, extent.width, extent.height, kMaxSamples, kMaxFrameSamples);
}

void FrameBuilder::read(const std::filesystem::path& path) {
  const ExrReader exr(path);
  const std::vector<SourceSample> samples = plan_for(exr);
  if (result_.frame.spp == 0) allocate(exr, samples[0]);
  std::vector<std::vector<SourcePart>> parts(samples.size());
  if (splits_ || !also_.empty()) parts = plan_light_parts(exr, mapping_);
  for (size_t i = 0; i < samples.size(); ++i) {
    if (next_ >= spp_ || feature_list(samples[i]) != features_ ||
        (samples[i].alpha.mapping != nullptr) != has_alpha_ || parts.size() != samples.size())
      fail("{}: changed while it was read; try again", exr.path());
    read_parts(exr, parts[i]);
    read_sample(exr, samples[i],
                samples.size() == 1 ? path.string() : fmt::format("{}, sample {}", path.string(), i));
    if (splits_) split_light(exr, parts[i]);
  }
}

ImportedFrame FrameBuilder::finish() {
  Frame& frame = result_.frame;
  if (next_ != frame.spp) fail("{}: changed while it was read; try again", first_file_);
  for (const std::string& note : window_.notes()) result_.notes.push_back(note);
  for (const std::string& feature : window_.elsewhere()) leave_out(feature);
  drop_useless_depth();
  drop_useless_id();
  result_.faults = sanitise(frame);
  require_valid_sample(frame, first_file_);
  frame.info.depth_scale = median_depth(frame);
  result_.counts = converter_->counts();
  return std::move(result_);
}

std::vector<SourceSample> FrameBuilder::plan_for(const ExrReader& exr) const {
  if (exr.path() == first_file_ || first_file_.empty()) return plan_samples(exr, mapping_, Wanted::all);
  std::vector<SourceSample> samples = plan_samples(exr, mapping_, Wanted::per_sample);
  for (SourceSample& sample : samples) {
    for (size_t i = 0; i < features_.size(); ++i)
      if (!first_mapping_[i]->per_sample) {
        const auto at = static_cast<std::ptrdiff_t>(std::min(i, sample.features.size()));
        sample.features.insert(sample.features.begin() + at, {first_mapping_[i], {}});
      }
  }
  return samples;
}

std::vector<SourcePart> FrameBuilder::chosen_parts(const ExrReader& exr) const {
  if (also_.empty()) return {};
  std::vector<SourcePart> parts = plan_light_parts(exr, mapping_)[0];
  parts.erase(std::remove_if(parts.begin(), parts.end(), makes_feature), parts.end());
  const std::vector<std::string> chosen = choose_names(names_of(parts), also_, exr.path());
  parts.erase(std::remove_if(parts.begin(), parts.end(),
                             [&](const SourcePart& part) {
                               return std::count(chosen.begin(), chosen.end(), part.name) == 0;
                             }),
              parts.end());
  return parts;
}

std::vector<SourcePart> FrameBuilder::split_parts(const ExrReader& exr) const {
  std::vector<SourcePart> parts = plan_light_parts(exr, mapping_)[0];
  parts.erase(
      std::remove_if(parts.begin(), parts.end(), [](const SourcePart& part) { return !makes_feature(part); }),
      parts.end());
  if (parts.size() != 2) parts.clear();
  return parts;
}

FrameBuilder::Planes FrameBuilder::read_part(const ExrReader& exr, const SourcePart& part) {
  FeatureMapping as_it_is;
  as_it_is.feature = "radiance";
  as_it_is.scale.assign(part.channels.size(), 1);
  as_it_is.offset.assign(part.channels.size(), 0);
  return sum_of_products(part, read_feature(exr, {&as_it_is, part.channels}, extent_, *converter_));
}

void FrameBuilder::split_light(const ExrReader& exr, const std::vector<SourcePart>& parts) {
  Frame& frame = result_.frame;
  const int sample = next_ - 1;
  const size_t pixels = frame.plane_size();
  for (int c = 0; c < 3; ++c)
    std::copy_n(frame.plane(sample, kRadianceOffset + c), pixels, frame.plane(sample, kIndirectOffset + c));
  for (const SourcePart& part : parts) {
    if (!makes_feature(part)) continue;
    const Planes planes = read_part(exr, part);
    for (int c = 0; c < 3; ++c) {
      float* const own = frame.plane(sample, find_feature(part.name).offset + c);
      float* const left = frame.plane(sample, kIndirectOffset + c);
      for (size_t p = 0; p < pixels; ++p) {
        own[p] = std::max(planes[size_t(c)][p], 0.0F);
        left[p] = std::max(left[p] - own[p], 0.0F);  // rounding may leave less than nothing
      }
    }
  }
}

void FrameBuilder::read_parts(const ExrReader& exr, const std::vector<SourcePart>& parts) {
  Frame& frame = result_.frame;
  for (const SourcePart& part : parts) {
    const auto name = std::find(parts_.begin(), parts_.end(), part.name);
    if (name == parts_.end()) continue;
    const Planes planes = read_part(exr, part);
    for (int c = 0; c < 3; ++c)
      std::copy(planes[static_cast<size_t>(c)].begin(), planes[static_cast<size_t>(c)].end(),
                frame.part_plane(static_cast<size_t>(name - parts_.begin()), next_, c));
  }
}

void FrameBuilder::start(const ExrReader& exr, const SourceSample& sample) {
  first_file_ = exr.path();
  features_ = feature_list(sample);
  has_alpha_ = sample.alpha.mapping != nullptr;
  const FileViews views(exr, mapping_.view);
  if (!camera_) {
    camera_ = views.camera();
    if (camera_) result_.frame.info.world_to_ndc = read_matrix(exr.header(0), kWorldToNdc);
  }
  mapping_.view = views.chosen();  // of all files, whichever is their own hero
  result_.view = views.chosen();
  if (views.all().size() > 1)
    result_.view_text =
        fmt::format("view: {}, of {}; --view NAME takes another", views.chosen(), views.list());
  for (const SourceFeature& feature : sample.features) result_.taken.push_back(taken_text(feature));
  if (sample.alpha.mapping != nullptr) result_.taken.push_back(taken_text(sample.alpha));
  std::vector<SourcePart> parts = chosen_parts(exr);
  parts_ = names_of(parts);
  const std::vector<SourcePart> split = split_parts(exr);
  splits_ = !split.empty();
  parts.insert(parts.end(), split.begin(), split.end());
  for (const SourcePart& part : parts) result_.taken.push_back(taken_text(part));
  if (splits_) result_.taken.emplace_back("indirect: radiance - direct - emission");
  result_.unused = unused_channels(exr, views, plan_samples(exr, mapping_, Wanted::all), parts);
  result_.frame.info.generator = generator_of(exr, mapping_);
  if (camera_) result_.frame.info.camera = describe(*camera_);
  for (const SourceFeature& feature : sample.features) first_mapping_.push_back(feature.mapping);
}

void FrameBuilder::allocate(const ExrReader& exr, const SourceSample& sample) {
  extent_ = window_.extent();
  FrameInfo info = result_.frame.info;
  info.windows = extent_.windows;
  if (camera_) add_matrices(*camera_, picture_of(extent_.width, extent_.height, extent_.windows), info);
  converter_.emplace(extent_.width, extent_.height, extent_.windows, camera_);
  shared_.resize(features_.size());
  if (feature_list(sample) != features_) fail("{}: changed while it was read; try again", exr.path());
  for (size_t i = 0; i < features_.size(); ++i) {
    const SourceFeature& feature = sample.features[i];
    if (feature.mapping->per_sample) continue;
    shared_[i] = read_feature(exr, feature, extent_, *converter_);
    result_.repeated.push_back(feature.mapping->feature);
  }
  std::vector<std::string> features = features_;
  if (splits_) features.insert(features.end(), {"direct", "indirect", "emission"});
  result_.frame = Frame(extent_.width, extent_.height, spp_, frame_channels(features));
  result_.frame.info = info;
  result_.frame.features = features;
  if (has_alpha_) result_.frame.alpha.resize(result_.frame.valid.size());
  for (const std::string& name : parts_) result_.frame.add_part(name);
}

void FrameBuilder::read_sample(const ExrReader& exr, const SourceSample& sample, const std::string& where) {
  Frame& frame = result_.frame;
  const size_t pixels = frame.plane_size();
  for (size_t i = 0; i < sample.features.size(); ++i) {
    const SourceFeature& source = sample.features[i];
    const Planes planes = shared_[i].empty() ? read_feature(exr, source, extent_, *converter_) : shared_[i];
    const Feature& feature = find_feature(source.mapping->feature);
    for (size_t c = 0; c < planes.size(); ++c)
      std::copy(planes[c].begin(), planes[c].end(), frame.plane(next_, feature.offset + static_cast<int>(c)));
  }
  if (sample.alpha.mapping != nullptr) {
    const Planes alpha = read_feature(exr, sample.alpha, extent_, *converter_);
    std::copy(alpha[0].begin(), alpha[0].end(),
              frame.alpha.begin() + static_cast<std::ptrdiff_t>(next_ * pixels));
  }
  const uint64_t sum = checksum(frame.plane(next_, kRadianceOffset), 3 * pixels * sizeof(float));
  const auto [twin, is_new] = seen_.emplace(sum, where);
  if (!is_new && !allow_identical_)
    fail(
        "{} and {} hold the same radiance in every pixel: the same noise twice; render them with different "
        "seeds "
        "(--allow-identical where a picture has no noise)",
        twin->second, where);
  ++next_;
}

void FrameBuilder::leave_out(const std::string& name) {
  Frame& frame = result_.frame;
  frame.features.erase(std::find(frame.features.begin(), frame.features.end(), name));
  const Feature& feature = find_feature(name);
  for (int s = 0; s < frame.spp; ++s)
    std::fill_n(frame.plane(s, feature.offset), static_cast<size_t>(feature.channels) * frame.plane_size(),
                0.0F);
}

void FrameBuilder::drop_useless_depth() {
  Frame& frame = result_.frame;
  if (!frame.holds("depth") || !frame.holds("normal")) return;
  bool hit = false;
  for (int s = 0; s < frame.spp; ++s) {
    const float* depth = frame.plane(s, kDepthOffset);
    if (std::any_of(depth, depth + frame.plane_size(), [](float d) { return d < kEscapedDepth; })) return;
    const float* normal = frame.plane(s, kNormalOffset);
    hit = hit || std::any_of(normal, normal + 3 * frame.plane_size(), [](float n) { return n != 0; });
  }
  if (!hit) return;
  leave_out("depth");
  result_.notes.emplace_back(
      "depth left out: it says that every ray escaped, but the normals show surfaces; is the pass empty?");
}

void FrameBuilder::drop_useless_id() {
  Frame& frame = result_.frame;
  if (!frame.holds("id")) return;
  for (int s = 0; s < frame.spp; ++s) {
    const float* id = frame.plane(s, kIdOffset);
    if (std::any_of(id, id + frame.plane_size(), [](float value) { return value != 0; })) return;
  }
  leave_out("id");
  result_.notes.emplace_back("id left out: it is 0 in every pixel; number the objects from 1 on");
}

}  // namespace ld
