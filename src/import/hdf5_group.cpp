#include "import/hdf5_group.h"

#include <algorithm>

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
