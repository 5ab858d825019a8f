// FLIP, the difference that an observer sees when two pictures are flipped back and forth: Andersson,
// Nilsson, Akenine-Moeller, Oskarsson, Astrom and Fairchild, "FLIP: A difference evaluator for alternating
// images", Proceedings of the ACM on Computer Graphics and Interactive Techniques 3(2), 2020 [A20]; for high
// dynamic range Andersson, Nilsson, Shirley and Akenine-Moeller, "Visualizing errors in rendered high dynamic
// range images", Eurographics Short Papers 2021 [A21].
#pragma once

#include <string>
#include <vector>

#include "frame/frame.h"

namespace ld {

/// An observer 0.7 m from a display that is 0.7 m wide and has 3840 pixels across: distance x pixels a metre
/// x one degree.
constexpr double kFlipPixelsPerDegree = 0.7 * (3840 / 0.7) * 3.14159265358979323846 / 180;

/// LDR-FLIP of the display values (tone map of eq. 7 of [MH20], clamped to [0, 1], taken as sRGB), the mean
/// of flip_map over the pixels: 0 equal, 1 the most. Domain and errors: metrics/image_pair.h.
double flip(const Image& denoised, const Image& reference);
std::string flip_formula();

/// HDR-FLIP: each pixel's largest LDR-FLIP over the exposures of flip_exposures(reference), both pictures
/// brought to [0, 1] by exposure and the ACES tone map; then the mean. Negative radiance counts as 0. Takes
/// as many times longer than flip() as there are exposures. Domain and errors: metrics/image_pair.h.
double hdr_flip(const Image& denoised, const Image& reference);
std::string hdr_flip_formula();

/// Section 4 of [A20] on two pictures of linear RGB in [0, 1], [3, height, width]: the error of each pixel,
/// in [0, 1]. Pixels outside of the pictures are those of the border.
std::vector<double> flip_map(const std::vector<double>& test, const std::vector<double>& reference, int width,
                             int height);

/// Evenly spaced exposures in stops.
struct FlipExposures {
  double start = 0, stop = 0;
  int count = 2;
};

/// Section 3 of [A21]: from where the brightest pixel of the reference, to where the one of median luminance
/// (the upper of two) is shown at 0.85, at most one stop apart. Luminance counts from 2^-23 on, so that black
/// has exposures, too.
FlipExposures flip_exposures(const Image& reference);

}  // namespace ld
