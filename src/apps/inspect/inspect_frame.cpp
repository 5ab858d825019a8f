#include <algorithm>

#include "apps/inspect/inspect.h"
#include "core/error.h"
#include "doctor/doctor.h"
#include "frame/frame_file.h"

namespace ld {
namespace {

/// Mean over the pixels, in double; [R, G, B].
nlohmann::ordered_json mean_of(const Image& image) {
  nlohmann::ordered_json means = nlohmann::ordered_json::array();
  for (int c = 0; c < image.channels; ++c) {
    double sum = 0;
    for (size_t p = 0; p < image.plane_size(); ++p) sum += static_cast<double>(image.plane(c)[p]);
    means.push_back(sum / static_cast<double>(image.plane_size()));
  }
  return means;
}

void add_info(Report& report, const FrameInfo& info) {
  auto& facts = report.facts;
  if (!info.generator.empty()) facts["generator"] = info.generator;
  if (!info.scene.empty()) facts["scene"] = info.scene;
  if (!info.camera.empty()) facts["camera"] = info.camera;
  facts["seed"] = info.seed;
  facts["frame"] = info.frame;
}

void inspect_image(Report& report) {
  report.attempt([&] {
    int64_t bad = 0;
    const Image image = read_image(report.path, &bad);
    report.facts["mean"] = mean_of(image);
    report.facts["largest"] = *std::max_element(image.pixels.begin(), image.pixels.end());
    report.facts["bad_channels"] = bad;
    if (bad > 0)
      report.warnings.push_back(
          fmt::format("{} channels of pixels are NaN, infinite or negative; they are read as 0", bad));
  });
}

void inspect_samples(Report& report) {
  report.attempt([&] {
    const Evidence evidence = read_evidence(report.path);
    const Frame& frame = evidence.frame;
    report.facts["mean_radiance"] = mean_of(mean_radiance(frame));
    report.facts["depth_scale"] = frame.info.depth_scale;
    report.facts["samples"] = frame.valid.size();
    report.facts["masked_samples"] = std::count(frame.valid.begin(), frame.valid.end(), uint8_t{0});
    report.facts["negative_channels"] = evidence.faults.negative;
    report.facts["clamped_channels"] = evidence.faults.clamped;
    report.facts["reference"] = evidence.reference ? "beside it" : "none beside it";
    report.add(examine_frame(evidence));
  });
}

}  // namespace

void inspect_exr(Report& report) {
  report.kind = "OpenEXR file";
  FrameHeader header;
  report.attempt([&] { header = read_frame_header(report.path); });
  if (!report.problems.empty()) return;
  report.kind = header.spp > 0 ? "frame" : "image";
  report.facts["width"] = header.width;
  report.facts["height"] = header.height;
  report.facts["spp"] = header.spp;
  if (header.spp == 0) {
    if (!header.misnamed.empty()) report.problems.push_back(misnamed_text(header));
    inspect_image(report);
    return;
  }
  report.facts["features"] = header.features;
  nlohmann::ordered_json missing = nlohmann::ordered_json::array();
  for (const std::string& name : mh20_feature_names())
    if (std::find(header.features.begin(), header.features.end(), name) == header.features.end())
      missing.push_back(name);
  report.facts["missing_features"] = missing;
  if (!header.layers.empty()) report.facts["layers"] = header.layers;
  if (!missing.empty())
    report.warnings.push_back(
        "features are missing; only models that do without them can denoise this frame");
  add_info(report, header.info);
  inspect_samples(report);
}

}  // namespace ld
