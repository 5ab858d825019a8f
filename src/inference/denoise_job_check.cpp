#include "inference/denoise_job_check.h"

#include <set>

#include "core/error.h"
#include "core/file_identity.h"
#include "inference/picture_file.h"
#include "models/network_config.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

/// Whether a picture is there: neither a folder nor a name that a render farm took with an empty file.
bool is_finished(const fs::path& output) {
  std::error_code error;
  return fs::is_regular_file(output, error) && fs::file_size(output, error) > 0;
}

void check_both_ways(const DenoiseJob& job, const Denoiser* denoiser, const FrameFilter* filter) {
  if (filter != nullptr)
    fail_usage("--both-ways goes with models that remember; the filter {} goes forwards alone",
               filter->kind());
  if (!denoiser->remembers())
    fail_usage(
        "--both-ways: the model's network is '{}', which keeps nothing from frame to frame, so that both "
        "directions are alike; expected one that remembers (layer_history, recurrent)",
        denoiser->network_config().name);
  if (job.blend) fail_usage("--both-ways and --blend do not go together; leave one of them out");
  for (const DenoiseTask& task : job.tasks)
    if (!task.place)
      fail_usage(
          "--both-ways goes with sequences, but {} is a still; expected inputs with #### for a frame's "
          "number",
          task.inputs[0].string());
}

/// Whether the frames have the pixels; those that cannot be read are complained of in their turn.
void check_kernels(const DenoiseJob& job) {
  std::set<std::pair<int, int>> seen;
  for (const auto& [x, y] : job.kernels_at)
    if (!seen.insert({x, y}).second)
      fail_usage("--kernel-at {},{} is asked for twice; expected every pixel once", x, y);
  if (job.kernels_at.empty()) return;
  for (const DenoiseTask& task : job.tasks) {
    if (is_left_alone(job, task)) continue;
    std::pair<int, int> size;
    try {
      size = input_size(task.inputs, job.render);
    } catch (const UsageError&) {
      throw;
    } catch (const Error&) {
      continue;
    }
    for (const auto& [x, y] : job.kernels_at)
      if (x < 0 || y < 0 || x >= size.first || y >= size.second)
        fail_usage("--kernel-at {},{}: no pixel ({}, {}) in {}, which has {} x {}; they are counted from 0",
                   x, y, x, y, task.inputs[0].string(), size.first, size.second);
  }
}

}  // namespace

bool is_left_alone(const DenoiseJob& job, const DenoiseTask& task) {
  return job.skip_existing && is_finished(task.output);
}

void check_job(const DenoiseJob& job, const Denoiser* denoiser, const FrameFilter* filter) {
  if (!job.noisy.empty()) {
    picture_format(job.noisy);
    if (job.tasks.size() > 1) fail_usage("--noisy takes one picture, but there are {}", job.tasks.size());
    if (FileIdentity(job.noisy) == FileIdentity(job.tasks[0].output))
      fail_usage("--noisy and --output are one file, {}; expected two", job.noisy.string());
  }
  for (const DenoiseTask& task : job.tasks)
    if (picture_format(task.output) != PictureFormat::exr && job.full_float)
      fail_usage("{}: --float goes with EXR; PNG has 8 bits", task.output.string());
    else if (picture_format(task.output) != PictureFormat::exr &&
             (!job.render.also.empty() || job.filter_alpha))
      fail_usage("{}: --also and --alpha filter go with EXR; PNG holds neither", task.output.string());
  if (filter != nullptr && (!job.render.also.empty() || job.filter_alpha))
    fail_usage("--also and --alpha filter go with models; the filter {} takes the whole light",
               filter->kind());
  if (filter != nullptr && job.max_memory_bytes > 0)
    fail_usage("--max-memory goes with models; the filter {} takes what its planes take", filter->kind());
  if (job.blend && (!job.render.also.empty() || job.filter_alpha || job.wants_parts()))
    fail_usage(
        "--blend goes with the picture alone, not with --also, --alpha filter, --aovs and --kernel-at");
  if (job.both_ways) check_both_ways(job, denoiser, filter);
  if (!job.wants_parts()) return;
  if (filter != nullptr)
    fail_usage("--aovs and --kernel-at look into networks with layers, but {} is a filter", filter->kind());
  const std::string& network = denoiser->network_config().name;
  if (network != "layer")
    fail_usage("the model's network is '{}', which has no layers to look at; expected 'layer'", network);
  for (const DenoiseTask& task : job.tasks)
    if (picture_format(task.output) != PictureFormat::exr)
      fail_usage("{} cannot hold parts for looking; expected an output with the extension .exr",
                 task.output.string());
  check_kernels(job);
}

}  // namespace ld
