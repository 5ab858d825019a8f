// The search itself: which candidates train, for how long, which go on, and why. It knows neither files nor
// programs nor clocks: predictions, times and trainings come from functions, so that the same answers make
// the same search.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tuning/candidates.h"
#include "tuning/cost.h"
#include "tuning/halving.h"

namespace ld {

/// One of the two.
struct Requirement {
  std::optional<double> budget_ms;     // of a frame: then the lowest error
  std::optional<double> target_smape;  // mean over the validation frames: then the lowest time
};

struct Trial {
  std::string name;  // of its run folder
  TrainConfig config;
  std::string begins_with;  // the trial whose weights it begins with; "": random ones
};

struct TrialResult {
  std::vector<double> errors;  // SMAPE of each validation frame
  std::string failure;         // why there are none
};

/// Weights of a trial whose convolutions run in 8 bits.
struct EightBits {
  TrialResult result;
  NetworkTime time;
};

/// A trained network in the plane of error and cost.
struct Point {
  std::string name;   // of the candidate, with what was done to it
  std::string trial;  // whose weights it has
  Candidate candidate;
  std::vector<double> errors;
  double error = 0;  // mean
  NetworkTime time;
  double predicted_ms = 0, minutes = 0;  // of training, those before it included
  bool eight_bits = false;  // of its weights; of a candidate: it is within the budget in 8 bits alone
  bool unbeaten = false;
};

/// What the search asks for. Trials, times and 8 bits are nullopt when a stop was asked for.
struct SearchTools {
  std::function<double(const NetworkConfig&)> predict_ms;
  std::function<std::optional<NetworkTime>(const std::string& name, const NetworkConfig&, bool eight_bits)>
      measure;
  std::function<std::optional<TrialResult>(const Trial&)> run;
  std::function<std::optional<EightBits>(const std::string& trial)> in_eight_bits;
  /// Each network's own time, of all in turns.
  std::function<std::optional<std::vector<NetworkTime>>(const std::vector<Point>&)> measure_in_turns;
};

struct SearchOutcome {
  SearchPlan plan;
  std::vector<Point> points;
  std::optional<size_t> chosen;  // of the points; none: none meets the requirement
  std::vector<std::string> sentences;
};

/// Within `minutes`. nullopt when a stop was asked for. Throws Error when no candidate meets the budget,
/// naming the cheapest, or when none can be trained.
std::optional<SearchOutcome> search(const std::vector<Candidate>& space, const Requirement& requirement,
                                    double minutes, const SearchTools& tools);

/// What takes longer than this times the budget has no chance; up to it, a later clock may decide otherwise.
constexpr double kBeyondDoubt = 1.5;

/// The order in which candidates are taken where there is no time for all; `predicted`: their ms. Within a
/// budget the dearest of each network comes first, then the second of each: what a network gains by its size
/// it gains within the budget.
std::vector<size_t> in_order(const std::vector<Candidate>& space, const std::vector<double>& predicted,
                             const Requirement& requirement);

/// Sets Point::unbeaten where no other beats it (decisions.h).
void mark_unbeaten(std::vector<Point>& points);

/// The places of up to six that may be chosen: unbeaten ones, first those that have a chance, by their
/// errors; with a target the fastest that reach it come before.
std::vector<size_t> finalists_of(const std::vector<Point>& points, const Requirement& requirement);

/// Of those that meet the requirement, the best, or a cheaper one over which the best has no gain that pays;
/// never one that another beats in error and time. nullopt: none meets it.
std::optional<size_t> choose(const std::vector<Point>& points, const Requirement& requirement);

/// The places of the better half, rounded up, in the order of their ranks: by error, but with a target those
/// first that meet it, the cheapest before all. What failed is in no half.
std::vector<size_t> better_half(const std::vector<Point>& points, const Requirement& requirement);

}  // namespace ld
