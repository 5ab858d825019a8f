// How the minutes of a search are spent, decided before the first of them: successive halving (Jamieson and
// Talwalkar, "Non-stochastic best arm identification and hyperparameter optimization", AISTATS 2016), then
// the features that pay, then the network that was found.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace ld {

/// All candidates that are left train for so long each, in turns.
struct Rung {
  size_t candidates = 0;
  double minutes = 0;
};

struct SearchPlan {
  std::vector<Rung> rungs;     // each has the better half of the last one's candidates, for twice as long
  size_t feature_trials = 0;   // with all features, and without each group of them
  double feature_minutes = 0;  // each
  double final_minutes = 0;    // of the network that was found

  /// Of all trainings together.
  double minutes() const;
};

/// One or two candidates are left in the last rung. With several feature groups, a fifth of the time is
/// theirs.
SearchPlan plan_search(size_t candidates, size_t feature_groups, double minutes);

/// The most candidates, up to `all`, that train for half a minute each in the first rung; two at least.
size_t affordable_candidates(size_t all, size_t feature_groups, double minutes);

/// A line for people.
std::string plan_text(const SearchPlan& plan);

}  // namespace ld
