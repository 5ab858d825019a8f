#include "benchmark/size_times.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/text_table.h"
#include "weights/released.h"

namespace ld {

std::vector<SizeRow> size_rows(const BenchSizes& sizes) {
  std::vector<SizeRow> rows;
  const auto add = [&](const std::string& name, const std::function<NetworkWeights()>& network) {
    for (const PictureSize& size : sizes.pictures)
      rows.push_back({fmt::format("{}_{}x{}", name, size.width, size.height),
                      network,
                      {sizes.spp, size.height, size.width}});
  };
  for (const std::string& name : network_names())
    add(name, [sizes, name] { return bench_weights(bench_config(sizes, name)); });
  for (const std::string& name : released_models()) add(name, [name] { return read_network_weights(name); });
  return rows;
}

SizeTime time_size(const SizeRow& row, int repeats) {
  constexpr double kLong = 10e3;  // ms
  PlannedNetwork network(row.network(), row.picture);
  const double first_ms = time_ms([&] { network.run(); });
  SizeTime time{row.name, 0, std::clamp(int(kLong / first_ms), 1, repeats), network.multiply_adds(),
                network.bytes()};
  std::vector<double> times;
  for (int i = 0; i < time.repeats; ++i) times.push_back(time_ms([&] { network.run(); }));
  time.ms = median(times);
  return time;
}

double SizeTime::arithmetic_ms(const MachineSpeed& machine) const {
  return 2e-6 * multiply_adds / machine.sgemm_gflops;
}

double SizeTime::memory_ms(const MachineSpeed& machine) const {
  return 1e-6 * bytes / machine.memory_gb_per_s;
}

double SizeTime::perfect_ms(const MachineSpeed& machine) const {
  return std::max(arithmetic_ms(machine), memory_ms(machine));
}

std::string markdown(const std::vector<SizeTime>& times, const MachineSpeed& machine) {
  std::vector<TableRow> table = {{"row", "ms", "share of sgemm", "arithmetic alone, ms", "memory alone, ms",
                                  "to the perfect machine", "runs"}};
  for (const SizeTime& time : times) {
    const double arithmetic = time.arithmetic_ms(machine);
    table.push_back(
        {time.name, fmt::format("{:.1f}", time.ms), fmt::format("{:.0f} %", 100 * arithmetic / time.ms),
         fmt::format("{:.1f}", arithmetic), fmt::format("{:.1f}", time.memory_ms(machine)),
         fmt::format("{:.2f}", time.ms / time.perfect_ms(machine)), fmt::format("{}", time.repeats)});
  }
  return markdown_table(table, 1) + fmt::format("\nsgemm {:.1f} GFLOP/s, memory {:.1f} GB/s.\n",
                                                machine.sgemm_gflops, machine.memory_gb_per_s);
}

nlohmann::ordered_json to_json(const std::vector<SizeTime>& times, const MachineSpeed& machine) {
  auto json = nlohmann::ordered_json::array();
  for (const SizeTime& time : times)
    json.push_back({{"name", time.name},
                    {"ms", time.ms},
                    {"repeats", time.repeats},
                    {"multiply_adds", time.multiply_adds},
                    {"bytes", time.bytes},
                    {"sgemm_share", time.arithmetic_ms(machine) / time.ms},
                    {"arithmetic_ms", time.arithmetic_ms(machine)},
                    {"memory_ms", time.memory_ms(machine)},
                    {"perfect_ms", time.perfect_ms(machine)}});
  return json;
}

}  // namespace ld
