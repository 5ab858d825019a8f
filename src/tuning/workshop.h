// Where a search does its work: a folder of run folders, each trained by ld_train and scored by the runtime.
// What is done is read from there, so that a search that was stopped goes on.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "tuning/search.h"

namespace ld {

struct WorkshopOptions {
  std::filesystem::path folder;  // trials/NAME.yaml, NAME/ (the run), NAME.log, NAME.json (its scores)
  std::filesystem::path data;
  std::filesystem::path trainer;  // the program ld_train
  PictureExtent picture;          // for which the cost is told
  int threads = 1;
};

class Workshop {
 public:
  /// Times the operators of `space` for its predictions, unless the folder has their rates.
  Workshop(const WorkshopOptions& options, const std::vector<Candidate>& space);

  SearchTools tools();

  /// The weights of a trial: its run folder, or its file of 8 bits.
  std::filesystem::path model_of(const Point& point) const;

  /// Mean SMAPE of the pixels' means over the validation frames.
  double noisy_error() const;

 private:
  std::filesystem::path place(const std::string& trial, const std::string& extension = "") const;
  std::optional<NetworkTime> measure(const std::string& name, const NetworkWeights& network);
  std::optional<std::vector<NetworkTime>> measure_in_turns(const std::vector<Point>& points);
  std::optional<TrialResult> run(const Trial& trial);
  std::optional<TrialResult> score(const std::filesystem::path& model, const std::filesystem::path& record);
  std::optional<EightBits> in_eight_bits(const std::string& trial);
  void remember_costs() const;

  WorkshopOptions options_;
  CostModel costs_;
  std::map<std::string, NetworkTime> times_;
};

}  // namespace ld
