#include "evaluation/data_set.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "core/error.h"
#include "core/log.h"
#include "frame/frame_file.h"
#include "frame/manifest.h"

namespace ld {
namespace {

void warn_about_faults(const std::string& path, const Faults& faults, const std::string& reference,
                       int64_t bad) {
  if (faults.any())
    spdlog::warn("{}: {} samples with NaN or infinite channels masked out, {} negative radiances set to 0",
                 path, faults.not_finite, faults.negative);
  if (bad > 0)
    spdlog::warn("{}: {} NaN, infinite or negative values set to 0; scores against it are doubtful",
                 reference, bad);
}

}  // namespace

FrameSet open_frame_set(const std::filesystem::path& folder, const std::string& split,
                        const std::vector<std::string>& features, size_t limit) {
  std::vector<ManifestFrame> frames = frames_of_split(folder, split);
  if (limit > 0 && frames.size() > limit) frames.resize(limit);

  const size_t count = frames.size();
  const auto checked = std::make_shared<std::vector<bool>>(count, false);
  const auto load = [folder, features, checked, frames = std::move(frames)](size_t i) {
    const std::filesystem::path path = frame_path(folder, frames[i].name);
    const std::filesystem::path reference = reference_path(folder, frames[i].name);
    Faults faults;
    int64_t bad = 0;
    EvaluationFrame frame{frames[i].name, read_frame(path, features, faults), read_image(reference, &bad)};
    if (frame.frame.width != frame.reference.width || frame.frame.height != frame.reference.height)
      fail(
          "{} is {}x{} but its reference {} is {}x{}; both must show the same picture: render one of them "
          "again",
          path.string(), frame.frame.width, frame.frame.height, reference.string(), frame.reference.width,
          frame.reference.height);
    if (!(*checked)[i]) {
      // After the complaints above, which say more than that a checksum differs.
      verify_frame(folder, frames[i]);
      warn_about_faults(path.string(), faults, reference.string(), bad);
      (*checked)[i] = true;
    }
    return frame;
  };
  return {count, load};
}

}  // namespace ld
