// What the metadata of a weight file says: which network it fills, which features that network wants, where
// the weights came from. All values are texts: format "ld-weights", format_version, network (YAML of
// NetworkConfig), features (describe_features), schema_version, provenance (JSON).
#pragma once

#include <filesystem>
#include <string>

#include "models/network_config.h"
#include "weights/safetensors.h"

namespace ld {

struct WeightsHeader {
  NetworkConfig network;
  std::string provenance;  // JSON text; "" when the file says nothing
};

Metadata make_weights_metadata(const NetworkConfig& network, const std::string& provenance);

/// Throws Error when the file is not one of ours, of a newer version, or made for another feature schema
/// (naming the first feature that differs).
WeightsHeader read_weights_header(const SafetensorsFile& file);

/// The weight file that `model` stands for: itself, a checkpoint folder's weights.safetensors, a run folder's
/// best checkpoint (the last one where there is no best), or released weights of that name (released.h).
/// Throws Error saying what was looked for.
std::filesystem::path resolve_model(const std::filesystem::path& model);

}  // namespace ld
