#include <algorithm>
#include <map>

#include "apps/inspect/inspect.h"
#include "core/error.h"
#include "core/progress.h"
#include "core/signals.h"
#include "core/threads.h"
#include "doctor/doctor.h"
#include "frame/frame_file.h"
#include "frame/manifest.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

struct FrameFinding {
  FrameHeader header;
  std::string problem;
};

/// Files, sizes and samples of one frame; its checksums with `verify`.
FrameFinding check_frame(const fs::path& folder, const ManifestFrame& entry, bool verify) {
  FrameFinding finding;
  try {
    ManifestFrame existence = entry;
    if (!verify) existence.checksum = existence.reference_checksum = "";
    verify_frame(folder, existence);
    finding.header = read_frame_header(frame_path(folder, entry.name));
    const FrameHeader reference = read_frame_header(reference_path(folder, entry.name));
    if (!finding.header.misnamed.empty())
      fail("{}: no samples: {}", frame_path(folder, entry.name).string(), misnamed_text(finding.header));
    if (finding.header.spp == 0)
      fail("{}: no samples, only means; expected parts s000, s001, ...",
           frame_path(folder, entry.name).string());
    if (reference.width != finding.header.width || reference.height != finding.header.height)
      fail("{}: {} x {} pixels, but its frame has {} x {}; render the two at one size",
           reference_path(folder, entry.name).string(), reference.width, reference.height,
           finding.header.width, finding.header.height);
  } catch (const Error& error) {
    finding.problem = error.what();
  }
  return finding;
}

std::vector<FrameFinding> check_frames(const fs::path& folder, const Manifest& manifest,
                                       const InspectOptions& options) {
  std::vector<FrameFinding> findings(manifest.frames.size());
  Progress progress(options.verify ? "checksums" : "headers", static_cast<int64_t>(findings.size()));
  parallel_for(static_cast<int64_t>(findings.size()), options.threads, [&](int64_t i) {
    if (stop_requested()) return;
    const auto index = static_cast<size_t>(i);
    findings[index] = check_frame(folder, manifest.frames[index], options.verify);
    progress.advance();
  });
  return findings;
}

void add_findings(Report& report, const Manifest& manifest, const std::vector<FrameFinding>& findings) {
  std::map<std::string, int> splits, sizes, features;
  int sound = 0;
  for (size_t i = 0; i < findings.size(); ++i) {
    ++splits[manifest.frames[i].split];
    const FrameHeader& header = findings[i].header;
    if (!findings[i].problem.empty()) {
      report.problems.push_back(findings[i].problem);
      continue;
    }
    ++sound;
    ++sizes[fmt::format("{} x {}, {} samples a pixel", header.width, header.height, header.spp)];
    for (const std::string& feature : header.features) ++features[feature];
  }
  report.facts["frames"] = manifest.frames.size();
  report.facts["splits"] = splits;
  report.facts["sizes"] = sizes;
  nlohmann::ordered_json everywhere = nlohmann::ordered_json::array();
  for (const std::string& name : feature_names()) {
    if (sound > 0 && features[name] == sound) everywhere.push_back(name);
    if (features[name] > 0 && features[name] < sound)
      report.warnings.push_back(
          fmt::format("only {} of {} frames hold the feature '{}'", features[name], sound, name));
  }
  report.facts["features"] = everywhere;
  if (manifest.frames.empty()) report.problems.push_back("the manifest lists no frames; render some");
}

}  // namespace

void inspect_dataset(Report& report, const InspectOptions& options) {
  report.kind = "data set";
  report.attempt([&] {
    const fs::path folder = report.path;
    const Manifest manifest = read_manifest(folder);
    const std::vector<FrameFinding> findings = check_frames(folder, manifest, options);
    report.facts["seed"] = manifest.seed;
    report.facts["recipe"] = manifest.recipe.empty() ? "none: frames from elsewhere" : "kept in the manifest";
    add_findings(report, manifest, findings);
    // Frames that are missing or cut short have been named; the doctor reads the others.
    Manifest sound = manifest;
    sound.frames.clear();
    for (size_t i = 0; i < findings.size(); ++i)
      if (findings[i].problem.empty()) sound.frames.push_back(manifest.frames[i]);
    if (!sound.frames.empty()) report.add(examine_dataset(folder, sound, {options.threads, options.frames}));

    const auto without =
        std::count_if(manifest.frames.begin(), manifest.frames.end(), [](const ManifestFrame& frame) {
          return frame.checksum.empty() || frame.reference_checksum.empty();
        });
    report.facts["frames_without_checksums"] = without;
    report.facts["checksums"] = options.verify ? "compared" : "not compared; --verify does";
  });
}

}  // namespace ld
