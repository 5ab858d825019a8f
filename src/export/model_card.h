// A page about an exported file for people: what it is, what it reads, where it came from. Free of LibTorch.
#pragma once

#include <string>

#include "weights/safetensors.h"

namespace ld {

/// Markdown from the metadata of an exported file: its network, features, provenance and what was measured at
/// the export. `title` is the file's name. Throws Error when an entry is missing or no JSON.
std::string model_card(const std::string& title, const Metadata& metadata);

}  // namespace ld
