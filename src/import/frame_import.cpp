#include "import/frame_import.h"

#include <ImfChannelList.h>
#include <ImfStringAttribute.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>

#include "core/checksum.h"
#include "core/error.h"
#include "frame/exr_check.h"
#include "frame/exr_reader.h"
#include "frame/picture_place.h"
#include "import/file_views.h"
#include "import/source_plan.h"

namespace ld {
namespace {

using Planes = std::vector<std::vector<float>>;

/// A channel's pixels where the sample has its own: 0 where the channel's part has none.
std::vector<float> read_placed(const ExrReader& exr, const SourceChannel& channel, const Extent& extent) {
  const Extent found = extent_of(exr, channel.part);
  std::vector<float> own(found.pixels());
  exr.read(channel.part, {{channel.name, own.data(), own.size()}});
  if (found == extent) return own;
  std::vector<float> placed(extent.pixels());
  place_pixels(reinterpret_cast<const char*>(own.data()), found, reinterpret_cast<char*>(placed.data()),
               extent, sizeof(float));
  return placed;
}

Planes read_channels(const ExrReader& exr, const SourceFeature& source, const Extent& extent) {
  Planes planes;
  for (const SourceChannel& channel : source.channels) planes.push_back(read_placed(exr, channel, extent));
  return planes;
}

/// Alpha alone may have a data window of its own, as mattes do that are cut to what they cover: it is 0
/// outside.
void require_extent(const ExrReader& exr, const SourceSample& sample, const Extent& expected,
                    const std::string& expected_in) {
  for (const SourceFeature& feature : sample.features)
    for (const SourceChannel& channel : feature.channels) {
      const Extent found = extent_of(exr, channel.part);
      if (!(found == expected))
        fail("{}: channel '{}' is {}, but {} has {}, or another display window; render all at one size",
             exr.path(), channel.name, found.text(), expected_in, expected.text());
    }
}

std::vector<std::string> feature_list(const SourceSample& sample) {
  std::vector<std::string> names;
  for (const SourceFeature& feature : sample.features) names.push_back(feature.mapping->feature);
  return names;
}

/// Of the view that was read.
std::vector<std::string> unused_channels(const ExrReader& exr, const FileViews& views,
                                         const std::vector<SourceSample>& samples) {
  std::set<std::pair<int, std::string>> used;
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

/// Fills a frame sample by sample.
class FrameBuilder {
 public:
  FrameBuilder(ImportMapping mapping, std::optional<ViewCamera> camera, bool allow_identical)
      : mapping_(std::move(mapping)), camera_(std::move(camera)), allow_identical_(allow_identical) {}

  /// Looks at a file's header only.
  void survey(const std::filesystem::path& path) {
    const ExrReader exr(path);
    const std::vector<SourceSample> samples = plan_for(exr);
    if (spp_ == 0) start(exr, samples[0]);
    for (const SourceSample& sample : samples) {
      require_extent(exr, sample, extent_, first_file_);
      if (feature_list(sample) != features_ || (sample.alpha.mapping != nullptr) != has_alpha_)
        fail("{}: holds {}{}, but {} {}{}; expected the same in all samples", exr.path(),
             fmt::join(feature_list(sample), ", "), sample.alpha.mapping != nullptr ? ", alpha" : "",
             first_file_, fmt::join(features_, ", "), has_alpha_ ? ", alpha" : "");
    }
    spp_ += static_cast<int>(samples.size());
    if (spp_ > kMaxSamples || int64_t{extent_.width} * extent_.height * spp_ > kMaxFrameSamples)
      fail("{}: with it the frame has {} samples a pixel of {} x {}; expected at most {} and {} in all",
           exr.path(), spp_, extent_.width, extent_.height, kMaxSamples, kMaxFrameSamples);
  }

  void read(const std::filesystem::path& path) {
    if (result_.frame.spp == 0) allocate();
    const ExrReader exr(path);
    const std::vector<SourceSample> samples = plan_for(exr);
    for (size_t i = 0; i < samples.size(); ++i) {
      if (next_ >= spp_) fail("{}: changed while it was read; try again", exr.path());
      require_extent(exr, samples[i], extent_, first_file_);  // it may have changed since
      read_sample(exr, samples[i],
                  samples.size() == 1 ? path.string() : fmt::format("{}, sample {}", path.string(), i));
    }
  }

  ImportedFrame finish() {
    Frame& frame = result_.frame;
    if (next_ != frame.spp) fail("{}: changed while it was read; try again", first_file_);
    drop_useless_depth();
    result_.faults = sanitise(frame);
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
        if (!shared_[i].empty()) {
          const auto at = static_cast<std::ptrdiff_t>(std::min(i, sample.features.size()));
          sample.features.insert(sample.features.begin() + at, {first_mapping_[i], {}});
        }
    }
    return samples;
  }

  void start(const ExrReader& exr, const SourceSample& sample) {
    first_file_ = exr.path();
    extent_ = extent_of(exr, sample.features[0].channels[0].part);
    features_ = feature_list(sample);
    has_alpha_ = sample.alpha.mapping != nullptr;
    const FileViews views(exr, mapping_.view);
    if (!camera_) camera_ = views.camera();
    mapping_.view = views.chosen();  // of all files, whichever is their own hero
    result_.view = views.chosen();
    if (views.all().size() > 1)
      result_.view_text =
          fmt::format("view: {}, of {}; --view NAME takes another", views.chosen(), views.list());
    for (const SourceFeature& feature : sample.features) result_.taken.push_back(taken_text(feature));
    if (sample.alpha.mapping != nullptr) result_.taken.push_back(taken_text(sample.alpha));
    result_.unused = unused_channels(exr, views, plan_samples(exr, mapping_, Wanted::all));
    result_.frame.info.generator = generator_of(exr, mapping_);
    if (camera_) result_.frame.info.camera = describe(*camera_);
    converter_.emplace(extent_.width, extent_.height, extent_.windows, camera_);
    shared_.resize(features_.size());
    for (size_t i = 0; i < features_.size(); ++i) {
      const SourceFeature& feature = sample.features[i];
      first_mapping_.push_back(feature.mapping);
      if (feature.mapping->per_sample) continue;
      require_extent(exr, {{feature}, {}}, extent_, first_file_);
      shared_[i] = converter_->convert(*feature.mapping, read_channels(exr, feature, extent_));
      result_.repeated.push_back(feature.mapping->feature);
    }
  }

  void allocate() {
    FrameInfo info = result_.frame.info;
    info.windows = extent_.windows;
    result_.frame = Frame(extent_.width, extent_.height, spp_);
    result_.frame.info = info;
    result_.frame.features = features_;
    if (has_alpha_) result_.frame.alpha.resize(result_.frame.valid.size());
  }

  void read_sample(const ExrReader& exr, const SourceSample& sample, const std::string& where) {
    Frame& frame = result_.frame;
    const size_t pixels = frame.plane_size();
    for (size_t i = 0; i < sample.features.size(); ++i) {
      const SourceFeature& source = sample.features[i];
      const Planes planes = shared_[i].empty()
                                ? converter_->convert(*source.mapping, read_channels(exr, source, extent_))
                                : shared_[i];
      const Feature& feature = find_feature(source.mapping->feature);
      for (size_t c = 0; c < planes.size(); ++c)
        std::copy(planes[c].begin(), planes[c].end(),
                  frame.plane(next_, feature.offset + static_cast<int>(c)));
    }
    if (sample.alpha.mapping != nullptr) {
      const Planes alpha = converter_->convert(mapping_.alpha, read_channels(exr, sample.alpha, extent_));
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
    frame.features.erase(std::find(frame.features.begin(), frame.features.end(), "depth"));
    for (int s = 0; s < frame.spp; ++s) std::fill_n(frame.plane(s, kDepthOffset), frame.plane_size(), 0.0F);
    result_.notes.emplace_back(
        "depth left out: it says that every ray escaped, but the normals show surfaces; is the pass empty?");
  }

  ImportMapping mapping_;
  std::optional<ViewCamera> camera_;
  bool allow_identical_;
  std::string first_file_;
  Extent extent_;
  std::vector<std::string> features_;
  std::vector<const FeatureMapping*> first_mapping_;
  std::vector<Planes> shared_;  // converted, of the features that all samples share; else empty
  bool has_alpha_ = false;
  int spp_ = 0, next_ = 0;
  std::optional<Converter> converter_;
  std::map<uint64_t, std::string> seen_;
  ImportedFrame result_;
};

}  // namespace

ImportedFrame import_frame(const std::vector<std::filesystem::path>& files, const ImportMapping& mapping,
                           const std::optional<ViewCamera>& camera, bool allow_identical) {
  if (files.empty()) fail_usage("no files with samples; name them behind the options");
  FrameBuilder builder(mapping, camera, allow_identical);
  for (const std::filesystem::path& file : files) builder.survey(file);
  for (const std::filesystem::path& file : files) builder.read(file);
  return builder.finish();
}

ImportedPicture import_picture(const std::filesystem::path& file, const ImportMapping& mapping) {
  const ExrReader exr(file);
  ImportMapping own = mapping;
  if (FileViews(exr, "").all().empty()) own.view.clear();  // whose view it is goes without saying
  const std::vector<SourceSample> samples = plan_samples(exr, own, Wanted::picture);
  if (samples.size() != 1)
    fail("{}: holds {} samples; expected one converged picture", exr.path(), samples.size());
  const SourceSample& picture = samples[0];
  const Extent extent = extent_of(exr, picture.features[0].channels[0].part);
  require_extent(exr, picture, extent, "its first channel");
  Converter converter(extent.width, extent.height, extent.windows, std::nullopt);
  ImportedPicture result;
  result.windows = extent.windows;
  const bool alpha = picture.alpha.mapping != nullptr;
  result.image = Image(extent.width, extent.height, alpha ? 4 : 3);
  int channel = 0;
  for (const SourceFeature* source : {&picture.features[0], &picture.alpha}) {
    if (source->mapping == nullptr) continue;
    for (const std::vector<float>& plane :
         converter.convert(*source->mapping, read_channels(exr, *source, extent)))
      std::copy(plane.begin(), plane.end(), result.image.plane(channel++));
  }
  return result;
}

}  // namespace ld
