#include "benchmark/bench_report.h"

#include <fmt/ranges.h>

#include <algorithm>

#include "core/error.h"
#include "core/log.h"
#include "core/text_table.h"

namespace ld {

void check_only(const std::vector<std::string>& only, const std::vector<std::string>& names) {
  for (const std::string& name : only)
    if (std::find(names.begin(), names.end(), name) == names.end()) {
      const std::string near = nearest_word(name, names);
      fail_usage("--only {}: no such row{}; choose from {}", name,
                 near.empty() ? "" : fmt::format(", did you mean {}?", near), fmt::join(names, ", "));
    }
}

std::vector<BenchRow> run_rows(const std::vector<RowSpec>& specs, const MeasureOptions& options,
                               double sgemm_gflops) {
  std::vector<BenchRow> rows;
  for (const RowSpec& spec : specs) {
    spdlog::info("{} ...", spec.name);
    const Workload workload = spec.make();
    BenchRow row{spec.name, measure_against_composition(workload, options), workload.multiply_adds, 0};
    row.sgemm_share = 2e-6 * row.multiply_adds / row.measured.ms / sgemm_gflops;
    rows.push_back(row);
  }
  return rows;
}

nlohmann::ordered_json to_json(const BenchRow& row) {
  const Measurement& m = row.measured;
  nlohmann::ordered_json json = {{"name", row.name},
                                 {"ms", m.ms},
                                 {"baseline_ms", m.baseline_ms},
                                 {"speedup", m.baseline_ms / m.ms},
                                 {"sgemm_share", row.sgemm_share},
                                 {"peak_mb", m.peak_mb},
                                 {"baseline_peak_mb", m.baseline_peak_mb},
                                 {"repeats", m.repeats},
                                 {"baseline_repeats", m.baseline_repeats},
                                 {"multiply_adds", row.multiply_adds}};
  if (m.at_once_ms > 0) json["baseline_taps_at_once_ms"] = m.at_once_ms;
  return json;
}

std::string markdown_rows(const std::vector<BenchRow>& rows) {
  std::vector<TableRow> table = {{"row", "ms", "composition, ms", "speed-up", "share of sgemm", "peak MB",
                                  "composition, MB", "runs", "composition, taps at once, ms"}};
  for (const BenchRow& row : rows) {
    const Measurement& m = row.measured;
    table.push_back({row.name, fmt::format("{:.1f}", m.ms), fmt::format("{:.1f}", m.baseline_ms),
                     fmt::format("{:.2f}", m.baseline_ms / m.ms),
                     fmt::format("{:.0f} %", 100 * row.sgemm_share), fmt::format("{:.0f}", m.peak_mb),
                     fmt::format("{:.0f}", m.baseline_peak_mb),
                     fmt::format("{} / {}", m.repeats, m.baseline_repeats),
                     fmt::format("{:.1f}", m.at_once_ms > 0 ? m.at_once_ms : m.baseline_ms)});
  }
  return markdown_table(table, 1);
}

}  // namespace ld
