#include "evaluation/image_folder.h"

#include "core/error.h"
#include "core/file_io.h"
#include "core/json_text.h"
#include "core/log.h"
#include "frame/exr_reader.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

fs::path picture_path(const fs::path& folder, const std::string& frame) {
  return folder / (frame + ".exr");
}

/// What is said about a file that is missing: pictures of other formats are a likely reason.
std::string advice(const fs::path& folder, const std::string& frame) {
  for (const char* extension : {".png", ".jpg", ".jpeg", ".tif", ".tiff", ".hdr", ".pfm"})
    if (fs::exists(folder / (frame + extension)))
      return fmt::format(
          "{}{} is there, but the metrics need linear radiance: write OpenEXR, before any tone map", frame,
          extension);
  return "expected one OpenEXR file for each frame, named after it";
}

Image read_picture(const fs::path& path, const std::string& frame, const PicturePlace& place) {
  const ExrReader exr(path);
  const PicturePlace own = place_of(exr, picture_part(exr));
  if (!same_colours(own, place))
    spdlog::warn(
        "{}: its chromaticities are others than the frame's; nothing was converted, so its scores are "
        "doubtful",
        path.string());
  return cut_to(read_rgb(exr), own.extent, path.string(), place.extent, "'" + frame + "'");
}

std::map<std::string, double> read_seconds(const fs::path& path) {
  if (!fs::exists(path)) return {};
  const nlohmann::json json = parse_json(read_file(path, 1 << 24), path.string());
  try {
    return json.at("seconds").get<std::map<std::string, double>>();
  } catch (const nlohmann::json::exception& error) {
    fail("{}: expected {{\"seconds\": {{FRAME: s, ...}}}}: {}", path.string(), error.what());
  }
}

}  // namespace

Method image_folder_method(const std::string& name, const fs::path& folder,
                           const std::vector<std::string>& frames) {
  if (!fs::is_directory(folder)) fail("--images {}={}: no such folder", name, folder.string());
  std::vector<std::string> missing;
  for (const std::string& frame : frames)
    if (!fs::is_regular_file(picture_path(folder, frame))) missing.push_back(frame);
  if (!missing.empty())
    fail("--images {}: {} is missing ({} of {} frames have no picture); {}", name,
         picture_path(folder, missing.front()).string(), missing.size(), frames.size(),
         advice(folder, missing.front()));

  Method method;
  method.name = name;
  method.seconds = read_seconds(folder / "cost.json");
  method.read = [folder](const std::string& frame, const PicturePlace& place) {
    return read_picture(picture_path(folder, frame), frame, place);
  };
  return method;
}

}  // namespace ld
