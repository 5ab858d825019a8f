#include "import/frame_import.h"

#include <ImfChannelList.h>
#include <ImfStringAttribute.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/checksum.h"
#include "core/error.h"
#include "frame/exr_check.h"
#include "frame/exr_reader.h"
#include "frame/frame_attributes.h"
#include "frame/frame_file.h"
#include "import/file_views.h"
#include "import/former_result.h"
#include "import/light_parts.h"
#include "import/sample_window.h"
#include "import/source_plan.h"

namespace ld {
namespace {

using Planes = std::vector<std::vector<float>>;

std::vector<std::string> feature_list(const SourceSample& sample) {
  std::vector<std::string> names;
  for (const SourceFeature& feature : sample.features) names.push_back(feature.mapping->feature);
  return names;
}

/// Of the view that was read.
std::vector<std::string> unused_channels(const ExrReader& exr, const FileViews& views,
                                         const std::vector<SourceSample>& samples,
                                         const std::vector<SourcePart>& parts) {
  std::set<std::pair<int, std::string>> used;
  for (const SourcePart& part : parts)
    for (const SourceChannel& channel : part.channels) used.insert({channel.part, channel.name});
  for (const SourceSample& sample : samples) {
    for (const SourceFeature& feature : sample.features)
      for (const SourceChannel& channel : feature.channels) used.insert({channel.part, channel.name});
    for (const SourceChannel& channel : sample.alpha.channels) used.insert({channel.part, channel.name});
  }
  std::vector<std::string> unused;
  for (int part = 0; part < exr.parts(); ++part) {
    const Imf::ChannelList& channels = exr.header(part).channels();
    for (auto it = channels.begin(); it != channels.end(); ++it)
      if (used.count({part, it.name()}) == 0 && views.name_of(part, it.name()))
        unused.push_back(exr.parts() > 1 ? fmt::format("{} of part '{}'", it.name(), exr.part_name(part))
                                         : it.name());
  }
  return unused;
}

std::string taken_text(const SourceFeature& source) {
  std::vector<std::string> names;
  for (const SourceChannel& channel : source.channels) names.push_back(channel.name);
  std::string text = fmt::format("{}: {}", source.mapping->feature, fmt::join(names, ", "));
  if (source.mapping->feature == "normal") text += fmt::format(" ({} space)", source.mapping->space);
  if (source.mapping->feature == "depth") text += fmt::format(" ({})", source.mapping->kind);
  return text;
}

std::vector<std::string> names_of(const std::vector<SourcePart>& parts) {
  std::vector<std::string> names;
  for (const SourcePart& part : parts) names.push_back(part.name);
  return names;
}

/// Parts that make features of a frame: what they leave of the radiance is its indirect light.
bool makes_feature(const SourcePart& part) {
  return part.name == "direct" || part.name == "emission";
}

std::string taken_text(const SourcePart& part) {
  std::string text = part.name + ": ";
  size_t channel = 0;
  for (size_t term = 0; term < part.factors.size(); ++term)
    for (size_t f = 0; f < part.factors[term]; ++f, channel += 3) {
      const std::string& name = part.channels[channel].name;
      text += (f > 0 ? " * " : term > 0 ? " + " : "") + name.substr(0, name.size() - 2);
    }
  return text;
}

std::string generator_of(const ExrReader& exr, const ImportMapping& mapping) {
  for (const char* name : {"generatedBy", "Software", "software"})
    if (const auto* text = exr.header(0).findTypedAttribute<Imf::StringAttribute>(name)) return text->value();
  return mapping.about;
}

std::string describe(const ViewCamera& camera) {
  const auto triple = [](const Imath::V3d& v) { return fmt::format("{:g} {:g} {:g}", v.x, v.y, v.z); };
  return fmt::format("position {}; right {}; up {}{}", triple(camera.position), triple(camera.right),
                     triple(camera.up),
                     camera.fov_y ? fmt::format("; vertical fov {:g} rad", *camera.fov_y) : "");
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

/// Fills a frame sample by sample.
class FrameBuilder {
 public:
  FrameBuilder(ImportMapping mapping, std::optional<ViewCamera> camera, bool allow_identical,
               std::vector<std::string> also)
      : mapping_(std::move(mapping)),
        camera_(std::move(camera)),
        allow_identical_(allow_identical),
        also_(std::move(also)) {}

  /// Looks at a file's header only.
  void survey(const std::filesystem::path& path) {
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

  void read(const std::filesystem::path& path) {
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

  ImportedFrame finish() {
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

 private:
  /// Features that one plane serves for all samples are looked for in the first file only.
  std::vector<SourceSample> plan_for(const ExrReader& exr) const {
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

  /// Those of a file's first sample that are asked for.
  std::vector<SourcePart> chosen_parts(const ExrReader& exr) const {
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

  /// Those of a file's first sample that make features; both or none.
  std::vector<SourcePart> split_parts(const ExrReader& exr) const {
    std::vector<SourcePart> parts = plan_light_parts(exr, mapping_)[0];
    parts.erase(std::remove_if(parts.begin(), parts.end(),
                               [](const SourcePart& part) { return !makes_feature(part); }),
                parts.end());
    if (parts.size() != 2) parts.clear();
    return parts;
  }

  /// [R, G, B]
  Planes read_part(const ExrReader& exr, const SourcePart& part) {
    FeatureMapping as_it_is;
    as_it_is.feature = "radiance";
    as_it_is.scale.assign(part.channels.size(), 1);
    as_it_is.offset.assign(part.channels.size(), 0);
    return sum_of_products(part, read_feature(exr, {&as_it_is, part.channels}, extent_, *converter_));
  }

  /// Direct and emitted light of the sample that was read last, and as its indirect light what is left.
  void split_light(const ExrReader& exr, const std::vector<SourcePart>& parts) {
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

  void read_parts(const ExrReader& exr, const std::vector<SourcePart>& parts) {
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

  void start(const ExrReader& exr, const SourceSample& sample) {
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

  /// When all files have been surveyed, with the first of them.
  void allocate(const ExrReader& exr, const SourceSample& sample) {
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

  void read_sample(const ExrReader& exr, const SourceSample& sample, const std::string& where) {
    Frame& frame = result_.frame;
    const size_t pixels = frame.plane_size();
    for (size_t i = 0; i < sample.features.size(); ++i) {
      const SourceFeature& source = sample.features[i];
      const Planes planes = shared_[i].empty() ? read_feature(exr, source, extent_, *converter_) : shared_[i];
      const Feature& feature = find_feature(source.mapping->feature);
      for (size_t c = 0; c < planes.size(); ++c)
        std::copy(planes[c].begin(), planes[c].end(),
                  frame.plane(next_, feature.offset + static_cast<int>(c)));
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

  void leave_out(const std::string& name) {
    Frame& frame = result_.frame;
    frame.features.erase(std::find(frame.features.begin(), frame.features.end(), name));
    const Feature& feature = find_feature(name);
    for (int s = 0; s < frame.spp; ++s)
      std::fill_n(frame.plane(s, feature.offset), static_cast<size_t>(feature.channels) * frame.plane_size(),
                  0.0F);
  }

  /// A pass that was never written says that all rays escaped; normals say that they did not.
  void drop_useless_depth() {
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

  /// Objects that nobody numbered are all the same.
  void drop_useless_id() {
    Frame& frame = result_.frame;
    if (!frame.holds("id")) return;
    for (int s = 0; s < frame.spp; ++s) {
      const float* id = frame.plane(s, kIdOffset);
      if (std::any_of(id, id + frame.plane_size(), [](float value) { return value != 0; })) return;
    }
    leave_out("id");
    result_.notes.emplace_back("id left out: it is 0 in every pixel; number the objects from 1 on");
  }

  ImportMapping mapping_;
  std::optional<ViewCamera> camera_;
  bool allow_identical_;
  std::vector<std::string> also_, parts_;  // patterns, and the names of the light parts that they fit
  std::string first_file_;
  FrameWindow window_;
  Extent extent_;  // when it is known
  std::vector<std::string> features_;
  std::vector<const FeatureMapping*> first_mapping_;
  std::vector<Planes> shared_;               // converted, of the features that all samples share; else empty
  bool has_alpha_ = false, splits_ = false;  // direct, indirect and emitted light apart
  int spp_ = 0, next_ = 0;
  std::optional<Converter> converter_;
  std::map<uint64_t, std::string> seen_;
  ImportedFrame result_;
};

}  // namespace

ImportedFrame import_frame(const std::vector<std::filesystem::path>& files, const ImportMapping& mapping,
                           const std::optional<ViewCamera>& camera, bool allow_identical,
                           const std::vector<std::string>& also) {
  if (files.empty()) fail_usage("no files with samples; name them behind the options");
  FrameBuilder builder(mapping, camera, allow_identical, also);
  for (const std::filesystem::path& file : files) builder.survey(file);
  for (const std::filesystem::path& file : files) builder.read(file);
  return builder.finish();
}

void require_valid_sample(const Frame& frame, const std::string& file) {
  if (std::all_of(frame.valid.begin(), frame.valid.end(), [](uint8_t valid) { return valid == 0; }))
    fail(
        "{}: nothing to see: every sample of every pixel is NaN or infinite, in radiance or alpha, or was "
        "not drawn; render it again",
        file);
}

ImportedPicture import_picture(const std::filesystem::path& file, const ImportMapping& mapping) {
  const ExrReader exr(file);
  ImportMapping own = mapping;
  if (FileViews(exr, "").all().empty()) own.view.clear();  // whose view it is goes without saying
  const std::vector<SourceSample> samples = plan_samples(exr, own, Wanted::picture);
  if (samples.size() != 1)
    fail("{}: holds {} samples; expected one converged picture", exr.path(), samples.size());
  const SourceSample& picture = samples[0];
  FrameWindow window;
  window.add(exr, picture);
  const Extent extent = window.extent();
  Converter converter(extent.width, extent.height, extent.windows, std::nullopt);
  ImportedPicture result;
  result.windows = extent.windows;
  const bool alpha = picture.alpha.mapping != nullptr;
  result.image = Image(extent.width, extent.height, alpha ? 4 : 3);
  int channel = 0;
  for (const SourceFeature* source : {&picture.features[0], &picture.alpha}) {
    if (source->mapping == nullptr) continue;
    for (const std::vector<float>& plane : read_feature(exr, *source, extent, converter))
      std::copy(plane.begin(), plane.end(), result.image.plane(channel++));
  }
  const auto end = result.image.pixels.begin() + static_cast<std::ptrdiff_t>(3 * result.image.plane_size());
  if (std::none_of(result.image.pixels.begin(), end, [](float value) { return std::isfinite(value); }))
    fail("{}: every pixel is NaN or infinite; render it again", exr.path());
  return result;
}

}  // namespace ld
