// From another renderer's conventions to those of docs/data_format.md, for whole planes.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "frame/frame.h"
#include "import/mapping.h"
#include "import/view_camera.h"

namespace ld {

struct ConversionCounts {
  int64_t above_maximum = 0;  // colour channels set to the mapping's maximum
  int64_t beyond_half = 0;    // depths that count as escaped because half floats do not reach them
};

/// Whether the feature comes in a form that takes the camera, or its field of view, to convert.
bool needs_camera(const FeatureMapping& mapping);
bool needs_fov(const FeatureMapping& mapping);

class Converter {
 public:
  /// `camera`, where there is one, is checked against the picture's size. Throws UsageError.
  Converter(int width, int height, const Windows& windows, std::optional<ViewCamera> camera);

  /// Converts the channels of a feature as the file holds them, [mapping.components()][height * width], to
  /// planes as the schema has them. Throws UsageError where a camera is needed and missing.
  std::vector<std::vector<float>> convert(const FeatureMapping& mapping,
                                          std::vector<std::vector<float>> channels);

  const ConversionCounts& counts() const { return counts_; }

 private:
  using Planes = std::vector<std::vector<float>>;

  const ViewCamera& need_camera(const FeatureMapping& mapping, const std::string& what) const;
  double need_fov(const FeatureMapping& mapping, const std::string& what) const;
  Imath::V3d ray_of(size_t pixel, double fov) const;
  void normals(const FeatureMapping& mapping, Planes& planes) const;
  Planes depth(const FeatureMapping& mapping, const Planes& raw, const Planes& scaled);
  double depth_at(const FeatureMapping& mapping, const Planes& scaled, size_t pixel) const;
  void movement(const FeatureMapping& mapping, Planes& planes) const;

  int width_;
  Windows windows_;
  Picture picture_;
  std::optional<ViewCamera> camera_;
  ConversionCounts counts_;
};

}  // namespace ld
