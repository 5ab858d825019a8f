// The classical filters as denoisers of frames: no weights, a frame in and a picture out.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "filters/antialias.h"
#include "filters/eaw.h"
#include "filters/frame_guides.h"
#include "filters/svgf.h"
#include "sequence/sequence_state.h"

namespace ld {

/// What SVGF keeps from frame to frame.
struct TemporalState {
  SvgfState light;
  AntialiasState picture;
};

/// "eaw" and "svgf".
std::vector<std::string> filter_kinds();

/// "NAME=KIND", or "KIND" for both, of a command line, and the settings meant for it.
struct FilterArgument {
  std::string name, kind;
  std::vector<std::string> assignments;  // "key=value"
};

/// `arguments` as above; `assignments` are "NAME.key=value" and those for none of the names are left in them.
/// Throws UsageError for another kind or a name given twice.
std::vector<FilterArgument> parse_filter_arguments(const std::vector<std::string>& arguments,
                                                   std::vector<std::string>& assignments);

class FrameFilter {
 public:
  /// Throws UsageError for an unknown kind or key and for a value out of range.
  explicit FrameFilter(const FilterArgument& argument);

  bool is_temporal() const { return kind_ == "svgf"; }

  /// Linear radiance [3, H, W] of a sanitised frame (read_frame and import_frame do) of any size. What the
  /// frame lacks is replaced (filters/frame_guides.h) and named in the log, each thing once. The state's
  /// memory is a TemporalState. Neither threads nor what was denoised before, the state aside, change a bit.
  /// Not for several threads at once.
  Image denoise(const Frame& frame, SequenceState& state, int threads);

  const std::string& kind() const { return kind_; }
  /// The kind and the settings that were given: "svgf", "eaw (levels=3)".
  std::string description() const;

 private:
  void tell(const std::vector<std::string>& lines);

  std::string kind_;
  std::vector<std::string> assignments_;
  EawSettings eaw_;
  SvgfSettings svgf_;
  // Memory that is kept from frame to frame for its own sake.
  Surfaces surfaces_;
  Illumination light_;
  RowPlanes picture_, spare_;
  SvgfMemory memory_;
  std::vector<std::string> told_;
};

}  // namespace ld
