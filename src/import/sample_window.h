// Where samples lie whose parts have data windows of their own, as renderers write them that crop passes to
// what is in them.
#pragma once

#include <ImathBox.h>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "frame/picture_place.h"
#include "import/convert.h"
#include "import/source_plan.h"

namespace ld {

/// The data window of a frame: the smallest that holds the radiance of all its samples.
class FrameWindow {
 public:
  /// Throws Error: another display window than that of the samples before, a picture larger than can be.
  void add(const ExrReader& exr, const SourceSample& sample);

  Extent extent() const;

  /// Lines for users about features that lie in a smaller window than the frame's.
  std::vector<std::string> notes() const;

  /// Features of which no sample has a pixel in the frame.
  std::vector<std::string> elsewhere() const;

 private:
  void include(const Imath::Box2i& window, const std::string& path);

  std::string first_file_;
  Imath::Box2i display_, data_;
  std::map<std::string, std::vector<Imath::Box2i>> windows_;  // of each feature, a sample each
};

/// That of the frame that import_frame() makes of these files, from their headers.
Extent extent_of_files(const std::vector<std::filesystem::path>& files, const ImportMapping& mapping);

/// The feature's planes, converted, in the frame's data window. Where the file has no pixels of it, it is
/// what it is where a ray met nothing: the depth of a ray that escaped, else 0.
std::vector<std::vector<float>> read_feature(const ExrReader& exr, const SourceFeature& source,
                                             const Extent& frame, Converter& converter);

}  // namespace ld
