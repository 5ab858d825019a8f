#include "evaluation/image_folder.h"

#include "core/error.h"
#include "core/file_io.h"
#include "core/json_text.h"
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

Image read_picture(const fs::path& path, int width, int height) {
  const ExrReader exr(path);
  if (exr.width(0) != width || exr.height(0) != height)
    fail("{} is {}x{}, the frame {}x{}; denoise the frame at its own size", path.string(), exr.width(0),
         exr.height(0), width, height);
  return read_rgb(exr);
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
  method.read = [folder](const std::string& frame, int width, int height) {
    return read_picture(picture_path(folder, frame), width, height);
  };
  return method;
}

}  // namespace ld
