// Which candidates a search trains: those that denoise a frame within the budget.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tuning/search.h"

namespace ld {

struct Admission {
  std::vector<Point> points;  // with their times; Point::eight_bits where float32 is beyond the budget
  SearchPlan plan;
  std::string sentence;
};

/// As many as there is time for, in their order (in_order()). What is beyond kBeyondDoubt times the budget by
/// its prediction is not measured; what is beyond the budget by the clock is measured in 8 bits, too. nullopt
/// when a stop was asked for. Throws Error when nothing is within the budget, naming the cheapest.
std::optional<Admission> admit(const std::vector<Candidate>& space, const Requirement& requirement,
                               double minutes, const SearchTools& tools);

}  // namespace ld
