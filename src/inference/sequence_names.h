// Which files make which pictures: single frames, lists of them, numbered sequences.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sequence/sequence_state.h"

namespace ld {

/// Frames first to last - 1.
struct FrameRange {
  int64_t first = 0, last = 0;
};

/// "A:B". Throws UsageError.
FrameRange parse_frame_range(const std::string& text);

/// Inputs with * ? [ in their names, for those whose shell leaves them as they are, replaced by the files
/// that fit, sorted; names of files that are there stay. Throws UsageError where nothing fits.
std::vector<std::string> expand_names(const std::vector<std::string>& inputs);

/// The file of the first picture that is there; empty where there is none.
std::filesystem::path first_file(const std::vector<std::string>& inputs,
                                 const std::optional<FrameRange>& range);

/// One picture to make.
struct DenoiseTask {
  std::vector<std::filesystem::path> inputs;  // files of its samples
  std::filesystem::path output;
  std::optional<SequencePlace> place = {};  // which #### and the frame's number; none: a still
};

/// `####` in the name of an input (not of its folder) stands for the frame's number in at least so many
/// digits; the frames are those of `range`, else those that there are files of, of every such input. Inputs
/// without it are pictures of their own, or, with `samples_of_one`, the samples of one: then each input names
/// one or more files of every picture. `output` is a file for one picture, may have #### too, and is a folder
/// for several pictures, which are then named like their first input. Sequence by sequence, each in the order
/// of its frames.
///
/// Throws UsageError: patterns beside plain names, a range without a pattern, no number to tell pictures
/// apart, two pictures with one output, an output that is an input.
std::vector<DenoiseTask> plan_tasks(const std::vector<std::string>& inputs, const std::string& output,
                                    const std::optional<FrameRange>& range, bool samples_of_one);

}  // namespace ld
