// Scores models against the noisy input and the best Gaussian blur:
// `ld_eval --data DIR --model NAME=FILE ... --out DIR`.

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>

#include "apps/app.h"
#include "core/file_io.h"
#include "core/log.h"
#include "core/signals.h"
#include "evaluation/data_set.h"
#include "evaluation/evaluator.h"
#include "evaluation/method.h"
#include "evaluation/strips.h"
#include "evaluation/tables.h"
#include "inference/denoiser.h"
#include "ops/runtime.h"

namespace {

namespace fs = std::filesystem;

/// Loads the models; `features` receives every feature that one of them needs.
std::vector<ld::Method> load_methods(const std::vector<ld::ModelArgument>& models,
                                     std::vector<std::string>& features) {
  std::vector<ld::Method> methods;
  for (const ld::ModelArgument& model : models) {
    const auto denoiser = std::make_shared<const ld::Denoiser>(model.file);
    for (const std::string& feature : denoiser->features())
      if (std::find(features.begin(), features.end(), feature) == features.end()) features.push_back(feature);
    methods.push_back({model.name, [denoiser](const ld::Frame& frame) { return denoiser->denoise(frame); }});
  }
  return methods;
}

void write_results(const ld::Evaluation& evaluation, bool per_frame, const fs::path& out) {
  if (per_frame) std::cout << ld::markdown_frames(evaluation) << "\n";
  std::cout << ld::markdown_means(evaluation) << std::flush;
  ld::write_file_atomically(out / "metrics.csv", ld::to_csv(evaluation));
  ld::write_file_atomically(out / "metrics.json", ld::to_json(evaluation).dump(2) + "\n");
}

}  // namespace

int main(int argc, char** argv) {
  std::string data, out, split = "test";
  std::vector<std::string> models;
  size_t frames_limit = 0;
  bool per_frame = false;
  ld::Application app("ld_eval",
                      "Scores models against the noisy input and the best Gaussian blur of a data set.");
  app.options().add_option("--data", data, "data set: a folder with manifest.json")->required();
  app.options().add_option("--model", models,
                           "NAME=FILE: weights, checkpoint folder or run folder; may be repeated");
  app.options()
      .add_option("--out", out, "folder for metrics.csv, metrics.json and comparison pictures")
      ->required();
  app.options()
      .add_option("--split", split, "which frames: train, validation or test")
      ->capture_default_str();
  app.options()
      .add_option("--frames-limit", frames_limit, "only the first so many frames (default: all)")
      ->check(CLI::Range(1, 1'000'000));
  app.options().add_flag("--per-frame", per_frame, "also print a row for each frame");

  return app.run(argc, argv, [&] {
    const std::vector<ld::ModelArgument> arguments = ld::parse_model_arguments(models);
    ld::configure_runtime(app.threads());
    std::vector<std::string> features = {"radiance"};
    const std::vector<ld::Method> methods = load_methods(arguments, features);
    const ld::FrameSet frames = ld::open_frame_set(data, split, features, frames_limit);

    ld::StripWriter strips(out, frames.count);
    ld::EvaluatorOptions options;
    options.threads = app.threads();
    options.on_pictures = [&](size_t frame, const std::string& name,
                              const std::vector<ld::LabelledPicture>& pictures) {
      strips.add(frame, name, pictures);
    };
    std::optional<ld::Evaluation> evaluation = ld::evaluate(frames, methods, options);
    if (!evaluation) {
      spdlog::warn("stopped before the last frame: no table was written, because half a set would mislead");
      return;
    }
    evaluation->data = data;
    evaluation->split = split;
    write_results(*evaluation, per_frame, out);
    app.write_json(ld::to_json(*evaluation));
    spdlog::info("tables and pictures in {}; look at {}", out, strips.finish().string());
  });
}
