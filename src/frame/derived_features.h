// Features that a frame's file may lack because they follow from what lies beside it: what super-resolution
// reads.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "frame/frame.h"

namespace ld {

/// NAME.half.exr of NAME.exr: samples of the same view at half the width and height, rounded up, of random
/// numbers of their own (recipe key `half_radiance`).
std::filesystem::path half_companion(const std::filesystem::path& frame);

/// Of the features that are not `held`, in the order of the schema, those that add_derived() can make for a
/// frame with such an info: "half_radiance" where there is a companion, "position" where the frame holds
/// depth and says where its camera stood and what it saw (FrameInfo::world_to_camera, world_to_ndc).
std::vector<std::string> derivable_features(const std::filesystem::path& frame,
                                            const std::vector<std::string>& held, const FrameInfo& info);

/// Makes such a feature of a frame that has room for it (kAllChannels), and adds it to those that it holds.
/// Radiance of half resolution is that of the companion's sample of the same number, the mean of its others
/// where that one does not count, at each pixel of 2x2. A position is the pixel's centre at the sample's
/// depth, which is as far as `depth` goes: the place on the pixel and the lens are not known. Throws Error
/// for a companion that is missing, damaged, of another size or with fewer samples.
void add_derived(Frame& frame, const std::string& feature, const std::filesystem::path& path);

}  // namespace ld
