// Denoises frames with trained weights: `ld_denoise --model FILE INPUT... --output FILE`.

#include <fmt/ranges.h>

#include <cstdio>

#include "apps/app.h"
#include "core/error.h"
#include "core/log.h"
#include "inference/denoise_job.h"
#include "ops/runtime.h"

namespace {

struct Options {
  std::string model, output, frames, preset, mapping, camera;
  std::vector<std::string> inputs, assignments, aovs, kernels_at;
  int64_t max_memory = 0;  // MB
  int samples = 0;
  bool skip_existing = false, full_float = false, allow_identical = false;
};

void declare(CLI::App& app, Options& o) {
  app.add_option("--model", o.model, "weights (.safetensors), checkpoint folder or run folder")->required();
  app.add_option("inputs", o.inputs,
                 "frames (EXR with sample parts); #### in a name stands for the number of a frame")
      ->required();
  app.add_option("--output", o.output,
                 "picture to write (.exr, .png), with #### for a sequence; a folder for several inputs")
      ->required();
  app.add_option("--frames", o.frames, "A:B denoises frames A to B - 1 (default: all that there are)");
  app.add_option("--samples", o.samples, "only the first so many samples of each frame (default: all)")
      ->check(CLI::Range(1, 4096));
  app.add_flag("--skip-existing", o.skip_existing, "leave pictures alone that are there already");
  app.add_option("--max-memory", o.max_memory, "MB that the process may take, the samples of the input aside")
      ->check(CLI::Range(int64_t{1}, int64_t{1} << 30));
  app.add_flag("--float", o.full_float, "full floats in EXR (default: half)");
  ld::repeated(
      app.add_option("--aovs", o.aovs,
                     "EXR parts for looking: layers, contributions, unfiltered; with commas, or repeated"))
      ->delimiter(',')
      ->check(CLI::IsMember({"layers", "contributions", "unfiltered"}));
  ld::repeated(app.add_option("--kernel-at", o.kernels_at,
                              "X,Y: EXR parts with the kernels of that pixel; may be repeated"));
  app.add_option("--preset", o.preset,
                 fmt::format("the inputs are samples of one frame, rendered by {}",
                             fmt::join(ld::preset_names(), ", ")));
  app.add_option("--mapping", o.mapping, "YAML file instead of a preset, see docs/import.md");
  ld::repeated(app.add_option("--set", o.assignments,
                              "key.sub=value, on top of the preset or mapping; may be repeated"));
  app.add_option("--camera", o.camera, "YAML file of the camera, see docs/import.md");
  app.add_flag("--allow-identical", o.allow_identical, "let samples pass that are the same in every pixel");
}

ld::RenderInput render_input(const Options& o) {
  ld::RenderInput render;
  render.allow_identical = o.allow_identical;
  if (o.preset.empty() && o.mapping.empty()) {
    if (!o.camera.empty() || !o.assignments.empty() || o.allow_identical)
      ld::fail_usage("--camera, --set and --allow-identical go with --preset or --mapping");
    return render;
  }
  if (!o.preset.empty() && !o.mapping.empty()) ld::fail_usage("expected either --preset or --mapping");
  render.mapping = ld::read_mapping(o.preset, o.mapping, o.assignments);
  if (!o.camera.empty()) render.camera = ld::read_camera(o.camera);
  return render;
}

std::pair<int, int> pixel_of(const std::string& text) {
  int x = -1, y = -1;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%d,%d%c", &x, &y, &rest) != 2)
    ld::fail_usage("--kernel-at '{}' is no pixel; expected X,Y, counted from the upper left one", text);
  return {x, y};
}

ld::DenoiseJob job_of(const Options& o) {
  ld::DenoiseJob job;
  job.model = o.model;
  job.render = render_input(o);
  std::optional<ld::FrameRange> range;
  if (!o.frames.empty()) range = ld::parse_frame_range(o.frames);
  job.tasks = ld::plan_sequence(o.inputs, o.output, range, job.render.mapping.has_value());
  job.max_memory_bytes = o.max_memory << 20;
  job.samples = o.samples;
  job.skip_existing = o.skip_existing;
  job.full_float = o.full_float;
  const auto wants = [&](const char* part) { return std::count(o.aovs.begin(), o.aovs.end(), part) > 0; };
  job.layers = wants("layers");
  job.contributions = wants("contributions");
  job.unfiltered = wants("unfiltered");
  for (const std::string& text : o.kernels_at) job.kernels_at.push_back(pixel_of(text));
  return job;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  ld::Application app("ld_denoise", "Denoises frames of samples with trained weights.");
  declare(app.options(), options);
  return app.run(argc, argv, [&] {
    const ld::DenoiseJob job = job_of(options);
    std::vector<std::filesystem::path> outputs, inputs = {options.model, options.mapping, options.camera};
    for (const ld::DenoiseTask& task : job.tasks) {
      outputs.push_back(task.output);
      inputs.insert(inputs.end(), task.inputs.begin(), task.inputs.end());
    }
    app.refuse_overwriting(outputs, inputs);
    ld::configure_runtime(app.threads());
    const ld::DenoiseReport report = ld::run_denoise_job(job);
    app.write_json(report.frames);
    if (report.skipped > 0)
      spdlog::info("{} of {} pictures were there already", report.skipped, job.tasks.size());
    if (!report.failed.empty())
      ld::fail(
          "{} of {} frames failed, the first {}; the others are done, and --skip-existing does only what is "
          "left",
          report.failed.size(), job.tasks.size(), report.failed[0]);
  });
}
