#include "tuning/search.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/error.h"
#include "core/log.h"
#include "tuning/decisions.h"
#include "tuning/gain.h"

namespace ld {
namespace {

constexpr double kRiseAgain = 0.1;  // share of the steps, of a cycle that begins with trained weights

class Search {
 public:
  Search(const Requirement& requirement, double minutes, const SearchTools& tools)
      : requirement_(requirement), minutes_(minutes), tools_(tools) {}

  bool admit(const std::vector<Candidate>& space);
  bool halve();
  bool decide_features();
  bool finish();
  bool decide();
  SearchOutcome outcome() { return std::move(outcome_); }

 private:
  bool within(double ms, double factor) const {
    return !requirement_.budget_ms || ms <= factor * *requirement_.budget_ms;
  }
  void say(const std::string& sentence) {
    spdlog::info("{}", sentence);
    outcome_.sentences.push_back(sentence);
  }
  [[noreturn]] void fail_budget(const std::string& name, double ms, bool measured) const;
  std::optional<TrialResult> train(const std::string& name, Candidate candidate, double minutes,
                                   const std::string& begins_with);
  bool add_point(Point point, const std::string& trial, const std::vector<double>& errors, double minutes);
  std::vector<size_t> train_rung(const std::vector<size_t>& left, size_t rung, bool& stopped);

