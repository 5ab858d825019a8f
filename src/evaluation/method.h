// What is evaluated besides the baselines: a name and a function, so that the library knows no inference.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "evaluation/scores.h"
#include "frame/frame.h"
#include "frame/picture_place.h"
#include "sequence/sequence_state.h"

namespace ld {

struct Method {
  std::string name;
  /// Linear radiance [3, H, W] of the frame's size. The state has been told of the frame; its memory is the
  /// method's.
  std::function<Image(const Frame&, SequenceState&)> denoise;
  MethodCost cost = {};
  /// Instead of `denoise`: the picture that another program made of the frame of this name, cut to its place.
  std::function<Image(const std::string& frame, const PicturePlace& place)> read = {};
  std::map<std::string, double> seconds = {};  // what that program noted for each frame
};

/// "NAME=FILE" or "NAME=DIR" of a command line.
struct ModelArgument {
  std::string name, file;
};

/// Throws UsageError for an argument without "=", an empty name or file, and for a bad name (see
/// check_method_names).
std::vector<ModelArgument> parse_model_arguments(const std::vector<std::string>& arguments);

/// The same for any option: `option` ("--images") and `example` ("oidn=out/oidn") are for the complaints.
std::vector<ModelArgument> parse_named_arguments(const std::string& option, const std::string& example,
                                                 const std::vector<std::string>& arguments);

/// Throws UsageError for a name that is empty, given twice, `noisy`, `blur` or `reference` (the tables and
/// pictures use those), or that holds a control character.
void check_method_names(const std::vector<std::string>& names);

/// Throws UsageError when the name of a baseline is neither "" (the default), `noisy`, `blur` nor one of the
/// methods.
void check_baseline(const std::string& baseline, const std::vector<Method>& methods);

}  // namespace ld
