#include "import/hdf5_group.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <tuple>

#include "core/error.h"

namespace ld {
namespace {

/// Calls visit(plane of the frame, offset of that plane within a frame of the group).
template <class Visit>
void for_each_plane(Frame& frame, const Hdf5Group& group, const Visit& visit) {
  const size_t pixels = frame.plane_size();
  size_t offset = 0;
  for (int s = 0; s < frame.spp; ++s)
    for (const std::string& name : features_of(group)) {
      const Feature& feature = find_feature(name);
      for (int c = 0; c < feature.channels; ++c, offset += pixels)
        visit(frame.plane(s, feature.offset + c), offset);
    }
}

}  // namespace

namespace {

constexpr const char *kStoredWorldToCamera = "world_to_camera", *kStoredWorldToNdc = "world_to_ndc",
                     *kCut = "cut";

std::unique_ptr<Hdf5Data> open_numbers(const Hdf5File& file, const char* name,
                                       const std::vector<uint64_t>& dimensions) {
  if (!file.has(name)) return nullptr;
  std::unique_ptr<Hdf5Data> data = file.data(name, dimensions.size());
  require_shape(*data, dimensions);
  return data;
}

void write_matrix(const std::unique_ptr<Hdf5Data>& data, uint64_t i, const std::optional<Matrix4>& matrix,
                  const std::string& frame) {
  if (!data) return;
  if (!matrix)
    fail("{}: {} has no such matrix, but the first frame has; expected it in all or none", data->where,
         frame);
  data->write_frame(i, {matrix->begin(), matrix->end()});
}

std::optional<Matrix4> read_matrix(const std::unique_ptr<Hdf5Data>& data, uint64_t i) {
  if (!data) return std::nullopt;
  std::vector<float> values;
  data->read_frame(i, values);
  Matrix4 matrix;
  std::copy_n(values.begin(), matrix.size(), matrix.begin());
  return matrix;
}

}  // namespace

void require_shape(const Hdf5Data& data, const std::vector<uint64_t>& expected) {
  if (data.dimensions != expected)
    fail("{}: of the shape [{}]; expected [{}]", data.where, fmt::join(data.dimensions, ", "),
         fmt::join(expected, ", "));
}

Hdf5Cameras Hdf5Cameras::make(const Hdf5File& file, const FrameHeader& first, uint64_t frames) {
  Hdf5Cameras cameras;
  const auto& [to_camera, to_ndc] = std::tie(first.info.world_to_camera, first.info.world_to_ndc);
  if (to_camera) cameras.world_to_camera = file.make(kStoredWorldToCamera, {frames, 16}, true);
  if (to_ndc) cameras.world_to_ndc = file.make(kStoredWorldToNdc, {frames, 16}, true);
  if (to_camera || to_ndc) cameras.cut = file.make(kCut, {frames}, true);
  return cameras;
}

Hdf5Cameras Hdf5Cameras::open(const Hdf5File& file, uint64_t frames) {
  return {open_numbers(file, kStoredWorldToCamera, {frames, 16}),
          open_numbers(file, kStoredWorldToNdc, {frames, 16}), open_numbers(file, kCut, {frames})};
}

void Hdf5Cameras::write(uint64_t i, const FrameInfo& info, const std::string& name) const {
  write_matrix(world_to_camera, i, info.world_to_camera, name);
  write_matrix(world_to_ndc, i, info.world_to_ndc, name);
  if (cut) cut->write_frame(i, {info.cut ? 1.0F : 0.0F});
}

void Hdf5Cameras::read(uint64_t i, FrameInfo& info) const {
  info.world_to_camera = read_matrix(world_to_camera, i);
  info.world_to_ndc = read_matrix(world_to_ndc, i);
  std::vector<float> values;
  if (cut) cut->read_frame(i, values);
  info.cut = !values.empty() && values[0] != 0;
}

std::vector<std::string> features_of(const Hdf5Group& group) {
  std::vector<std::string> features;
  for (const char* feature : group.features)
    if (feature != nullptr) features.emplace_back(feature);
  return features;
}

void OpenGroup::read(uint64_t i, Frame& frame, std::vector<float>& values) const {
  data->read_frame(i, values);
  for_each_plane(frame, *layout, [&](float* plane, size_t offset) {
    std::copy_n(values.data() + offset, frame.plane_size(), plane);
  });
}

void OpenGroup::write(uint64_t i, Frame& frame, std::vector<float>& values) const {
  values.resize(data->frame_values());
  for_each_plane(frame, *layout, [&](const float* plane, size_t offset) {
    std::copy_n(plane, frame.plane_size(), values.data() + offset);
  });
  data->write_frame(i, values);
}

}  // namespace ld
