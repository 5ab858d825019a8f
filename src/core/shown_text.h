// Text from a file or a command line, made fit to stand in a message.
#pragma once

#include <string>

namespace ld {

/// Control characters (which would break the line or move a terminal's cursor) become \xNN; of a long text
/// the first `most` bytes are shown, and "..." behind them.
std::string shown(const std::string& text, size_t most = 80);

/// A library's complaint of several lines as one.
std::string one_line(std::string text);

}  // namespace ld
