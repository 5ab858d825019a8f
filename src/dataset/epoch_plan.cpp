#include "dataset/epoch_plan.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/error.h"
#include "core/random.h"

namespace ld {
namespace {

/// Whole numbers that add up to `total`, in proportion to the weights: largest remainders.
std::vector<size_t> apportion(size_t total, const std::vector<double>& weights) {
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  std::vector<size_t> shares, order;
  std::vector<double> remainders;
  size_t left = total;
  for (size_t i = 0; i < weights.size(); ++i) {
    const double exact = static_cast<double>(total) * weights[i] / sum;
    shares.push_back(static_cast<size_t>(std::floor(exact)));
    remainders.push_back(exact - std::floor(exact));
    order.push_back(i);
    left -= shares[i];
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return remainders[a] > remainders[b]; });
  for (size_t i = 0; i < left; ++i) ++shares[order[i]];
  return shares;
}

}  // namespace

EpochPlan::EpochPlan(std::vector<size_t> clips, size_t crops, const std::vector<double>& weights,
                     uint64_t seed)
    : clips_(std::move(clips)), crops_(crops), seed_(seed) {
  shares_ = apportion(crops_, weights);
  for (size_t set = 0; set < shares_.size(); ++set)
    if (shares_[set] == 0)
      fail_usage(
          "data.paths[{}].weight is {:g}, so small beside the others that none of an epoch's {} crops comes "
          "from that set; raise it or leave the set out",
          set, weights[set], crops_);
}

std::vector<ClipRef> EpochPlan::epoch(uint32_t epoch) const {
  std::vector<std::vector<size_t>> drawn;
  for (size_t set = 0; set < clips_.size(); ++set) drawn.push_back(draw(set, epoch));
  std::vector<size_t> taken(clips_.size(), 0);
  std::vector<ClipRef> plan;
  while (plan.size() < crops_) {
    // The set that is furthest behind its share of the crops so far.
    size_t next = 0;
    double furthest = -1;
    for (size_t set = 0; set < clips_.size(); ++set) {
      const double due = static_cast<double>(shares_[set]) * static_cast<double>(plan.size() + 1) /
                         static_cast<double>(crops_);
      const double behind = taken[set] < shares_[set] ? due - static_cast<double>(taken[set]) : -2;
      if (behind > furthest) {
        furthest = behind;
        next = set;
      }
    }
    plan.push_back({next, drawn[next][taken[next]++]});
  }
  return plan;
}

std::vector<size_t> EpochPlan::draw(size_t set, uint32_t epoch) const {
  const uint64_t begin = uint64_t{epoch} * shares_[set];
  std::vector<size_t> drawn;
  std::vector<uint32_t> order;
  for (uint64_t i = begin; i < begin + shares_[set]; ++i) {
    const uint64_t round = i / clips_[set], place = i % clips_[set];
    if (order.empty() || place == 0) {
      RandomStream stream(seed_, RandomPurpose::data_order, static_cast<uint32_t>(round),
                          static_cast<uint32_t>(set));
      order = random_permutation(stream, static_cast<uint32_t>(clips_[set]));
    }
    drawn.push_back(order[place]);
  }
  return drawn;
}

}  // namespace ld
