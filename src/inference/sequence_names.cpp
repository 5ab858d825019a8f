#include "inference/sequence_names.h"

#include <glob.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <charconv>
#include <set>

#include "core/error.h"
#include "core/file_identity.h"
#include "core/shown_text.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

constexpr int64_t kMostFrames = 1'000'000'000'000;  // either way from 0

/// A file name around its run of #.
struct NamePattern {
  fs::path folder;
  std::string before, after;
  size_t digits = 0;  // 0: a plain name

  explicit NamePattern(const std::string& text) : folder(fs::path(text).parent_path()) {
    const std::string name = fs::path(text).filename().string();
    const size_t at = name.find('#');
    before = name.substr(0, at);
    if (at == std::string::npos) return;
    const size_t end = std::min(name.find_first_not_of('#', at), name.size());
    digits = end - at;
    after = name.substr(end);
    if (after.find('#') != std::string::npos)
      fail_usage("'{}' has two places for a number; expected one run of #", text);
  }

  /// `length` is that of the number without its sign: digits that the name has beyond it are zeros in front.
  fs::path of(int64_t frame, size_t length) const {
    const std::string number = fmt::format("{:0{}}", frame < 0 ? -frame : frame, length);
    return folder / fmt::format("{}{}{}{}", before, frame < 0 ? "-" : "", number, after);
  }

  /// Renderers write frame -1 of #### as -0001 or as -001: the sign is one of the characters or is not. What
  /// is there counts.
  fs::path of(int64_t frame) const {
    if (digits == 0) return folder / before;
    const fs::path usual = of(frame, digits);
    if (frame >= 0 || digits < 2 || fs::exists(usual)) return usual;
    const fs::path shorter = of(frame, digits - 1);
    return fs::exists(shorter) ? shorter : usual;
  }

  /// The number in a file's name, if it is of this pattern.
  std::optional<int64_t> number_in(const std::string& name) const {
    if (name.size() < before.size() + after.size() + digits) return {};
    if (name.compare(0, before.size(), before) != 0 ||
        name.compare(name.size() - after.size(), after.size(), after) != 0)
      return {};
    const char* first = name.data() + before.size();
    const char* last = name.data() + name.size() - after.size();
    int64_t number = 0;
    const auto [stop, error] = std::from_chars(first, last, number);
    if (error != std::errc() || stop != last) return {};
    if (of(number, digits).filename() == name) return number;  // no more zeros in front than the pattern has
    if (number < 0 && digits > 1 && of(number, digits - 1).filename() == name) return number;
    return {};
  }

  /// Numbers of the files that there are.
  std::set<int64_t> present() const {
    std::set<int64_t> numbers;
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(folder.empty() ? fs::path(".") : folder, error))
      if (const std::optional<int64_t> number = number_in(entry.path().filename().string()))
        if (!numbers.insert(*number).second)
          spdlog::warn("two files of {}{:#>{}}{} are frame {}; {} is taken", before, "", digits, after,
                       *number, of(*number).filename().string());
    return numbers;
  }
};

std::vector<int64_t> frames_of(const std::vector<NamePattern>& patterns,
                               const std::optional<FrameRange>& range, const std::string& first_input) {
  std::vector<int64_t> frames;
  if (range) {
    for (int64_t frame = range->first; frame < range->last; ++frame) frames.push_back(frame);
    return frames;
  }
  std::set<int64_t> numbers;
  for (const NamePattern& pattern : patterns) numbers.merge(pattern.present());
  if (numbers.empty())
    fail("{}: no file of this pattern; # stands for a digit of the frame's number", first_input);
  return {numbers.begin(), numbers.end()};
}

void check_outputs(const std::vector<DenoiseTask>& tasks) {
  std::vector<fs::path> inputs, outputs;
  std::set<FileIdentity> targets;
  for (const DenoiseTask& task : tasks) {
    inputs.insert(inputs.end(), task.inputs.begin(), task.inputs.end());
    outputs.push_back(task.output);
    if (!targets.insert(FileIdentity(task.output)).second)
      fail_usage("two pictures would be written to {}; choose an output with #### or a folder",
                 task.output.string());
  }
  refuse_overwriting(outputs, inputs);
}

}  // namespace

