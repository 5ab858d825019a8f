#include "tuning/search.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "core/log.h"
#include "tuning/admission.h"
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
  void say(const std::string& sentence) {
    spdlog::info("{}", sentence);
    outcome_.sentences.push_back(sentence);
  }
  std::optional<TrialResult> train(const std::string& name, Candidate candidate, double minutes,
                                   const std::string& begins_with);
  bool add_point(Point point, const std::string& trial, const std::vector<double>& errors, double minutes);
  bool put_into_eight_bits(Point& point);
  std::vector<size_t> train_rung(const std::vector<size_t>& left, size_t rung, bool& stopped);

  const Requirement& requirement_;
  double minutes_;
  const SearchTools& tools_;
  SearchOutcome outcome_;
  std::vector<std::vector<std::vector<double>>> rungs_;  // errors by candidate and rung
  Point found_;                                          // the network, then with the features that pay
};

bool Search::admit(const std::vector<Candidate>& space) {
  const std::optional<Admission> admission = ld::admit(space, requirement_, minutes_, tools_);
  if (!admission) return false;
  outcome_.points = admission->points;
  outcome_.plan = admission->plan;
  say(admission->sentence);
  for (const Point& point : outcome_.points)
    if (!point.candidate.config.init.empty())
      say(fmt::format("{} begins with the released weights {}.", point.name, point.candidate.config.init));
  spdlog::info("{}", plan_text(outcome_.plan));
  return true;
}

std::optional<TrialResult> Search::train(const std::string& name, Candidate candidate, double minutes,
                                         const std::string& begins_with) {
  candidate.config.run.minutes = minutes;
  if (!begins_with.empty() || !candidate.config.init.empty())
    candidate.config.optimizer.one_cycle.rise = kRiseAgain;
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
  for (Point& point : points)
    if (point.eight_bits && !point.trial.empty() && !put_into_eight_bits(point)) return false;
  // Those that no rung could train are no points.
  points.erase(std::remove_if(points.begin(), points.end(), [](const Point& p) { return p.trial.empty(); }),
               points.end());
  return true;
}

/// The weights of the point's trial in 8 bits, which may fail: then it has no trial any more. false when a
/// stop was asked for.
bool Search::put_into_eight_bits(Point& point) {
  const std::optional<EightBits> made = tools_.in_eight_bits(point.trial);
  if (!made) return false;
  if (!made->result.failure.empty()) {
    say(fmt::format("{} in 8 bits: dropped, {}.", point.name, made->result.failure));
    point.trial.clear();
    return true;
  }
  point.name += ", 8 bits";
  point.eight_bits = true;
  point.errors = made->result.errors;
  point.error = mean_error(point.errors);
  point.time = made->time;
  return true;
}

bool Search::add_point(Point point, const std::string& trial, const std::vector<double>& errors,
                       double minutes) {
  point.trial = trial;
  point.errors = errors;
  point.error = mean_error(errors);
  point.minutes += minutes;
  point.predicted_ms = tools_.predict_ms(point.candidate.config.network);
  const auto time = tools_.measure(point.name, point.candidate.config.network, /*eight_bits=*/false);
  if (!time) return false;
  point.time = *time;
  point.eight_bits = false;
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
  Point control = found_;  // the same network, so the same time
  control.trial = found_.trial = all;
  control.errors = with->errors;
  control.error = mean_error(with->errors);
  control.minutes += minutes;
  control.name = found_.name + ", longer";
  found_.minutes = control.minutes;
  if (control.eight_bits && !put_into_eight_bits(control)) return false;
  if (!control.trial.empty()) outcome_.points.push_back(control);
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
  if (!put_into_eight_bits(small)) return false;
  if (small.trial.empty()) return true;
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
