#include <ImfChannelList.h>
#include <fmt/ranges.h>
#include <fnmatch.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <mutex>
#include <set>
#include <utility>

#include "core/error.h"
#include "frame/derived_features.h"
#include "frame/exr_check.h"
#include "frame/exr_reader.h"
#include "frame/frame_attributes.h"
#include "frame/frame_file.h"

namespace ld {
namespace {

/// The parts that hold samples, in their order: [sample] -> part. Empty for a file with means only.
std::vector<int> sample_parts(const ExrReader& exr) {
  std::map<int, int> found;
  for (int part = 0; part < exr.parts(); ++part) {
    const int number = sample_number(exr.part_name(part));
    if (number < 0) continue;
    if (!found.emplace(number, part).second)
      fail("{}: two parts hold sample {}; number the sample parts s000, s001, ...", exr.path(), number);
  }
  std::vector<int> parts;
  for (const auto& [number, part] : found) {
    if (number != static_cast<int>(parts.size()))
      fail("{}: no part 's{:03}', but '{}'; number the sample parts s000, s001, ... without gaps", exr.path(),
           parts.size(), exr.part_name(part));
    parts.push_back(part);
  }
  if (parts.size() > size_t{kMaxSamples})
    fail("{}: {} samples a pixel; expected at most {}", exr.path(), parts.size(), kMaxSamples);
  for (const int part : parts)
    if (exr.header(part).dataWindow() != exr.header(parts[0]).dataWindow())
      fail(
          "{}: part '{}' is {} x {} and part 's000' {} x {} pixels, or they lie elsewhere; expected the same "
          "data window "
          "in all samples",
          exr.path(), exr.part_name(part), exr.width(part), exr.height(part), exr.width(parts[0]),
          exr.height(parts[0]));
  return parts;
}

/// "s0", "S_01", "sample.0001": as samples are numbered elsewhere.
bool looks_like_sample(const std::string& name) {
  size_t digits = 0;
  while (digits < name.size() &&
         std::isdigit(static_cast<unsigned char>(name[name.size() - 1 - digits])) != 0)
    ++digits;
  std::string word = name.substr(0, name.size() - digits);
  if (!word.empty() && std::string("_-. ").find(word.back()) != std::string::npos) word.pop_back();
  std::transform(word.begin(), word.end(), word.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return digits > 0 && (word == "s" || word == "sample");
}

std::string misnamed_sample(const ExrReader& exr) {
  for (int part = 0; part < exr.parts(); ++part)
    if (looks_like_sample(exr.part_name(part))) return exr.part_name(part);
  return "";
}

/// Channels of integers that happen to be called like those of filters are none of ours.
bool holds(const ExrReader& exr, int part, const Feature& feature) {
  const Imf::ChannelList& channels = exr.header(part).channels();
  for (size_t c = 0; c < static_cast<size_t>(feature.channels); ++c) {
    const Imf::Channel* found = channels.findChannel(feature.exr_channels[c]);
    if (found == nullptr || (found->type == Imf::UINT && feature.offset >= kSampleChannels)) return false;
  }
  return true;
}

/// Layers of a part that have R, G and B, but for those that are features.
std::set<std::string> coloured_layers(const ExrReader& exr, int part) {
  std::set<std::string> layers;
  const Imf::ChannelList& channels = exr.header(part).channels();
  for (auto it = channels.begin(); it != channels.end(); ++it) {
    const std::string name = it.name();
    if (name.size() < 3 || name.compare(name.size() - 2, 2, ".R") != 0) continue;
    const std::string layer = name.substr(0, name.size() - 2);
    if (exr.has_channel(part, layer + ".G") && exr.has_channel(part, layer + ".B")) layers.insert(layer);
  }
  for (const Feature& feature : feature_schema())
    if (feature.offset < kDirectOffset || feature.offset >= kHalfRadianceOffset)
      layers.erase(feature.name);  // those behind are parts of the light, too
  return layers;
}

/// Those that all of the parts have.
std::vector<std::string> common_layers(const ExrReader& exr, const std::vector<int>& parts) {
  if (parts.empty()) return {};
  std::set<std::string> common = coloured_layers(exr, parts[0]);
  for (const int part : parts) {
    const std::set<std::string> own = common.empty() ? common : coloured_layers(exr, part);
    for (auto layer = common.begin(); layer != common.end();)
      layer = own.count(*layer) > 0 ? std::next(layer) : common.erase(layer);
  }
  return {common.begin(), common.end()};
}

FrameHeader header_of(const ExrReader& exr, const std::vector<int>& parts) {
  FrameHeader header;
  int said_spp = -1;
  header.info = read_attributes(exr.header(0), exr.path(), said_spp);
  header.spp = static_cast<int>(parts.size());
  if (parts.empty()) header.misnamed = misnamed_sample(exr);
  if (said_spp > 0 && !header.misnamed.empty()) fail("{}: no samples: {}", exr.path(), misnamed_text(header));
  if (said_spp >= 0 && said_spp != header.spp)
    fail(
        "{}: the attribute ldSpp says {} samples a pixel, but {} sample parts were found; keep the parts "
        "together or "
        "correct the attribute",
        exr.path(), said_spp, header.spp);
  const int first = parts.empty() ? 0 : parts[0];
  header.info.windows = windows_of(exr.header(first));
  header.alpha = !parts.empty() && std::all_of(parts.begin(), parts.end(),
                                               [&](int part) { return exr.has_channel(part, "A"); });
  header.layers = common_layers(exr, parts);
  header.width = exr.width(first);
  header.height = exr.height(first);
  if (int64_t{header.width} * header.height * std::max(header.spp, 1) > kMaxFrameSamples)
    fail("{}: {} x {} pixels with {} samples each; expected at most {} samples in all", exr.path(),
         header.width, header.height, header.spp, kMaxFrameSamples);
  for (const Feature& feature : feature_schema())
    if (!parts.empty() &&
        std::all_of(parts.begin(), parts.end(), [&](int part) { return holds(exr, part, feature); }))
      header.features.push_back(feature.name);
  return header;
}

void require_samples(const std::string& name, int held, int samples) {
  if (held < samples)
    fail("{}: {} samples a pixel, but {} are asked for; render more, or ask for {} or less", name, held,
         samples, held);
}

/// Radiance is always needed: without it there is nothing to denoise.
void require_features(const ExrReader& exr, const std::vector<int>& parts,
                      std::vector<std::string> required) {
  required.insert(required.begin(), "radiance");
  for (const std::string& name : required) {
    const Feature& feature = find_feature(name);
    const std::string advice = fmt::format(
        "the feature '{0}' is needed; render with it, or use a model whose `features` leave '{0}' out", name);
    for (const int part : parts)
      for (size_t c = 0; c < static_cast<size_t>(feature.channels); ++c)
        exr.require_channel(part, feature.exr_channels[c], advice);
  }
}

}  // namespace

namespace {

/// Direct light and others are features and parts at once; no channel is read twice.
void copy_features_to_parts(Frame& frame) {
  for (LightPart& part : frame.parts) {
    if (!frame.holds(part.name)) continue;
    const size_t floats = 3 * frame.plane_size();
    for (int s = 0; s < frame.spp; ++s)
      std::copy_n(frame.plane(s, find_feature(part.name).offset), floats,
                  part.samples.begin() + static_cast<std::ptrdiff_t>(static_cast<size_t>(s) * floats));
  }
}

}  // namespace

std::vector<std::string> choose_names(const std::vector<std::string>& names,
                                      const std::vector<std::string>& patterns, const std::string& where) {
  std::vector<std::string> chosen;
  for (const std::string& pattern : patterns)
    if (std::none_of(names.begin(), names.end(),
                     [&](const std::string& name) { return fnmatch(pattern.c_str(), name.c_str(), 0) == 0; }))
      fail("{}: no part of the light is called '{}'; {}", where, pattern,
           names.empty() ? "there is none" : fmt::format("there are {}", fmt::join(names, ", ")));
  for (const std::string& name : names)
    if (std::any_of(patterns.begin(), patterns.end(), [&](const std::string& pattern) {
          return fnmatch(pattern.c_str(), name.c_str(), 0) == 0;
        }))
      chosen.push_back(name);
  return chosen;
}

int sample_number(const std::string& part_name) {
  if (part_name.size() < 4 || part_name.size() > 5 || part_name[0] != 's') return -1;
  if (!std::all_of(part_name.begin() + 1, part_name.end(), [](char c) { return c >= '0' && c <= '9'; }))
    return -1;
  return std::stoi(part_name.substr(1));
}

void keep_first_samples(Frame& frame, int samples, const std::filesystem::path& file) {
  require_samples(file.string(), frame.spp, samples);
  if (samples == 0) return;
  frame.spp = samples;
  const size_t kept = static_cast<size_t>(samples) * frame.plane_size();
  frame.samples.resize(kept * static_cast<size_t>(frame.channels));
  frame.valid.resize(kept);
  if (!frame.alpha.empty()) frame.alpha.resize(kept);
  for (LightPart& part : frame.parts) part.samples.resize(3 * kept);
}

std::string misnamed_text(const FrameHeader& header) {
  return fmt::format(
      "part '{}' looks like a sample, but samples are named s000, s001, ..., with three digits or more; name "
      "the parts so, or import the file with a mapping whose patterns have {{sample}} (docs/import.md)",
      header.misnamed);
}

FrameHeader read_frame_header(const std::filesystem::path& path) {
  const ExrReader exr(path);
  FrameHeader header = header_of(exr, sample_parts(exr));
  header.derivable = derivable_features(path, header.features, header.info);
  return header;
}

Frame read_frame(const std::filesystem::path& path, const std::vector<std::string>& required, Faults& faults,
                 int samples, int threads, const std::vector<std::string>& also) {
  const ExrReader exr(path);
  std::vector<int> parts = sample_parts(exr);
  const FrameHeader header = header_of(exr, parts);
  if (!header.misnamed.empty()) fail("{}: no samples: {}", exr.path(), misnamed_text(header));
  if (header.spp == 0)
    fail(
        "{}: no samples (parts s000, s001, ...): its first part holds {}; if it is one of several renders of "
        "the same picture, each "
        "with a seed of its own, give them all with --preset or --mapping; else render so",
        exr.path(), exr.channel_list(0));
  require_samples(exr.path(), header.spp, samples);
  if (samples > 0) parts.resize(static_cast<size_t>(samples));
  std::vector<std::string> read = required, derived;
  for (const std::string& name : derivable_features(path, header.features, header.info))
    if (const auto wanted = std::find(read.begin(), read.end(), name); wanted != read.end()) {
      derived.push_back(name);
      read.erase(wanted);
    }
  require_features(exr, parts, read);

  Frame frame(header.width, header.height, static_cast<int>(parts.size()),
              derived.empty() ? frame_channels(header.features) : kAllChannels);
  frame.info = header.info;
  frame.features = header.features;
  if (header.alpha) frame.alpha.resize(frame.valid.size());
  for (const std::string& name : choose_names(header.layers, also, exr.path())) frame.add_part(name);
  std::vector<ExrPartPlanes> wanted;
  for (int s = 0; s < frame.spp; ++s) {
    const int part = parts[static_cast<size_t>(s)];
    std::vector<ExrPlane> planes;
    for (const std::string& name : header.features) {
      const Feature& feature = find_feature(name);
      for (int c = 0; c < feature.channels; ++c) {
        const char* channel = feature.exr_channels[static_cast<size_t>(c)];
        exr.require_channel(part, channel, "");
        planes.push_back({channel, frame.plane(s, feature.offset + c), frame.plane_size()});
      }
    }
    if (header.alpha) {
      exr.require_channel(part, "A", "");
      planes.push_back(
          {"A", frame.alpha.data() + static_cast<size_t>(s) * frame.plane_size(), frame.plane_size()});
    }
    for (size_t light = 0; light < frame.parts.size(); ++light)
      for (int c = 0; c < 3 && !frame.holds(frame.parts[light].name); ++c) {
        const std::string channel = frame.parts[light].name + "." + "RGB"[c];
        exr.require_channel(part, channel, "");
        planes.push_back({channel, frame.part_plane(light, s, c), frame.plane_size()});
      }
    wanted.push_back({part, std::move(planes)});
  }
  // Rows are mended by who has decoded them, while they are in the cache.
  faults = {};
  std::mutex faults_mutex;
  exr.read_parts(wanted, threads, [&](size_t s, int row, int rows) {
    const auto width = static_cast<size_t>(frame.width);
    Faults found;
    sanitise(frame, static_cast<int>(s), static_cast<size_t>(row) * width, static_cast<size_t>(rows) * width,
             found);
    const std::lock_guard<std::mutex> lock(faults_mutex);
    faults.negative += found.negative;
    faults.not_finite += found.not_finite;
    faults.guides += found.guides;
    faults.parts += found.parts;
  });
  copy_features_to_parts(frame);
  faults.clamped = frame.info.clamped;
  if (frame.info.depth_scale <= 0) frame.info.depth_scale = median_depth(frame, threads);
  for (const std::string& name : derived) add_derived(frame, name, path);
  return frame;
}

}  // namespace ld
