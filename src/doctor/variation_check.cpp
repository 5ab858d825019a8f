// Which features vary at all (dataset/varying_features.h): the others cost memory and time and teach nothing.
#include <fmt/ranges.h>

#include <mutex>

#include "dataset/varying_features.h"
#include "doctor/check.h"

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

  void conclude(Diagnosis& diagnosis) const override {
    const FeatureVariation& seen = training_.frames() > 0 ? training_ : all_;
    if (seen.frames() == 0) return;
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
};

}  // namespace

std::unique_ptr<Check> make_variation_check(size_t /*frames*/) {
  return std::make_unique<VariationCheck>();
}

}  // namespace ld
