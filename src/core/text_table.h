// Tables for people: Markdown that also reads as plain text.
#pragma once

#include <string>
#include <vector>

namespace ld {

using TableRow = std::vector<std::string>;

/// The first row holds the headings; all rows have as many cells as it. Columns are padded to their widest
/// cell; the first `text_columns` are aligned to the left, the others, which hold numbers, to the right.
std::string markdown_table(std::vector<TableRow> rows, size_t text_columns);

}  // namespace ld
