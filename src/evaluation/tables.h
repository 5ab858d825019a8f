// An evaluation as text: Markdown for people, CSV and JSON for programs.
#pragma once

#include <nlohmann/json.hpp>

#include <string>

#include "evaluation/scores.h"

namespace ld {

/// The means: one row a method, one column a metric, and the seconds a frame, the references' floor last
/// where it is known; below it each metric's formula, what it is computed on, and the widths of the blur.
std::string markdown_means(const Evaluation& evaluation);

/// The confidence intervals of these means (metrics/statistics.h): the same rows, "low .. high".
std::string markdown_intervals(const Evaluation& evaluation);

/// Every method against the evaluation's baseline (evaluation/comparison.h): a row for each metric and
/// method.
std::string markdown_comparison(const Evaluation& evaluation);

/// What the floor is, for people.
std::string floor_text();

/// One line for each metric: its name and formula.
std::string formulas_text();

/// The same columns with one row for each method and frame.
std::string markdown_frames(const Evaluation& evaluation);

/// Header "method,frame,relmse,smape,ssim,psnr,seconds,not_finite" (further metrics after psnr), one row for
/// each method and frame and three named "mean", "ci95_low" and "ci95_high" for each method; RFC 4180
/// quoting; "nan" and "inf" for scores that are no numbers, empty cells where there is no interval, full
/// precision.
std::string to_csv(const Evaluation& evaluation);

/// Header "baseline,method,metric,frames,mean_difference,ci95_low,ci95_high,better,worse,equal,p", one row
/// for each method and metric; empty cells for what does not exist.
std::string comparison_csv(const Evaluation& evaluation);

/// {"data", "split", "frame_count", "relmse_epsilon", "smape_epsilon", "confidence",
///  "unit": "frame" or "sequence", "metrics": {NAME: {"title", "better", "domain", "formula", "digits"}},
///  "methods": {NAME: {"mean": {"relmse", "smape", "ssim", "psnr"}, "interval": {"relmse": [low, high], ...},
///                     "seconds"?, "parameters"?, "multiply_adds_per_pixel"?, "not_finite", "sigma"?: {...},
///                     "frames": [{"name", "relmse", "smape", "ssim", "psnr", "seconds"?, "not_finite"}]}},
///  "floor"?: {"name", "text", "mean": {"relmse", ...}, "interval": {...}, "frames": [{"name", "relmse",
///  ...}]}, "comparison": comparison_json(), "sequences"?: the same of Evaluation::sequences}
/// A score that is no finite number (PSNR of equal pictures, a broken picture: see not_finite) is null, and
/// so is an interval or a p that does not exist.
nlohmann::ordered_json to_json(const Evaluation& evaluation);

/// {"baseline", "frame_count", "too_few_frames", "methods": {NAME: {"relmse": {"mean_difference", "interval",
/// "better", "worse", "equal", "p"}, ...}}}
nlohmann::ordered_json comparison_json(const Evaluation& evaluation, const MethodScores& baseline);

}  // namespace ld