FrameRange parse_frame_range(const std::string& text) {
  FrameRange range;
  const char* const end = text.data() + text.size();
  const auto [colon, first_error] = std::from_chars(text.data(), end, range.first);
  const bool good = first_error == std::errc() && colon != end && *colon == ':';
  const auto [stop, last_error] = std::from_chars(good ? colon + 1 : end, end, range.last);
  if (!good || last_error != std::errc() || stop != end || range.first < -kMostFrames ||
      range.last > kMostFrames || range.last <= range.first || range.last - range.first > 10'000'000)
    fail_usage("'{}' is no range of frames; expected A:B, which means frames A to B - 1", shown(text));
  return range;
}

std::vector<std::string> expand_names(const std::vector<std::string>& inputs) {
  std::vector<std::string> names;
  for (const std::string& input : inputs) {
    std::error_code error;
    if (input.find_first_of("*?[") == std::string::npos || fs::exists(input, error)) {
      names.push_back(input);
      continue;
    }
    glob_t found{};
    if (glob(input.c_str(), 0, nullptr, &found) == 0)
      names.insert(names.end(), found.gl_pathv, found.gl_pathv + found.gl_pathc);
    const size_t count = found.gl_pathc;
    globfree(&found);
    if (count == 0) fail_usage("'{}': no file fits", input);
  }
  return names;
}

fs::path first_file(const std::vector<std::string>& inputs, const std::optional<FrameRange>& range) {
  if (inputs.empty()) return {};
  const NamePattern pattern(inputs[0]);
  std::error_code error;
  if (pattern.digits == 0) return fs::is_regular_file(inputs[0], error) ? fs::path(inputs[0]) : fs::path();
  for (const int64_t number : pattern.present())
    if (!range || (number >= range->first && number < range->last)) return pattern.of(number);
  return {};
}

std::vector<DenoiseTask> plan_tasks(const std::vector<std::string>& inputs, const std::string& output,
                                    const std::optional<FrameRange>& range, bool samples_of_one) {
  if (inputs.empty()) fail_usage("no inputs; name the frames to denoise");
  if (output.empty()) fail_usage("no output; name the picture to write");
  const std::vector<NamePattern> patterns(inputs.begin(), inputs.end());
  const NamePattern target(output);
  const bool numbered = patterns[0].digits > 0;
  for (size_t i = 0; i < patterns.size(); ++i)
    if ((patterns[i].digits > 0) != numbered)
      fail_usage("inputs with and without ####: '{}' and '{}'; expected one kind", inputs[0], inputs[i]);
  if (range && !numbered) fail_usage("--frames needs inputs with #### for the frame's number");

  std::vector<DenoiseTask> tasks;  // outputs still to come
  if (!numbered) {
    if (samples_of_one) tasks.push_back({{inputs.begin(), inputs.end()}, {}});
    if (!samples_of_one)
      for (const std::string& input : inputs) tasks.push_back({{input}, {}});
  } else {
    const std::vector<int64_t> numbers = frames_of(patterns, range, inputs[0]);
    const size_t together = samples_of_one ? patterns.size() : 1;  // patterns of one sequence
    for (size_t first = 0; first < patterns.size(); first += together)
      for (const int64_t number : numbers) {
        tasks.push_back({{}, {}, SequencePlace{static_cast<int64_t>(first), number}});
        for (size_t i = first; i < first + together; ++i)
          tasks.back().inputs.push_back(patterns[i].of(number));
      }
  }

  const bool folder =
      output.back() == '/' || fs::is_directory(output) ||
      (target.digits == 0 &&
       (tasks.size() > 1 || (numbered && target.after.empty() && fs::path(output).extension().empty())));
  if (target.digits > 0 && (!numbered || (!samples_of_one && patterns.size() > 1)))
    fail_usage("the output '{}' has #### but the inputs are not one numbered sequence; expected a folder",
               output);
  // A folder called x.exr is hardly what was meant.
  if (folder && !fs::is_directory(output) && output.back() != '/' && fs::path(output).has_extension())
    fail_usage("{} pictures for one output '{}'; expected a folder, or #### in the name", tasks.size(),
               output);
  if (folder && !numbered && samples_of_one && inputs.size() > 1)
    fail_usage(
        "{} renders of one sample each make one picture, but the output '{}' is a folder; name a file, or "
        "write "
        "#### for the frame's number in the name of the inputs where they are a sequence",
        inputs.size(), output);
  for (size_t i = 0; i < tasks.size(); ++i) {
    if (target.digits > 0)
      tasks[i].output = target.of(tasks[i].place->position);
    else if (folder)
      tasks[i].output = fs::path(output) / tasks[i].inputs[0].filename();
    else
      tasks[i].output = output;
  }
  check_outputs(tasks);
  return tasks;
}

}  // namespace ld
