#include "core/shown_text.h"

#include <fmt/format.h>

#include <algorithm>

namespace ld {

std::string shown(const std::string& text, size_t most) {
  size_t end = text.size();
  if (end > most) {
    end = most;
    while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xc0) == 0x80)
      --end;  // whole UTF-8 characters
  }
  std::string result;
  for (size_t i = 0; i < end; ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    if (byte < 32 || byte == 127)
      result += fmt::format("\\x{:02x}", byte);
    else
      result += text[i];
  }
  return end < text.size() ? result + "..." : result;
}

std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

}  // namespace ld
