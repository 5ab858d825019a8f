// Denoises frames with trained weights or a filter: `ld_denoise --model FILE INPUT... --output FILE`.

#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>

#include "apps/app.h"
#include "apps/output_check.h"
#include "core/error.h"
#include "core/log.h"
#include "import/former_result.h"
#include "import/recognise.h"
#include "import/source_plan.h"
#include "inference/denoise_job.h"
#include "inference/denoiser.h"
#include "sequence/movie_file.h"
#include "weights/released.h"
#include "weights/weight_file.h"

namespace {

constexpr const char* kSkipWithin = "1e-4";

struct Options {
  std::string model = "common", filter, output, noisy, frames, preset, mapping, camera, view;
  std::string alpha = "copy";
  bool blend = false, both_ways = false;
  std::vector<std::string> inputs, assignments, aovs, kernels_at, also;
  int64_t max_memory = 0;  // MB
  std::optional<std::string> skip_within;
  std::string movie;
  double frames_a_second = 24;
  int samples = 0;
  bool skip_existing = false, full_float = false, allow_identical = false;
};

void declare(CLI::App& app, Options& o) {
  auto* const model =
      app.add_option(
             "--model", o.model,
             fmt::format("released weights ({}), a file of weights (.safetensors), checkpoint or run folder",
                         fmt::join(ld::released_models(), ", ")))
          ->capture_default_str();
  app.add_option("--filter", o.filter, "instead of a model a denoiser without weights (docs/filters.md)")
      ->check(CLI::IsMember(ld::filter_kinds()))
      ->excludes(model);
  app.add_option(
         "inputs", o.inputs,
         "frames, or one frame's renders of other programs; #### in a name stands for a frame's number")
      ->required();
  app.add_option("--output", o.output,
                 "picture to write (.exr, .png), with #### for a sequence; a folder for several inputs")
      ->required();
  app.add_option(
      "--noisy", o.noisy,
      "also write the mean of the samples, of a single picture, here (.exr, .png; default: nowhere)");
  app.add_option("--movie", o.movie,
                 "then also make a film of the pictures (.mp4, .webm) by ffmpeg (default: none)");
  app.add_option("--fps", o.frames_a_second, "frames a second of --movie")
      ->check(ld::number_within(0.1, 1000))
      ->capture_default_str();
  app.add_option("--frames", o.frames, "A:B denoises frames A to B - 1 (default: all that there are)");
  app.add_option("--samples", o.samples, "only the first so many samples of each frame (default: all)")
      ->check(ld::whole_number_within(1, 4096));
  app.add_flag("--skip-existing", o.skip_existing, "leave pictures alone that are there already");
  app.add_option(
         "--max-memory", o.max_memory,
         "with models: MB that the process may take, the samples of the input aside (default: no bound)")
      ->check(ld::whole_number_within(1, int64_t{1} << 30));
  app.add_option("--skip-within", o.skip_within,
                 "with models: leave out work that changes the picture x by at most so much times 1 + x; 0: "
                 "by no bit; off: "
                 "leave nothing out")
      ->default_str(kSkipWithin);
  app.add_flag("--float", o.full_float, "full floats in EXR (default: half)");
  ld::repeated(
      app.add_option("--also", o.also,
                     "parts of the light whose names fit this (*, ?, [...]): each is filtered as the picture "
                     "is and becomes a "
                     "layer of its name, so that they still add up; may be repeated (default: none)"));
  app.add_flag(
      "--blend", o.blend,
      "towards the mean of the samples where that is nearer to the truth, by an estimate of both errors");
  app.add_flag(
      "--both-ways", o.both_ways,
      "sequences forwards and backwards in time, for films; models that remember (docs/sequences.md)");
  app.add_option("--alpha", o.alpha, "copy: the mean of the samples' alpha; filter: by the picture's kernels")
      ->check(CLI::IsMember({"copy", "filter"}))
      ->capture_default_str();
  ld::repeated(app.add_option("--aovs", o.aovs,
                              "EXR parts for looking, separated by commas, or repeated (default: none)"))
      ->delimiter(',')
      ->check(CLI::IsMember({"layers", "contributions", "unfiltered"}));
  ld::repeated(
      app.add_option("--kernel-at", o.kernels_at,
                     "X,Y: EXR parts with the kernels of that pixel; may be repeated (default: none)"));
  app.add_option("--preset", o.preset,
                 fmt::format("who rendered them (default: told by their channels): {}",
                             fmt::join(ld::preset_names(), ", ")));
  app.add_option("--mapping", o.mapping, "YAML file instead of a preset (docs/import.md)");
  ld::repeated(app.add_option("--set", o.assignments,
                              "key.sub=value, on top of the preset or mapping, or FILTER.key=value; may be "
                              "repeated; ld_inspect --keys mapping, eaw or svgf lists the keys"));
  app.add_option("--camera", o.camera,
                 "YAML file of the camera (docs/import.md; default: what the files say)");
  app.add_option("--view", o.view,
                 "of files with several views, such as left and right (default: the first)");
  app.add_flag("--allow-identical", o.allow_identical, "let samples pass that are the same in every pixel");
}

/// The preset that fits the first file; empty for frames, and where there is no file, which is complained of
/// later.
std::string recognised(const Options& o, const std::filesystem::path& first) {
  if (first.empty()) return {};
  const ld::ExrReader exr(first);
  if (!ld::is_frame(exr)) return ld::recognise_preset(exr, o.view, o.assignments);
  if (!o.camera.empty() || !o.assignments.empty() || !o.view.empty() || o.allow_identical)
    ld::fail_command_line(
        "--camera, --set, --view and --allow-identical go with renders of other programs, but {} is a frame",
        first.string());
  return {};
}

ld::RenderInput render_input(const Options& o, const std::filesystem::path& first) {
  ld::RenderInput render;
  render.allow_identical = o.allow_identical;
  render.preset = o.preset.empty() && o.mapping.empty() ? recognised(o, first) : o.preset;
  if (render.preset.empty() && o.mapping.empty()) return render;
  render.mapping = ld::read_mapping(render.preset, o.mapping, o.assignments);
  if (!o.view.empty()) render.mapping->view = o.view;
  if (!o.camera.empty()) render.camera = ld::read_camera(o.camera);
  return render;
}

std::pair<int, int> pixel_of(const std::string& text) {
  int x = -1, y = -1;
  const char* const end = text.data() + text.size();
  const auto [comma, x_error] = std::from_chars(text.data(), end, x);
  const bool good = x_error == std::errc() && comma != end && *comma == ',';
  const auto [stop, y_error] = std::from_chars(good ? comma + 1 : end, end, y);
  if (!good || y_error != std::errc() || stop != end || x < 0 || y < 0)
    ld::fail_command_line("--kernel-at '{}' is no pixel; expected X,Y, counted from the upper left one",
                          text);
  return {x, y};
}

/// Of --skip-within; nothing for "off".
std::optional<double> skip_within_of(const std::string& text) {
  if (text == "off") return std::nullopt;
  const std::optional<double> within = ld::number_in(text, 0, 1);
  if (!within) ld::fail_command_line("--skip-within '{}': expected a number from 0 to 1, or off", text);
  return within;
}

/// The view that will be read, as far as it is said before the files are looked at.
std::string said_view(const Options& o) {
  if (!o.view.empty()) return o.view;
  if (!o.preset.empty() || !o.mapping.empty())
    return ld::read_mapping(o.preset, o.mapping, o.assignments).view;
  for (const std::string& assignment : o.assignments)
    if (assignment.rfind("view=", 0) == 0) return assignment.substr(5);
  return {};
}

/// The inputs without results of this program, which lie beside renders and fit their pattern: a denoised
/// picture among the samples would count as one.
std::vector<std::string> without_results(const Options& o, const std::vector<std::string>& inputs) {
  const std::string view = said_view(o);
  std::vector<std::string> kept, results;
  for (const std::string& input : inputs)
    (ld::is_former_result(input, view) ? results : kept).push_back(input);
  if (kept.empty() && !results.empty()) ld::fail("{}: {}", results[0], ld::kDenoisedAlready);
  for (const std::string& result : results)
    spdlog::warn("{}: left out, because it is a former result: its attribute ldDenoisedBy says so", result);
  return kept;
}

/// "common" reads samples; where renders are one picture each, of which only the mean of the samples is
/// known, "means" takes its place.
std::string model_for(const Options& o, const ld::DenoiseJob& job, const std::filesystem::path& first) {
  if (!job.render.mapping || first.empty()) return o.model;
  const size_t files = job.tasks[0].inputs.size();
  const size_t samples =
      files > 1 ? files
                : ld::plan_samples(ld::ExrReader(first), *job.render.mapping, ld::Wanted::picture).size();
  if (!job.render.preset.empty() && o.preset.empty())
    spdlog::info("{}: renders as preset {} has them, {}", first.string(), job.render.preset,
                 samples > 1 ? fmt::format("{} samples of one frame", samples) : "one picture a frame");
  if (samples > 1 || o.model != "common") return o.model;
  spdlog::info(
      "one picture a frame holds the mean of its samples: denoised with the model 'means'; files with one "
      "sample each, of different seeds, tell more (docs/denoising.md)");
  return "means";
}

ld::DenoiseJob job_of(Options o) {
  ld::DenoiseJob job;
  if (!o.filter.empty()) job.filter = ld::parse_filter_arguments({o.filter}, o.assignments).front();
  if (!o.preset.empty() && !o.mapping.empty()) ld::fail_command_line("expected either --preset or --mapping");
  for (const std::string& part : o.aovs)
    if (std::count(o.aovs.begin(), o.aovs.end(), part) > 1)
      ld::fail_command_line("--aovs: '{}' is asked for twice; expected each once", part);
  for (const std::string& text : o.kernels_at) job.kernels_at.push_back(pixel_of(text));
  std::optional<ld::FrameRange> range;
  if (!o.frames.empty()) range = ld::parse_frame_range(o.frames);
  const std::vector<std::string> inputs = without_results(o, ld::expand_names(o.inputs));
  const std::filesystem::path first = ld::first_file(inputs, range);
  job.render = render_input(o, first);
  job.render.also = o.also;
  job.tasks = ld::plan_tasks(inputs, o.output, range, job.render.mapping.has_value());
  if (!job.filter) job.model = ld::resolve_model(model_for(o, job, first));
  job.max_memory_bytes = o.max_memory * ld::kBudgetMegabyte;
  if (job.filter && o.skip_within)
    ld::fail_command_line("--skip-within goes with models; the filter {} leaves nothing out", o.filter);
  job.skip_within = skip_within_of(o.skip_within.value_or(kSkipWithin));
  job.samples = o.samples;
  job.skip_existing = o.skip_existing;
  job.full_float = o.full_float;
  job.filter_alpha = o.alpha == "filter";
  job.blend = o.blend;
  job.both_ways = o.both_ways;
  job.noisy = o.noisy;
  const auto wants = [&](const char* part) { return std::count(o.aovs.begin(), o.aovs.end(), part) > 0; };
  job.layers = wants("layers");
  job.contributions = wants("contributions");
  job.unfiltered = wants("unfiltered");
  return job;
}

void tell_what_is_done(const ld::DenoiseJob& job, const ld::DenoiseReport& report) {
  if (job.tasks.size() == 1) {
    spdlog::warn("stopped before {} was denoised: {} is not written", job.tasks[0].inputs[0].string(),
                 job.tasks[0].output.string());
    return;
  }
  spdlog::warn(
      "stopped: {} of {} pictures are done{}, the others are not; --skip-existing does only what is left",
      report.finished(), job.tasks.size(),
      report.failed.empty() ? "" : fmt::format(", {} failed", report.failed.size()));
}

void make_film(const Options& o, const ld::DenoiseJob& job) {
  if (o.movie.empty()) return;
  const std::filesystem::path film =
      ld::write_movie(o.movie, o.frames_a_second, job.tasks.size(),
                      [&](size_t i) { return ld::read_shown_picture(job.tasks[i].output); });
  spdlog::info("{} pictures in {}", job.tasks.size(), film.string());
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  ld::Application app("ld_denoise", "Denoises frames of samples with trained weights or a filter.");
  declare(app.options(), options);
  app.options().footer(
      "Examples:\n"
      "  ld_denoise 'render_*.exr' --output denoised.exr\n"
      "  ld_denoise --filter svgf 'shot.####.exr' --output 'denoised.####.exr'\n"
      "  ld_denoise --model out/run 'shot.####.exr' --frames 1:25 --output 'denoised.####.exr'");
  return app.run(argc, argv, [&] {
    ld::DenoiseJob job = job_of(options);
    job.threads = app.threads();
    if (!options.movie.empty()) ld::require_movie_name("--movie", options.movie);
    std::vector<std::filesystem::path> outputs = {options.noisy, options.movie},
                                       to_write = {options.noisy, options.movie, app.json_path()},
                                       inputs = {job.model, options.mapping, options.camera};
    for (const ld::DenoiseTask& task : job.tasks) {
      outputs.push_back(task.output);
      if (!job.skip_existing || !std::filesystem::exists(task.output)) to_write.push_back(task.output);
      inputs.insert(inputs.end(), task.inputs.begin(), task.inputs.end());
    }
    // Results that were left out, too: what is named is not overwritten.
    inputs.insert(inputs.end(), options.inputs.begin(), options.inputs.end());
    app.refuse_overwriting(outputs, inputs);
    ld::require_writable(to_write);
    const ld::DenoiseReport report = ld::run_denoise_job(job);
    app.write_json(report.frames);
    if (report.skipped > 0)
      spdlog::info("{} of {} pictures were there already", report.skipped, job.tasks.size());
    if (report.stopped) {
      tell_what_is_done(job, report);
      return;
    }
    if (!report.failed.empty())
      ld::fail("{} of {} frames failed, the first {}; {}", report.failed.size(), job.tasks.size(),
               report.failed[0],
               report.finished() > 0 ? "the others are done, and --skip-existing does only what is left"
                                     : "check the names and --frames");
    make_film(options, job);
  });
}
