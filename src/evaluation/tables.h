// An evaluation as text: Markdown for people, CSV and JSON for programs.
#pragma once

#include <nlohmann/json.hpp>

#include <string>

#include "evaluation/scores.h"

namespace ld {

/// The means: one row a method, one column a metric, and the seconds a frame; below it what each metric is
/// computed on (with its epsilon) and the widths of the blur.
std::string markdown_means(const Evaluation& evaluation);

/// The same columns with one row for each method and frame.
std::string markdown_frames(const Evaluation& evaluation);

/// Header "method,frame,relmse,smape,ssim,psnr,seconds,not_finite", one row for each method and frame and one
/// named "mean" for each method; RFC 4180 quoting; "nan" and "inf" for scores that are no numbers, full
/// precision.
std::string to_csv(const Evaluation& evaluation);

/// {"data", "split", "frame_count", "relmse_epsilon", "smape_epsilon", "metrics": {NAME: {"better",
/// "domain"}},
///  "methods": {NAME: {"mean": {"relmse", "smape", "ssim", "psnr"}, "seconds"?, "not_finite", "sigma"?:
///  {...},
///                     "frames": [{"name", "relmse", "smape", "ssim", "psnr", "seconds"?, "not_finite"}]}}}
/// A score that is no finite number (PSNR of equal pictures, a broken picture: see not_finite) is null.
nlohmann::ordered_json to_json(const Evaluation& evaluation);

}  // namespace ld
