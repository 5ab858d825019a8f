// Rows of ld_bench: timed, as JSON, as a table.
#pragma once

#include <nlohmann/json.hpp>

#include <algorithm>
#include <string>
#include <vector>

#include "benchmark/measure.h"
#include "benchmark/workloads.h"

namespace ld {

struct BenchRow {
  std::string name;
  Measurement measured;
  double multiply_adds = 0;
  double sgemm_share = 0;  // 2 * multiply_adds / time, of what sgemm reached in the same run
};

/// Those of the rows that `only` names; all where that is empty.
template <class Row>
std::vector<Row> chosen_rows(std::vector<Row> rows, const std::vector<std::string>& only) {
  const auto left_out = [&](const Row& row) {
    return !only.empty() && std::find(only.begin(), only.end(), row.name) == only.end();
  };
  rows.erase(std::remove_if(rows.begin(), rows.end(), left_out), rows.end());
  return rows;
}

/// Throws UsageError when `only` names a row that is not there.
void check_only(const std::vector<std::string>& only, const std::vector<std::string>& names);

/// Times the rows one after the other.
std::vector<BenchRow> run_rows(const std::vector<RowSpec>& specs, const MeasureOptions& options,
                               double sgemm_gflops);

/// {"name", "ms", "baseline_ms", "speedup", "sgemm_share", "peak_mb", "baseline_peak_mb", "repeats",
///  "baseline_repeats", "multiply_adds"}; where the composition takes slices of the logits, also
///  "baseline_taps_at_once_ms", the time of the one that does not
nlohmann::ordered_json to_json(const BenchRow& row);

std::string markdown_rows(const std::vector<BenchRow>& rows);

}  // namespace ld
