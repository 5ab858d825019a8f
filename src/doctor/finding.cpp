#include "doctor/finding.h"

#include <fmt/format.h>

#include <algorithm>

namespace ld {

const char* severity_name(Severity severity) {
  return severity == Severity::problem ? "problem" : "warning";
}

std::string frames_text(const std::vector<std::string>& names, size_t of) {
  constexpr size_t kNamed = 3;
  std::string list;
  for (size_t i = 0; i < std::min(names.size(), kNamed); ++i) list += (i == 0 ? "" : ", ") + names[i];
  if (names.size() > kNamed) list += ", ...";
  return fmt::format("{} of {} frame{} ({})", names.size(), of, of == 1 ? "" : "s", list);
}

std::string share_text(double part, double whole) {
  return fmt::format("{:.3g} %", whole > 0 ? 100 * part / whole : 0.0);
}

}  // namespace ld
