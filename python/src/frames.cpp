#include "frames.h"

#include <nanobind/stl/vector.h>

#include <algorithm>
#include <memory>

#include "arrays.h"
#include "core/threads.h"
#include "frame/frame_file.h"

namespace nb = nanobind;

namespace ld {

nb::tuple read_frame_arrays(const std::string& path, int samples, int threads,
                            const std::vector<std::string>& also) {
  auto frame = std::make_unique<Frame>();
  {
    const nb::gil_scoped_release unlocked;
    Faults faults;
    *frame = read_frame(path, {}, faults, samples, threads > 0 ? threads : default_threads(), also);
  }
  Frame& held = *frame;
  const nb::capsule owner = capsule_of(std::move(frame));
  const size_t shape[4] = {size_t(held.spp), size_t(held.height), size_t(held.width), 0};
  const int64_t plane = int64_t(held.plane_size());
  nb::dict arrays;
  for (const Feature& feature : feature_schema()) {
    if (!held.holds(feature.name)) continue;
    const size_t four[4] = {shape[0], shape[1], shape[2], size_t(feature.channels)};
    const int64_t strides[4] = {held.channels * plane, held.width, 1, plane};
    arrays[feature.name.c_str()] = nb::cast(
        nb::ndarray<nb::numpy, float, nb::ndim<4>>(held.plane(0, feature.offset), 4, four, owner, strides));
  }
  const nb::object valid =
      nb::cast(nb::ndarray<nb::numpy, uint8_t, nb::ndim<3>>(held.valid.data(), 3, shape, owner));
  nb::object alpha = nb::none();
  if (!held.alpha.empty())
    alpha = nb::cast(nb::ndarray<nb::numpy, float, nb::ndim<3>>(held.alpha.data(), 3, shape, owner));
  nb::dict parts;
  for (size_t part = 0; part < held.parts.size(); ++part) {
    const size_t four[4] = {shape[0], shape[1], shape[2], 3};
    const int64_t strides[4] = {3 * plane, held.width, 1, plane};
    parts[held.parts[part].name.c_str()] = nb::cast(
        nb::ndarray<nb::numpy, float, nb::ndim<4>>(held.part_plane(part, 0, 0), 4, four, owner, strides));
  }
  const auto numbers = [](const std::optional<Matrix4>& matrix) {
    return matrix ? std::vector<double>(matrix->begin(), matrix->end()) : std::vector<double>();
  };
  return nb::make_tuple(arrays, valid, alpha, held.info.depth_scale, parts,
                        numbers(held.info.world_to_camera), numbers(held.info.world_to_ndc));
}

nb::ndarray<nb::numpy, float, nb::ndim<3>> read_image_array(const std::string& path) {
  auto image = std::make_unique<Image>();
  {
    const nb::gil_scoped_release unlocked;
    *image = read_image(path);
  }
  Image& held = *image;
  const nb::capsule owner = capsule_of(std::move(image));
  const size_t shape[3] = {size_t(held.height), size_t(held.width), 3};
  const int64_t strides[3] = {held.width, 1, int64_t(held.plane_size())};
  return nb::ndarray<nb::numpy, float, nb::ndim<3>>(held.pixels.data(), 3, shape, owner, strides);
}

void write_image_array(const std::string& path, const PlanarArray& planes) {
  const nb::gil_scoped_release unlocked;
  Image image(int(planes.shape(2)), int(planes.shape(1)), int(planes.shape(0)));
  std::copy_n(planes.data(), image.pixels.size(), image.pixels.begin());
  if (picture_format(path) == PictureFormat::png) mend_image(image);  // bytes have no NaN
  write_image(path, image);
}

}  // namespace ld
