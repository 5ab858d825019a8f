// What a search found, for people: a table, a figure, JSON, and the model with its card.
#pragma once

#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>

#include "plot/svg_scatter.h"
#include "tuning/search.h"

namespace ld {

/// What was asked, and what the data says without any network.
struct SearchQuestion {
  std::string data;
  Requirement requirement;
  PictureExtent picture;
  int threads = 1;
  double minutes = 0, noisy_error = 0;
};

std::string markdown(const SearchOutcome& outcome, const SearchQuestion& question);
ScatterPlot figure(const SearchOutcome& outcome, const SearchQuestion& question);
nlohmann::ordered_json to_json(const SearchOutcome& outcome, const SearchQuestion& question);

/// Writes the chosen weights as they are, with what was decided in their metadata, and a card beside them
/// (.md). `model` is a run folder or a weight file.
void write_model(const std::filesystem::path& out, const std::filesystem::path& model,
                 const SearchOutcome& outcome, const SearchQuestion& question);

}  // namespace ld
