#include "import/sample_window.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <string>

#include "core/error.h"
#include "frame/exr_check.h"
#include "frame/frame_attributes.h"
#include "import/file_views.h"

namespace ld {
namespace {

Imath::Box2i window_of(const ExrReader& exr, const SourceFeature& source) {
  Imath::Box2i window;
  for (const SourceChannel& channel : source.channels) window.extendBy(exr.header(channel.part).dataWindow());
  return window;
}

bool covers(const Imath::Box2i& window, const Imath::Box2i& other) {
  return window.intersects(other.min) && window.intersects(other.max);
}

std::string text_of(const Imath::Box2i& window) {
  // Display windows may be of any size.
  return fmt::format("{} x {} pixels at ({}, {})", int64_t{window.max.x} - window.min.x + 1,
                     int64_t{window.max.y} - window.min.y + 1, window.min.x, window.min.y);
}

}  // namespace

void FrameWindow::add(const ExrReader& exr, const SourceSample& sample) {
  if (first_file_.empty()) {
    first_file_ = exr.path();
    display_ = exr.header(sample.features[0].channels[0].part).displayWindow();
  }
  for (const SourceFeature& source : sample.features) {
    if (source.channels.empty()) continue;  // of all samples: the first file has it
    for (const SourceChannel& channel : source.channels) {
      const Imath::Box2i& display = exr.header(channel.part).displayWindow();
      if (display != display_)
        fail(
            "{}: the display window of channel '{}' is {}, but that of {} is {}; render all samples of a "
            "frame at one size",
            exr.path(), channel.name, text_of(display), first_file_, text_of(display_));
    }
    windows_[source.mapping->feature].push_back(window_of(exr, source));
  }
  include(window_of(exr, sample.features[0]), exr.path());
}

void FrameWindow::include(const Imath::Box2i& window, const std::string& path) {
  data_.extendBy(window);
  // Windows may lie anywhere: their distance need not fit an int.
  const int64_t width = int64_t{data_.max.x} - data_.min.x + 1,
                height = int64_t{data_.max.y} - data_.min.y + 1;
  if (width > kMaxImageSide || height > kMaxImageSide)
    fail(
        "{}: with its data window ({}) the frame has {} x {} pixels; expected at most {} a side; render all "
        "samples of a frame at one place",
        path, text_of(window), width, height, kMaxImageSide);
}

Extent FrameWindow::extent() const {
  return {data_.max.x - data_.min.x + 1, data_.max.y - data_.min.y + 1,
          windows_of(Imf::Header(display_, data_))};
}

std::vector<std::string> FrameWindow::notes() const {
  std::vector<std::string> notes;
  const std::vector<std::string> left_out = elsewhere();
  for (const auto& [feature, windows] : windows_) {
    if (std::count(left_out.begin(), left_out.end(), feature) > 0) {
      notes.push_back(
          fmt::format("{} left out: its data window ({}) has no pixel in that of the radiance ({})", feature,
                      text_of(windows[0]), text_of(data_)));
      continue;
    }
    const auto smaller = std::find_if(windows.begin(), windows.end(),
                                      [&](const Imath::Box2i& window) { return !covers(window, data_); });
    if (smaller == windows.end()) continue;
    notes.push_back(fmt::format("{}: its data window ({}) is not all of the frame's ({}); outside of it {}",
                                feature, text_of(*smaller), text_of(data_),
                                feature == "radiance" ? "the sample is black and transparent"
                                                      : "it is as where a ray meets nothing"));
  }
  return notes;
}

std::vector<std::string> FrameWindow::elsewhere() const {
  std::vector<std::string> features;
  for (const auto& [feature, windows] : windows_)
    if (std::none_of(windows.begin(), windows.end(),
                     [&](const Imath::Box2i& window) { return window.intersects(data_); }))
      features.push_back(feature);
  return features;
}

Extent extent_of_files(const std::vector<std::filesystem::path>& files, const ImportMapping& mapping) {
  FrameWindow window;
  ImportMapping own = mapping;
  for (const std::filesystem::path& file : files) {
    const ExrReader exr(file);
    own.view = FileViews(exr, own.view).chosen();  // of all files that of the first
    for (const SourceSample& sample : plan_samples(exr, own, Wanted::picture)) window.add(exr, sample);
  }
  return window.extent();
}

std::vector<std::vector<float>> read_feature(const ExrReader& exr, const SourceFeature& source,
                                             const Extent& frame, Converter& converter) {
  std::vector<std::vector<float>> planes;
  bool everywhere = false;
  std::vector<uint8_t> there(frame.pixels());  // where the file has a pixel of one of the channels
  // All channels of a part at once, whose chunks are unpacked as a whole.
  std::map<int, std::map<std::string, std::vector<float>>> read;
  for (const SourceChannel& channel : source.channels)
    read[channel.part][channel.name].resize(extent_of(exr, channel.part).pixels());
  for (auto& [part, channels] : read) {
    std::vector<ExrPlane> wanted;
    for (auto& [name, pixels] : channels) wanted.push_back({name, pixels.data(), pixels.size()});
    exr.read(part, wanted);
  }
  for (const SourceChannel& channel : source.channels) {
    const Extent own = extent_of(exr, channel.part);
    std::vector<float> pixels = read[channel.part][channel.name];  // one may stand for several
    if (own == frame) {
      planes.push_back(std::move(pixels));
      everywhere = true;
      continue;
    }
    planes.emplace_back(frame.pixels());
    place_pixels(reinterpret_cast<const char*>(pixels.data()), own,
                 reinterpret_cast<char*>(planes.back().data()), frame, sizeof(float));
    const std::vector<char> ones(own.pixels(), 1);
    place_pixels(ones.data(), own, reinterpret_cast<char*>(there.data()), frame, 1);
  }
  planes = converter.convert(*source.mapping, std::move(planes));
  if (everywhere) return planes;
  const float nothing = source.mapping->feature == "depth" ? kEscapedDepth : 0.0F;
  for (std::vector<float>& plane : planes)
    for (size_t p = 0; p < there.size(); ++p)
      if (there[p] == 0) plane[p] = nothing;
  return planes;
}

}  // namespace ld
