#include "tuning/decisions.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <set>

#include "tuning/gain.h"

namespace ld {
namespace {

using Rungs = std::vector<std::vector<std::vector<double>>>;

/// The one of the others that went furthest and did best there; -1: none trained.
int furthest(const std::vector<Point>& points, const Rungs& rungs, const std::vector<size_t>& others) {
  int best = -1;
  for (const size_t i : others) {
    if (rungs[i].empty()) continue;
    if (best < 0 || rungs[i].size() > rungs[size_t(best)].size() ||
        (rungs[i].size() == rungs[size_t(best)].size() && points[i].error < points[size_t(best)].error))
      best = int(i);
  }
  return best;
}

std::string capital(std::string text) {
  text[0] = char(std::toupper(static_cast<unsigned char>(text[0])));
  return text;
}

std::string kernel_words(const Point& point) {
  const int64_t side = point.candidate.config.network.kernel_size;
  return fmt::format("kernels of {0}x{0}", side);
}

}  // namespace

bool beats(const Point& a, const Point& b) {
  return a.error <= b.error && a.time.ms <= b.time.ms && (a.error < b.error || a.time.ms < b.time.ms);
}

std::vector<std::string> network_sentences(const std::vector<Point>& points, const Rungs& rungs,
                                           size_t winner) {
  const Candidate& won = points[winner].candidate;
  std::vector<std::string> texts;
  const auto compare = [&](const std::vector<size_t>& others, const auto& words) {
    const int other = furthest(points, rungs, others);
    if (other < 0) return;
    const Point& lost = points[size_t(other)];
    const size_t rung = std::min(rungs[size_t(other)].size(), rungs[winner].size()) - 1;
    const Gain gain = gain_of(rungs[winner][rung], rungs[size_t(other)][rung]);
    texts.push_back(
        fmt::format("{} in place of {} ({:.3g} ms, {:.3g} ms) {} after {} training{} each: {} dropped.",
                    capital(words(points[winner])), words(lost), points[winner].time.ms, lost.time.ms,
                    gain_text(gain), rung + 1, rung == 0 ? "" : "s", words(lost)));
  };
  std::vector<std::string> networks;
  std::set<std::string> sizes;
  std::set<int64_t> kernels;
  for (const Point& point : points) {
    const Candidate& c = point.candidate;
    if (c.network != won.network && std::find(networks.begin(), networks.end(), c.network) == networks.end())
      networks.push_back(c.network);
    if (c.network == won.network) {
      sizes.insert(c.size);
      kernels.insert(c.config.network.kernel_size);
    }
  }
  const auto those = [&](const auto& condition) {
    std::vector<size_t> found;
    for (size_t i = 0; i < points.size(); ++i)
      if (i != winner && condition(points[i].candidate)) found.push_back(i);
    return found;
  };
  for (const std::string& network : networks)
    compare(those([&](const Candidate& c) { return c.network == network; }),
            [](const Point& p) { return network_words(p.candidate.network); });
  for (const std::string& size : sizes)
    if (size != won.size)
      compare(those([&](const Candidate& c) { return c.network == won.network && c.size == size; }),
              [](const Point& p) { return "size " + p.candidate.size; });
  for (const int64_t kernel : kernels)
    if (kernel != won.config.network.kernel_size)
      compare(those([&](const Candidate& c) {
                return c.network == won.network && c.config.network.kernel_size == kernel &&
                       c.size == won.size;
              }),
              kernel_words);
  return texts;
}

std::string feature_words(const FeatureGroup& group) {
  const std::string names = fmt::format("{}", fmt::join(group.features, ", "));
  return names == group.words ? capital(names) : fmt::format("{} ({})", capital(group.words), names);
}

std::string eight_bits_sentence(const Point& full, const Point& eight_bits) {
  return fmt::format(
      "8 bits take {:.3g} ms in place of {:.3g} and make the SMAPE {:.5f} in place of {:.5f}: "
      "float32 {}.",
      eight_bits.time.ms, full.time.ms, eight_bits.error, full.error,
      gain_text(gain_of(full.errors, eight_bits.errors)));
}

std::string choice_sentence(const std::vector<Point>& points, size_t chosen, const Requirement& requirement) {
  const Point& point = points[chosen];
  std::string text =
      fmt::format("Chosen: {}, SMAPE {:.5f} in {:.3g} ms", point.name, point.error, point.time.ms);
  if (requirement.target_smape)
    return text + fmt::format(", the cheapest of those within {:g}.", *requirement.target_smape);
  const auto best = std::min_element(points.begin(), points.end(), [&](const Point& a, const Point& b) {
    const auto place = [&](const Point& p) { return std::pair(p.time.ms > *requirement.budget_ms, p.error); };
    return place(a) < place(b);
  });
  if (best->error == point.error) return text + ", the best within the budget.";
  return text + fmt::format("; {} {}, for {:.3g} ms: not worth them.", best->name,
                            gain_text(gain_of(best->errors, point.errors)), best->time.ms);
}

}  // namespace ld
