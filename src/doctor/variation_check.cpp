// Which features vary at all (dataset/varying_features.h): the others cost memory and time and teach nothing.
#include <fmt/ranges.h>

#include <mutex>

#include "dataset/varying_features.h"
#include "doctor/doctor_check.h"

namespace ld {
namespace {

class VariationCheck : public Check {
 public:
  void look(size_t /*index*/, const Evidence& evidence) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    all_.add(evidence.frame);
    // `features: auto` looks at what is trained on.
    if (evidence.split == "train") training_.add(evidence.frame);
  }

  void pass_over(const std::string& split, const FrameHeader& header) override {
    Frame unread(0, 0, 0);  // says which features are held, not what they are
    unread.features = header.features;
    const std::lock_guard<std::mutex> lock(mutex_);
    all_.add(unread);
    ++all_unread_;
    if (split != "train") return;
    training_.add(unread);
    ++training_unread_;
  }

  void conclude(Diagnosis& diagnosis) const override {
    const bool training = training_.frames() > 0;
    const FeatureVariation& seen = training ? training_ : all_;
    if (seen.frames() == 0) return;
    // What does not vary in some frames may do so in those that were not read.
    if ((training ? training_unread_ : all_unread_) > 0 && !seen.settled()) {
      diagnosis.facts["features_auto"] = nullptr;
      diagnosis.facts["features_varying"] = seen.used();
      return;
    }
    diagnosis.facts["features_auto"] = seen.used();
    nlohmann::ordered_json idle = nlohmann::ordered_json::object();
    std::vector<std::string> reasons;
    for (const FeatureRange& range : seen.ranges()) {
      const std::string reason = seen.reason(range.name);
      if (reason.empty() || range.frames == 0) continue;
      idle[range.name] = reason;
      reasons.push_back(fmt::format("{} ({})", range.name, reason));
    }
    diagnosis.facts["features_idle"] = idle;
    if (reasons.empty() || seen.frames() < 2) return;  // one frame without motion is no fault
    diagnosis.add(
        Severity::warning,
        fmt::format(
            "{} features say nothing: {}; write `features: auto` in the network's config, which takes {}",
            reasons.size(), fmt::join(reasons, ", "), fmt::join(seen.used(), ", ")),
        {}, {{"idle", idle}, {"used", seen.used()}});
  }

 private:
  std::mutex mutex_;
  FeatureVariation all_, training_;
  int64_t all_unread_ = 0, training_unread_ = 0;
};

}  // namespace

std::unique_ptr<Check> make_variation_check(size_t /*frames*/) {
  return std::make_unique<VariationCheck>();
}

}  // namespace ld
