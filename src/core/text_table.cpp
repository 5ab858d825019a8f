#include "core/text_table.h"

#include <fmt/format.h>

#include <algorithm>

namespace ld {

std::string markdown_table(std::vector<TableRow> rows, size_t text_columns) {
  std::vector<size_t> widths(rows.front().size(), 3);
  for (TableRow& row : rows)
    for (size_t c = 0; c < row.size(); ++c) {
      for (size_t at = 0; (at = row[c].find('|', at)) != std::string::npos; at += 2) row[c].insert(at, "\\");
      widths[c] = std::max(widths[c], row[c].size());
    }
  TableRow rule;
  for (size_t c = 0; c < widths.size(); ++c)
    rule.push_back(std::string(widths[c] - 1, '-').insert(c < text_columns ? 0 : widths[c] - 1, ":"));
  rows.insert(rows.begin() + 1, rule);

  std::string text;
  for (const TableRow& row : rows) {
    for (size_t c = 0; c < row.size(); ++c)
      text += c < text_columns ? fmt::format("| {:<{}} ", row[c], widths[c])
                               : fmt::format("| {:>{}} ", row[c], widths[c]);
    text += "|\n";
  }
  return text;
}

}  // namespace ld
