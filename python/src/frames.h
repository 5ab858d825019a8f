// Frames and pictures on disk, as Python reads and writes them.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <string>
#include <vector>

namespace ld {

/// (samples, valid, alpha, depth scale, parts) of a frame of this project: a dict of arrays [samples, height,
/// width, channels] by feature, arrays [samples, height, width] of valid samples and of alpha (None where the
/// file has none), and a dict of arrays [samples, height, width, 3] of the light parts that a pattern of
/// `also` fits. The arrays look into the frame's memory; nothing is copied.
nanobind::tuple read_frame_arrays(const std::string& path, int samples, int threads,
                                  const std::vector<std::string>& also);

/// [height, width, 3].
nanobind::ndarray<nanobind::numpy, float, nanobind::ndim<3>> read_image_array(const std::string& path);

/// [channels, height, width].
using PlanarArray =
    nanobind::ndarray<const float, nanobind::ndim<3>, nanobind::c_contig, nanobind::device::cpu>;

/// EXR or PNG by the extension. In a PNG, values that are not finite or below zero are black.
void write_image_array(const std::string& path, const PlanarArray& planes);

}  // namespace ld