  const Requirement& requirement_;
  double minutes_;
  const SearchTools& tools_;
  SearchOutcome outcome_;
  std::vector<std::vector<std::vector<double>>> rungs_;  // errors by candidate and rung
  Point found_;                                          // the network, then with the features that pay
};

void Search::fail_budget(const std::string& name, double ms, bool measured) const {
  fail(
      "no candidate denoises a frame within {:g} ms: the cheapest, {}, {} {:.3g} ms; give a larger "
      "--budget-ms, "
      "a smaller --at, fewer --samples or more --threads",
      *requirement_.budget_ms, name, measured ? "took" : "should take", ms);
}

bool Search::admit(const std::vector<Candidate>& space) {
  std::vector<double> predicted;
  for (const Candidate& candidate : space) predicted.push_back(tools_.predict_ms(candidate.config.network));
  std::vector<size_t> order = in_order(space, predicted, requirement_);
  const size_t all = order.size();
  order.erase(std::remove_if(order.begin(), order.end(),
                             [&](size_t i) { return !within(predicted[i], kBeyondDoubt); }),
              order.end());
  if (order.empty()) {
    const size_t cheapest = size_t(std::min_element(predicted.begin(), predicted.end()) - predicted.begin());
    fail_budget(space[cheapest].name, predicted[cheapest], false);
  }
  const size_t groups = feature_groups(space[0].config.network.features).size();
  const size_t most = affordable_candidates(order.size(), groups, minutes_);
  size_t too_slow = 0, looked_at = 0;
  std::pair<double, std::string> cheapest = {std::numeric_limits<double>::infinity(), ""};
  for (const size_t i : order) {
    if (outcome_.points.size() == most) break;
    ++looked_at;
    Point point{space[i].name, "", space[i], {}, std::numeric_limits<double>::quiet_NaN(), {}, predicted[i]};
    const std::optional<NetworkTime> time = tools_.measure(point.name, space[i].config.network);
    if (!time) return false;
    point.time = *time;
    cheapest = std::min(cheapest, {time->ms, point.name});
    if (within(time->ms, 1))
      outcome_.points.push_back(point);
    else
      ++too_slow;
  }
  if (outcome_.points.empty()) fail_budget(cheapest.second, cheapest.first, true);
  const size_t count = outcome_.points.size(), no_time = order.size() - looked_at;
  std::string text = fmt::format("{} of {} candidates train", count, all);
  if (requirement_.budget_ms)
    text += fmt::format("; {} are beyond {:g} times the budget by their graphs, {} beyond it by the clock",
                        all - order.size(), kBeyondDoubt, too_slow);
  if (no_time > 0) text += fmt::format("; for {} there is no time", no_time);
  say(text + ".");
  outcome_.plan = plan_search(count, groups, minutes_);
  spdlog::info("{}", plan_text(outcome_.plan));
  return true;
}

std::optional<TrialResult> Search::train(const std::string& name, Candidate candidate, double minutes,
                                         const std::string& begins_with) {
  candidate.config.run.minutes = minutes;
  if (!begins_with.empty()) candidate.config.optimizer.one_cycle.rise = kRiseAgain;
  return tools_.run({name, candidate.config, begins_with});
}

/// Trains those that are left; returns those that could be trained.
std::vector<size_t> Search::train_rung(const std::vector<size_t>& left, size_t rung, bool& stopped) {
  const double minutes = outcome_.plan.rungs[rung].minutes;
  std::vector<size_t> trained;
  for (const size_t i : left) {
    Point& point = outcome_.points[i];
    const std::string trial = fmt::format("{}_rung{}", point.name, rung);
    const std::optional<TrialResult> result = train(trial, point.candidate, minutes, point.trial);
    stopped = !result;
    if (stopped) return {};
    if (!result->failure.empty()) {
      say(fmt::format("{}: dropped, its training failed: {}.", point.name, result->failure));
      continue;
    }
    point.trial = trial;
    point.errors = result->errors;
    point.error = mean_error(point.errors);
    point.minutes += minutes;
    rungs_[i].push_back(point.errors);
    trained.push_back(i);
    spdlog::info("{}: SMAPE {:.5f} after {:.2g} min, {:.3g} ms", point.name, point.error, point.minutes,
                 point.time.ms);
  }
  return trained;
}

bool Search::halve() {
  std::vector<Point>& points = outcome_.points;
  std::vector<size_t> left(points.size());
  for (size_t i = 0; i < left.size(); ++i) left[i] = i;
  rungs_.resize(points.size());
  const auto of = [&](const std::vector<size_t>& places) {
    std::vector<Point> some;
    for (const size_t i : places) some.push_back(points[i]);
    return some;
  };
  for (size_t rung = 0; rung < outcome_.plan.rungs.size(); ++rung) {
    bool stopped = false;
    const std::vector<size_t> trained = train_rung(left, rung, stopped);
    if (stopped) return false;
    if (trained.empty() && rung == 0)
      fail("no candidate could be trained; the first: {}", outcome_.sentences.back());
    if (!trained.empty()) left = trained;
    if (rung + 1 == outcome_.plan.rungs.size() || trained.empty()) break;
    std::vector<size_t> next;
    for (const size_t place : better_half(of(left), requirement_))
      if (next.size() < outcome_.plan.rungs[rung + 1].candidates) next.push_back(left[place]);
    left = next;
  }
  const std::vector<Point> finalists = of(left);
  const std::optional<size_t> chosen = choose(finalists, requirement_);
  const size_t winner = left[chosen ? *chosen : better_half(finalists, requirement_)[0]];
  found_ = points[winner];
  for (const std::string& sentence : network_sentences(points, rungs_, winner)) say(sentence);
  // Those that no rung could train are no points.
  points.erase(std::remove_if(points.begin(), points.end(), [](const Point& p) { return p.trial.empty(); }),
               points.end());
  return true;
}

bool Search::add_point(Point point, const std::string& trial, const std::vector<double>& errors,
                       double minutes) {
  point.trial = trial;
  point.errors = errors;
  point.error = mean_error(errors);
  point.minutes += minutes;
  point.predicted_ms = tools_.predict_ms(point.candidate.config.network);
  const std::optional<NetworkTime> time = tools_.measure(point.name, point.candidate.config.network);
  if (!time) return false;
  point.time = *time;
  outcome_.points.push_back(point);
  return true;
}

bool Search::decide_features() {
  const std::vector<FeatureGroup> groups = feature_groups(found_.candidate.config.network.features);
  if (groups.empty()) return true;
  const double minutes = outcome_.plan.feature_minutes;
  const std::string all = "features_all", before = found_.trial;
  const std::optional<TrialResult> with = train(all, found_.candidate, minutes, before);
  if (!with) return false;
  if (!with->failure.empty()) {
    say(fmt::format("All features are kept: a training to compare with failed: {}.", with->failure));
    return true;
  }
  outcome_.points.push_back(found_);  // the same network, so the same time
  Point& control = outcome_.points.back();
  control.trial = found_.trial = all;
  control.errors = with->errors;
  control.error = mean_error(with->errors);
  control.minutes += minutes;
  control.name = found_.name + ", longer";
  found_.minutes = control.minutes;
  std::vector<std::string> kept = found_.candidate.config.network.features;
  std::vector<std::string> left_out;  // groups by their first feature
  for (const FeatureGroup& group : groups) {
    std::vector<std::string> others;
    std::copy_if(
        found_.candidate.config.network.features.begin(), found_.candidate.config.network.features.end(),
        std::back_inserter(others), [&](const std::string& feature) {
          return std::find(group.features.begin(), group.features.end(), feature) == group.features.end();
        });
    const std::string name = "features_without_" + group.features[0];
    const auto without = train(name, with_features(found_.candidate, others), minutes, before);
    if (!without) return false;
    if (!without->failure.empty()) {
      say(fmt::format("{} kept: the training without failed: {}.", feature_words(group), without->failure));
      continue;
    }
    const Gain gain = gain_of(with->errors, without->errors);
    say(fmt::format("{} {}: {}.", feature_words(group), gain_text(gain), gain.pays() ? "kept" : "dropped"));
    if (gain.pays()) continue;
    kept.erase(std::remove_if(kept.begin(), kept.end(),
                              [&](const std::string& feature) {
                                return std::find(group.features.begin(), group.features.end(), feature) !=
                                       group.features.end();
                              }),
               kept.end());
    left_out.push_back(group.features[0]);
    found_.trial = left_out.size() == 1 ? name : all;
  }
  if (left_out.empty()) return true;
  found_.candidate = with_features(found_.candidate, kept);
  found_.name += fmt::format(" without {}", fmt::join(left_out, ", "));
  return true;
}

bool Search::finish() {
  const std::string trial = "final";
  const auto result = train(trial, found_.candidate, outcome_.plan.final_minutes, found_.trial);
  if (!result) return false;
  if (!result->failure.empty()) {
    say(fmt::format("The last training failed: {}.", result->failure));
    return true;
  }
  if (!add_point(found_, trial, result->errors, outcome_.plan.final_minutes)) return false;
  Point& full = outcome_.points.back();
  full.name += ", final";
  Point small = full;
  const std::optional<EightBits> eight_bits = tools_.in_eight_bits(trial);
  if (!eight_bits) return false;
  if (!eight_bits->result.failure.empty()) {
    say(fmt::format("8 bits: dropped, {}.", eight_bits->result.failure));
    return true;
  }
  small.name += ", 8 bits";
  small.eight_bits = true;
  small.errors = eight_bits->result.errors;
  small.error = mean_error(small.errors);
  small.time = eight_bits->time;
  say(eight_bits_sentence(full, small));
  outcome_.points.push_back(small);
  return true;
}

/// Times of different moments of a busy machine do not compare, so those that may be chosen are timed again.
bool Search::decide() {
  std::vector<Point>& points = outcome_.points;
  mark_unbeaten(points);
  const std::vector<size_t> places = finalists_of(points, requirement_);
  std::vector<Point> finalists;
  for (const size_t i : places) finalists.push_back(points[i]);
  if (finalists.size() > 1) {
    const std::optional<std::vector<NetworkTime>> times = tools_.measure_in_turns(finalists);
    if (!times) return false;
    for (size_t i = 0; i < places.size(); ++i) points[places[i]].time = finalists[i].time = (*times)[i];
    say(fmt::format("The {} best for their time were timed again, in turns.", finalists.size()));
    mark_unbeaten(points);
  }
  std::optional<size_t> chosen = choose(finalists, requirement_);
  if (!chosen && requirement_.budget_ms) {
    const auto fastest =
        std::min_element(finalists.begin(), finalists.end(),
                         [](const Point& a, const Point& b) { return a.time.ms < b.time.ms; });
    chosen = size_t(fastest - finalists.begin());
    say(fmt::format("None of them is within {:g} ms any more: the fastest is taken.",
                    *requirement_.budget_ms));
  }
  if (!chosen) return true;
  outcome_.chosen = places[*chosen];
  say(choice_sentence(finalists, *chosen, requirement_));
  return true;
}

}  // namespace

std::optional<SearchOutcome> search(const std::vector<Candidate>& space, const Requirement& requirement,
                                    double minutes, const SearchTools& tools) {
  Search course(requirement, minutes, tools);
  if (!course.admit(space) || !course.halve() || !course.decide_features() || !course.finish() ||
      !course.decide())
    return std::nullopt;
  return course.outcome();
}

}  // namespace ld
