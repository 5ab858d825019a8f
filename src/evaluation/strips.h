// Pictures side by side, for the eye: noisy | blur | each model | reference.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "evaluation/evaluator.h"
#include "frame/frame.h"

namespace ld {

/// Whether frame number `frame` of `count` is among `chosen` ones that are spread evenly over them.
bool is_evenly_chosen(size_t frame, size_t count, size_t chosen);

/// The pictures from left to right with separators of 2 pixels and, where a font is found, their labels
/// above. Linear radiance, NaN shown as magenta. All pictures [3, H, W] of one size. Throws Error otherwise,
/// or when there is none.
Image make_strip(const std::vector<LabelledPicture>& pictures);

/// Strips below one another, separated likewise; narrower ones are filled up with the separators' grey.
Image stack_strips(const std::vector<Image>& strips);

/// Writes FOLDER/strips/NAME.png for every frame and, at the end, FOLDER/comparison.png with up to four of
/// them, spread evenly over the set.
class StripWriter {
 public:
  StripWriter(std::filesystem::path folder, size_t frame_count);

  /// For EvaluatorOptions::on_pictures. Throws Error when the file cannot be written.
  void add(size_t frame, const std::string& name, const std::vector<LabelledPicture>& pictures);
  /// Of a frame's strip.
  std::filesystem::path path_of(const std::string& name) const {
    return folder_ / "strips" / (name + ".png");
  }
  /// Writes the comparison; returns its path.
  std::filesystem::path finish() const;

 private:
  std::filesystem::path folder_;
  size_t frame_count_;
  std::vector<Image> chosen_;
};

}  // namespace ld
