#include "frame/sample_arrays.h"

#include <algorithm>

#include "frame/colour_rows.h"

namespace ld {
namespace {

/// Planes [channels], `pitch` floats apart.
void copy_planes(const float* from, const StridedArray& strides, int channels, size_t count, float* to,
                 size_t pitch) {
  if (channels == 3 && strides.channel == 1 && strides.pixel == 3)  // the rule
    return split_colours(from, count, {to, to + pitch, to + 2 * pitch});
  for (int c = 0; c < channels; ++c, from += strides.channel, to += pitch)
    if (strides.pixel == 1)
      std::copy_n(from, count, to);
    else
      for (size_t x = 0; x < count; ++x) to[x] = from[static_cast<ptrdiff_t>(x) * strides.pixel];
}

}  // namespace

Frame SampleArrays::make_frame(int pixels, int rows, int samples) const {
  std::vector<std::string> names;
  for (const OfFeature& held : features) names.push_back(held.feature->name);
  Frame frame(pixels, rows, samples, frame_channels(names));
  frame.features = std::move(names);
  for (size_t part = 0; part < parts.size(); ++part) frame.add_part("");
  if (alpha) frame.alpha.resize(frame.valid.size());
  return frame;
}

void SampleArrays::copy(const SamplePlace& place, Frame& to, int to_sample, size_t first) const {
  const auto count = static_cast<size_t>(place.count);
  const auto copy_array = [&](const StridedArray& array, int channels, float* plane) {
    const float* from =
        array.data + place.sample * array.sample + place.y * array.row + place.x * array.pixel;
    copy_planes(from, array, channels, count, plane + first, to.plane_size());
  };
  for (const OfFeature& held : features)
    copy_array(held.array, held.feature->channels, to.plane(to_sample, held.feature->offset));
  for (size_t part = 0; part < parts.size(); ++part)
    copy_array(parts[part], 3, to.part_plane(part, to_sample, 0));
  if (alpha) copy_array(*alpha, 1, to.alpha.data() + static_cast<size_t>(to_sample) * to.plane_size());
  uint8_t* const drawn = to.valid_plane(to_sample) + first;
  if (valid == nullptr) {
    std::fill_n(drawn, count, uint8_t{1});
  } else {
    const size_t row =
        static_cast<size_t>(place.sample) * static_cast<size_t>(height) + static_cast<size_t>(place.y);
    std::transform(valid + row * static_cast<size_t>(width) + place.x,
                   valid + row * static_cast<size_t>(width) + place.x + place.count, drawn,
                   [](uint8_t given) { return static_cast<uint8_t>(given != 0); });
  }
  Faults faults;
  sanitise(to, to_sample, first, count, faults);
}

bool SampleArrays::any_valid() const {
  Frame row = make_frame(width);
  for (int s = 0; s < spp; ++s)
    for (int y = 0; y < height; ++y) {
      copy({s, y, 0, width}, row);
      if (std::any_of(row.valid.begin(), row.valid.end(), [](uint8_t drawn) { return drawn != 0; }))
        return true;
    }
  return false;
}

}  // namespace ld
