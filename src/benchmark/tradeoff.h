// Speed traded for accuracy: what models score on a data set against what they cost.
#pragma once

#include <nlohmann/json.hpp>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "filters/frame_filter.h"
#include "plot/svg_scatter.h"

namespace ld {

struct TradeoffOptions {
  std::filesystem::path data;
  std::string split = "test";
  std::vector<std::string> models;      // NAME=FILE: weights, checkpoint or run
  std::vector<FilterArgument> filters;  // denoisers without weights
  /// NAME=DIR: pictures that another program made of the same frames, FRAME.exr, and its cost.json:
  /// {"program", "threads", "peak_mb", "seconds": {FRAME: s, ...}}
  std::vector<std::string> images;
  std::string metric = "smape";  // the error of figure and marks
  size_t frames_limit = 0;       // 0: all
  int samples = 0;               // only the first so many of each frame; 0: all
  int repeats = 5;
  int threads = 1;
};

struct TradeoffPoint {
  std::string name;
  std::vector<double> scores;  // means over the frames, in the order of metrics()
  double ms = 0;               // a frame: mean over the frames of the median of the repeats
  double peak_mb = 0;          // above program and frame, weights included, at the worst
  std::optional<int64_t> parameters;
  std::optional<double> multiply_adds;  // a pixel
  bool other_program = false;
  bool unbeaten = false;
};

struct Tradeoff {
  std::string data, split, metric;
  size_t frames = 0;
  int width = 0, height = 0, spp = 0, threads = 0;  // of the first frame
  std::vector<double> noisy, blur;                  // scores of the baselines, which have no cost
  std::vector<TradeoffPoint> points;
};

/// Scores as `ld_eval`, then times the models frame by frame in turns, so that all see the same machine.
/// Throws as the evaluation does; Error for a cost.json that is missing, damaged or of another number of
/// threads: times of different numbers of threads do not belong into one figure. UsageError for an unknown
/// metric or nothing to measure. Nothing is returned when a stop was asked for.
std::optional<Tradeoff> measure_tradeoff(const TradeoffOptions& options);

/// Marks the models that no other model beats: none is at least as good in error, time and memory and better
/// in one of them. Other programs neither are marked nor beat anybody: they are what models are measured
/// against. `metric` is an index of metrics(). A score that is no number is beaten.
void mark_unbeaten(std::vector<TradeoffPoint>& points, size_t metric);

std::string markdown(const Tradeoff& tradeoff);
ScatterPlot figure(const Tradeoff& tradeoff);
nlohmann::ordered_json to_json(const Tradeoff& tradeoff);

}  // namespace ld
