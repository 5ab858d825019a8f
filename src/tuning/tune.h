// ld_tune: a data set and a requirement in, the model that meets it out.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tuning/report.h"

namespace ld {

struct TuneOptions {
  std::filesystem::path data, out;
  std::filesystem::path work;          // folder of the search; empty: OUT.tune
  std::string config;                  // what the candidates share; "": samples_fast
  std::vector<std::string> overrides;  // key.sub=value on top of it
  Requirement requirement;
  std::optional<std::pair<int64_t, int64_t>> at;  // width and height; none: those of the data's first frame
  int samples = 0;                                // a pixel; 0: as many as all frames have
  double minutes = 60;                            // of training
  std::optional<uint64_t> seed;
  int threads = 1;

  std::filesystem::path folder() const;
};

/// "1920x1080" -> width and height. Throws UsageError.
std::pair<int64_t, int64_t> parse_size(const std::string& text);

/// Writes front.svg, table.md and table.json into the folder, then the model and its card. Goes on where it
/// was stopped; nullopt when a stop was asked for, with everything kept for whoever calls it again. Throws
/// Error as survey_data(), search() and the trials do, and when no model reaches the target, naming the
/// lowest error; UsageError when the folder holds another search.
std::optional<nlohmann::ordered_json> tune(const TuneOptions& options);

}  // namespace ld
