// Scores models, filters, and pictures that other denoisers wrote, against the noisy input and the best
// Gaussian blur: `ld_eval --data DIR --model NAME=FILE ... --images NAME=DIR ... --out DIR`.

#include <fmt/ranges.h>

#include <iostream>

#include "apps/app.h"
#include "core/log.h"
#include "evaluation/data_set.h"
#include "evaluation/image_folder.h"
#include "evaluation/results.h"
#include "evaluation/tables.h"
#include "inference/filter_method.h"
#include "inference/model_method.h"

namespace {

struct Options {
  std::string data, out, split = "test", baseline;
  std::vector<std::string> models, images, filters, assignments, metrics;
  size_t frames_limit = 0;
  int samples = 0;
  bool per_frame = false, sequences = false;
  ld::ReportOptions report;
  ld::MovieOptions movies;
};

void declare(CLI::App& app, Options& options) {
  app.add_option("--data", options.data, "data set: a folder with manifest.json")->required();
  ld::repeated(
      app.add_option("--model", options.models,
                     "NAME=FILE: weights, checkpoint folder or run folder; may be repeated (default: none)"));
  ld::repeated(app.add_option(
      "--images", options.images,
      "NAME=DIR: pictures of another denoiser, DIR/FRAME.exr (linear); may be repeated (default: none)"));
  ld::repeated(app.add_option("--filter", options.filters,
                              fmt::format("{}, a denoiser without weights, or NAME= and one of them; may be "
                                          "repeated (default: none)",
                                          fmt::join(ld::filter_kinds(), ", "))));
  ld::repeated(
      app.add_option("--set", options.assignments,
                     "NAME.key=value for the filter of that name; may be repeated; ld_inspect --keys "
                     "eaw and svgf list the keys"));
  app.add_option("--out", options.out, "folder for tables, pictures and report.html")->required();
  app.add_option("--split", options.split, "which frames: train, validation or test")->capture_default_str();
  app.add_option(
      "--baseline", options.baseline,
      "what the others are compared with: one of their names, noisy or blur (default: the first given)");
  app.add_option("--frames-limit", options.frames_limit, "only the first so many frames (default: all)")
      ->check(ld::whole_number_within(1, 1'000'000));
  app.add_option("--samples", options.samples, "only the first so many samples of each frame (default: all)")
      ->check(ld::whole_number_within(1, 4096));
  ld::repeated(app.add_option("--metrics", options.metrics,
                              "besides relMSE, SMAPE, SSIM and PSNR: flip, hdr_flip, separated by commas, or "
                              "repeated (default: none)"))
      ->delimiter(',');
  app.add_flag("--sequences", options.sequences,
               "also how steady the methods are over frames that follow one another; the report plays them");
  app.add_option("--movies", options.movies.format,
                 "mp4 or webm: films of the sequences, side by side, by ffmpeg (default: none)")
      ->check(CLI::IsMember({"mp4", "webm"}));
  app.add_option("--fps", options.movies.frames_a_second, "frames a second of --movies")
      ->check(ld::number_within(0.1, 1000))
      ->capture_default_str();
  app.add_flag("--per-frame", options.per_frame, "also print a row for each frame");
  app.add_option("--report-frames", options.report.frames, "pictures of so many frames go into report.html")
      ->check(ld::whole_number_within(0, 1'000'000))
      ->capture_default_str();
  app.add_option("--report-side", options.report.side,
                 "the report shows the middle of larger pictures, so many pixels a side")
      ->check(ld::whole_number_within(1, 16384))
      ->capture_default_str();
  app.add_option("--report-sequences", options.report.most_sequences,
                 "with --sequences, so many of them play in report.html")
      ->check(ld::whole_number_within(0, 1'000'000))
      ->capture_default_str();
  app.add_flag_callback(
      "--formulas",
      [] {
        std::cout << ld::formulas_text();
        throw CLI::Success();
      },
      "print the metrics' formulas and exit");
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  ld::Application app("ld_eval",
                      "Scores models and others' pictures against the noisy input and the best blur.");
  declare(app.options(), options);
  app.options().footer(
      "Examples:\n"
      "  ld_eval --data out/quickstart/data --model mine=out/run --out out/eval\n"
      "  ld_eval --data out/quickstart/data --filter eaw --filter svgf --out out/eval\n"
      "  ld_eval --data out/quickstart/data --model mine=out/run --images oidn=out/oidn --baseline oidn "
      "--out out/eval");

  return app.run(argc, argv, [&] {
    ld::EvaluatorOptions evaluator;
    evaluator.metrics = ld::metrics_with(options.metrics);
    evaluator.sequences = options.sequences;
    const auto arguments = ld::parse_model_arguments(options.models);
    std::vector<std::string> assignments = options.assignments;
    const auto filters = ld::parse_filter_arguments(options.filters, assignments);
    if (!assignments.empty())
      ld::fail_command_line("--set {}: no --filter has that name; expected NAME.key=value", assignments[0]);
    const auto folders = ld::parse_named_arguments("--images", "oidn=out/oidn", options.images);
    std::vector<std::filesystem::path> inputs = {options.data};
    for (const auto& argument : arguments) inputs.emplace_back(argument.file);
    for (const auto& folder : folders) inputs.emplace_back(folder.file);
    app.refuse_overwriting({options.out}, inputs);
    std::vector<std::string> features = {"radiance"};
    const std::vector<ld::LoadedModel> models = ld::load_models(arguments, app.threads(), features);
    if (options.sequences) ld::add_surface_features(options.data, options.split, features);
    const ld::FrameSet frames =
        ld::open_frame_set(options.data, options.split, features, options.frames_limit, options.samples);
    if (!options.movies.format.empty() && frames.sequences.empty())
      ld::fail_usage("--movies {}: no two frames of split {} of {} follow one another", options.movies.format,
                     options.split, options.data);
    std::vector<ld::Method> methods;
    if (!models.empty()) {
      const ld::Frame first = frames.load(0).frame;
      for (const ld::LoadedModel& model : models)
        methods.push_back(ld::method_of(model, ld::cost_of(model, first)));
    }
    for (const ld::FilterArgument& filter : filters)
      methods.push_back(ld::filter_method(filter, app.threads()));
    for (const ld::ModelArgument& folder : folders)
      methods.push_back(ld::image_folder_method(folder.name, folder.file, frames.names));
    ld::check_baseline(options.baseline, methods);

    if (options.sequences) options.report.sequences = frames.sequences;
    ld::ResultWriter results(options.out, frames.count, options.report);
    evaluator.threads = app.threads();
    evaluator.on_pictures = [&](size_t frame, const std::string& name,
                                const std::vector<ld::LabelledPicture>& pictures) {
      results.add(frame, name, pictures);
    };
    std::optional<ld::Evaluation> evaluation = ld::evaluate(frames, methods, evaluator);
    if (!evaluation) {
      spdlog::warn("stopped before the last frame: no table was written, because half a set would mislead");
      return;
    }
    evaluation->data = options.data;
    evaluation->split = options.split;
    evaluation->samples = options.samples;
    evaluation->baseline = options.baseline;
    std::cout << ld::results_text(*evaluation, options.per_frame) << std::flush;
    results.write(*evaluation, frames, options.movies);
    app.write_json(ld::to_json(*evaluation));
    spdlog::info("tables and pictures in {}; open {}/report.html in a browser", options.out, options.out);
  });
}
