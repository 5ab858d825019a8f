// Pictures that follow one another as a film: MP4 and WebM by the program ffmpeg, where it is installed.
#pragma once

#include <filesystem>
#include <functional>

#include "frame/frame.h"

namespace ld {

/// A picture of this project as linear radiance [3, H, W]: of .exr as read_image() has it, of .png what its
/// tone map (eq. 7 of [MH20]) takes to its values. Throws Error as reading does.
Image read_shown_picture(const std::filesystem::path& path);

/// Throws UsageError unless the name ends in .mp4 or .webm, in capitals or not; `option` is for the
/// complaint.
void require_movie_name(const std::string& option, const std::filesystem::path& path);

/// Writes the pictures of one size, linear radiance through the tone map, as H.264 or VP9, close to lossless
/// to the eye, odd sizes filled up to even ones by black; atomic. Where there is no ffmpeg, the pictures
/// become 000000.png, 000001.png, ... in a folder of the film's name without its extension. Returns what was
/// written. Throws UsageError for another extension; Error for a picture of another size than the first, none
/// at all, and what ffmpeg complains of.
std::filesystem::path write_movie(const std::filesystem::path& path, double frames_a_second, size_t count,
                                  const std::function<Image(size_t)>& picture);

}  // namespace ld
