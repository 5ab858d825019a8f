// Event files that TensorBoard shows: TFRecord files of Event messages
// (https://github.com/tensorflow/tensorboard, tensorboard/compat/proto/event.proto and summary.proto),
// written without TensorFlow and without LibTorch.
//
// The one kind of file of this project that carries the time of day: TensorBoard's "relative" and "wall" axes
// are made of it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "frame/frame.h"

namespace ld {

/// Appends to a file of its own, FOLDER/events.out.tfevents.000001 for the first start of a run, .000002 for
/// the next. Each record is written whole at once, so TensorBoard may watch the file as it grows. All throw
/// Error when it cannot be written, having cut it back to its last whole record: the caller may go on and try
/// again with later values.
class EventFile {
 public:
  /// `step`: steps done so far. What earlier files hold of later steps, which a resumed run does again, is
  /// dropped by TensorBoard.
  EventFile(const std::filesystem::path& folder, int64_t step);
  ~EventFile();
  EventFile(const EventFile&) = delete;
  EventFile& operator=(const EventFile&) = delete;

  void scalar(int64_t step, const std::string& tag, double value);
  /// 1 or 3 channels, linear radiance; shown with the tone map (eq. 7 of [MH20]).
  void image(int64_t step, const std::string& tag, const Image& image);

  const std::filesystem::path& path() const { return path_; }

 private:
  void append(const std::string& event);

  std::filesystem::path path_;
  int file_ = -1;
  int64_t whole_ = 0;  // bytes of whole records
};

}  // namespace ld
