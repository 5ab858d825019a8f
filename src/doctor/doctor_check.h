// A check is two functions: `measure` turns a frame into a few numbers, on any thread, and `conclude` turns
// the numbers of all frames into findings. So frames are read once each, a thread's at a time, whatever the
// size of the data set.
#pragma once

#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

#include "doctor/evidence.h"
#include "doctor/finding.h"

namespace ld {

/// Pixels darker than this part of their frame's mean brightness count as this part of it: half floats of
/// almost black say little, and no test should depend on them.
constexpr double kDarkShare = 1e-2;

class Check {
 public:
  virtual ~Check() = default;
  /// For each index once; safe to call from several threads.
  virtual void look(size_t index, const Evidence& evidence) = 0;
  /// A frame that is not examined, of which only the header is known; likewise.
  virtual void pass_over(const std::string& /*split*/, const FrameHeader& /*header*/) {}
  virtual void conclude(Diagnosis& diagnosis) const = 0;
};

/// What `measure` found in one frame.
template <class Result>
struct Measured {
  bool read = false;  // false: the frame could not be read
  std::string name, split;
  Result result;
};

/// The frames that could be read, in the order of the manifest.
template <class Result>
using Measurements = std::vector<Measured<Result>>;

template <class Result, Result (*measure)(const Evidence&),
          void (*conclude_from)(const Measurements<Result>&, Diagnosis&)>
class FrameCheck : public Check {
 public:
  explicit FrameCheck(size_t frames) : measured_(frames) {}

  static std::unique_ptr<Check> make(size_t frames) { return std::make_unique<FrameCheck>(frames); }

  void look(size_t index, const Evidence& evidence) override {
    measured_[index] = {true, evidence.name, evidence.split, measure(evidence)};
  }
  void conclude(Diagnosis& diagnosis) const override {
    Measurements<Result> readable;
    for (const Measured<Result>& frame : measured_)
      if (frame.read) readable.push_back(frame);
    if (!readable.empty()) conclude_from(readable, diagnosis);
  }

 private:
  Measurements<Result> measured_;
};

using MakeCheck = std::unique_ptr<Check> (*)(size_t frames);

// The families of checks, a file each.
std::unique_ptr<Check> make_value_check(size_t frames);         // NaN, negative radiance, bad references
std::unique_ptr<Check> make_firefly_check(size_t frames);       // in samples and in references
std::unique_ptr<Check> make_range_check(size_t frames);         // of every feature; albedo above one
std::unique_ptr<Check> make_normal_check(size_t frames);        // unit length, view space
std::unique_ptr<Check> make_depth_check(size_t frames);         // unit, escaped rays, along the axis
std::unique_ptr<Check> make_guide_check(size_t frames);         // guides averaged over the samples
std::unique_ptr<Check> make_filter_guide_check(size_t frames);  // parts of radiance, ids, cameras
std::unique_ptr<Check> make_seed_check(size_t frames);          // samples and reference are independent
std::unique_ptr<Check> make_filter_check(size_t frames);        // one pixel's samples are its own
std::unique_ptr<Check> make_split_check(size_t frames);         // no picture in two splits
std::unique_ptr<Check> make_variation_check(size_t frames);     // which features vary at all

}  // namespace ld
