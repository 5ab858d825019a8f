// Decisions in words.
#pragma once

#include <string>
#include <vector>

#include "tuning/search.h"

namespace ld {

/// Whether `a` is at least as good in error and time and better in one.
bool beats(const Point& a, const Point& b);

/// What the winner was preferred to: each other network at its best, then the other sizes and kernels of its
/// own. Each is compared after the last rung in which both trained. `rungs`: errors by candidate and rung.
std::vector<std::string> network_sentences(const std::vector<Point>& points,
                                           const std::vector<std::vector<std::vector<double>>>& rungs,
                                           size_t winner);

/// "Place on the lens and circle of confusion (coc, lens)".
std::string feature_words(const FeatureGroup& group);

std::string eight_bits_sentence(const Point& full, const Point& eight_bits);
std::string choice_sentence(const std::vector<Point>& points, size_t chosen, const Requirement& requirement);

}  // namespace ld
