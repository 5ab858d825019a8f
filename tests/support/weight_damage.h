// Ways to damage a weight file so that its header is still found: the header's length is set to fit, so that
// the damage reaches the parsers behind.
#pragma once

#include <cstring>
#include <string>

#include <nlohmann/json.hpp>

#include "tests/support/damage.h"

namespace ld {

/// The first 8 bytes of a safetensors file with such a header.
inline std::string with_header_length(const std::string& header) {
  const uint64_t length = header.size();
  std::string bytes(8, '\0');
  std::memcpy(bytes.data(), &length, 8);
  return bytes;
}

/// By turns: any bytes of the file, bytes of the header, its JSON tokens, the network or another text of its
/// metadata, the numbers and types of a tensor's entry.
inline std::string damaged_weights(const std::string& good, uint32_t number, RandomStream& random) {
  uint64_t length = 0;
  std::memcpy(&length, good.data(), 8);
  std::string header = good.substr(8, length);
  const std::string data = good.substr(8 + length);
  nlohmann::json json = nlohmann::json::parse(header);
  const auto text_of = [](const nlohmann::json& value) {
    return value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  };
  switch (number % 6) {
    case 0:
      return damaged(good, random);
    case 1:
      header = damaged(header, random);
      break;
    case 2:
      for (uint32_t more = 1 + random.below(3); more > 0; --more) header = other_token(header, random);
      break;
    case 3: {
      std::string network = json["__metadata__"]["network"];
      network = random.below(2) == 0 ? damaged(network, random) : other_token(network, random);
      json["__metadata__"]["network"] = network;
      header = text_of(json);
      break;
    }
    case 4: {
      auto entry = json["__metadata__"].begin();
      std::advance(entry, random.below(static_cast<uint32_t>(json["__metadata__"].size())));
      *entry = damaged(entry->get<std::string>(), random);
      header = text_of(json);
      break;
    }
    default: {
      auto entry = json.begin();
      std::advance(entry, random.below(static_cast<uint32_t>(json.size())));
      if (entry.key() == "__metadata__") entry = std::prev(json.end());
      static const uint64_t numbers[] = {0, 1, 3, 4, 8, 96, 4096, 1ULL << 31, 1ULL << 32, 1ULL << 62, ~0ULL};
      for (const char* key : {"shape", "data_offsets"}) {
        if (random.below(3) == 0) continue;
        nlohmann::json& list = (*entry)[key];
        if (random.below(4) == 0) list.push_back(numbers[below(random, std::size(numbers))]);
        if (!list.empty()) list[below(random, list.size())] = numbers[below(random, std::size(numbers))];
      }
      if (random.below(3) == 0)
        (*entry)["dtype"] = std::vector<const char*>{"F16", "F64", "BF16", "", "I8"}[below(random, 5)];
      header = text_of(json);
    }
  }
  return with_header_length(header) + header + data;
}

}  // namespace ld
