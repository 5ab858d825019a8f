#include "inference/denoise_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "core/checksum.h"
#include "core/error.h"
#include "core/file_identity.h"
#include "core/log.h"
#include "core/process/process_memory.h"
#include "core/progress.h"
#include "core/signals.h"
#include "core/threads.h"
#include "frame/frame_file.h"
#include "frame/frame_pair.h"
#include "inference/blend.h"
#include "inference/both_ways.h"
#include "inference/denoise_job_check.h"
#include "inference/denoiser.h"
#include "inference/parts_for_looking.h"
#include "models/network_config.h"
#include "weights/weight_file.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

constexpr int64_t kSteps = 100;                                // of the progress of one frame
const std::vector<std::string> kRadianceAlone = {"radiance"};  // all else a filter can do without

/// Of the samples, [1, H, W]; empty where they have none.
Image kept_alpha(const Frame& frame) {
  return frame.alpha.empty() ? Image() : mean_alpha(frame);
}

std::vector<std::string> names_of(const std::vector<LightPart>& parts) {
  std::vector<std::string> names;
  for (const LightPart& part : parts) names.push_back(part.name);
  return names;
}

class Run {
 public:
  explicit Run(const DenoiseJob& job)
      : job_(job), progress_("denoising", int64_t(job.tasks.size()) * (job.both_ways ? 2 : 1) * kSteps) {
    if (job.filter)
      filter_.emplace(*job.filter);
    else
      denoiser_.emplace(job.model);
    how_.threads = job.threads;
    how_.max_memory_bytes = job.max_memory_bytes;
    how_.skip_within = job.skip_within;
    how_.cancel = stop_requested;
    how_.progress = [this](double share) { advance_to(int64_t((share * part_ + before_) * kSteps)); };
    check_job(job, denoiser_ ? &*denoiser_ : nullptr, filter_ ? &*filter_ : nullptr);
  }

  /// Before the frames of a sequence, tasks [first, last), are denoised in their order: with both_ways the
  /// same backwards. Frames that cannot be had are complained of by denoise(). False when it was stopped.
  bool go_backwards(size_t first, size_t last) {
    end_sequence();  // the directions follow one another: one state at a time is in memory
    backward_.emplace(*denoiser_, job_.tasks[first].output.parent_path());
    for (size_t i = last; i-- > first; finish_frame()) {
      const DenoiseTask& task = job_.tasks[i];
      if (stop_requested()) return false;
      try {
        if (is_left_alone(job_, task)) fail("{} was there and is no longer; try again", task.output.string());
        InputFrame input = read(task);
        backward_->add(i, input.frame, *task.place, job_.filter_alpha, how_);
      } catch (const Cancelled&) {
        return false;
      } catch (const UsageError&) {
        throw;
      } catch (const Error& error) {
        backward_->fail_frame(i, error.what());
      }
    }
    backward_->end();
    return true;
  }

  nlohmann::ordered_json denoise(size_t number) {
    const DenoiseTask& task = job_.tasks[number];
    const InputFrame input = read(task);
    const Frame& frame = input.frame;
    tell_what_was_taken(input);
    for (SequenceState* state : {&state_, &first_half_, &second_half_})
      state->advance(task.place, frame.width, frame.height, frame.info.cut);
    const bool blends = job_.blend && can_blend(frame);
    const auto start = std::chrono::steady_clock::now();
    DenoisedParts denoised;
    before_ = 0;
    part_ = blends ? 0.5 : 1;
    how_.memory_aside_bytes = blends ? -blend_bytes(frame) : 0;
    if (filter_)
      denoised.picture = filter_->denoise(frame, state_, threads_);
    else
      denoised = denoiser_->denoise_parts(frame, job_.filter_alpha, how_, &state_);
    const Skipped skipped = filter_ ? Skipped() : denoiser_->skipped();
    std::optional<int64_t> future;
    if (backward_)
      future =
          backward_->mix_into(number, denoised, denoiser_->frames_held(state_, frame.width, frame.height));
    if (blends)
      blend(frame, denoised.picture);
    else if (job_.blend)
      tell_of_no_halves();
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (!job_.filter_alpha) denoised.alpha = kept_alpha(frame);
    const std::vector<std::string> notes = write(task.output, denoised, input);
    if (!job_.noisy.empty()) {
      const Image mean = mean_radiance(frame);
      const bool alpha = picture_format(job_.noisy) == PictureFormat::exr;
      write_image(job_.noisy, alpha ? with_alpha(mean, kept_alpha(frame)) : mean, frame.info.windows);
    }
    const std::string name = task.inputs[0].string();
    warn_about_faults(name, input.faults);
    for (const std::string& note : input.notes) spdlog::warn("{}: {}", name, note);
    for (const std::string& note : notes) spdlog::warn("{}: {}", task.output.string(), note);
    const int64_t peak = peak_resident_bytes() / kBudgetMegabyte, samples = frame.bytes() / kBudgetMegabyte;
    spdlog::info("{} ({}x{}, {} spp) denoised in {:.2f} s; peak memory {} MB beside {} MB of samples: {}",
                 name, frame.width, frame.height, frame.spp, seconds, peak - samples, samples,
                 task.output.string());
    tell_what_was_skipped(skipped);
    nlohmann::ordered_json entry = {
        {"input", name},
        {"output", task.output.string()},
        {"width", frame.width},
        {"height", frame.height},
        {"spp", frame.spp},
        {"also", names_of(frame.parts)},
        {"history", state_.history()},
        {"seconds", seconds},
        {"skipped", {{"pixels", skipped.pixels}, {"samples", skipped.samples}, {"layers", skipped.layers}}},
        {"peak_memory_mb", peak},
        {"input_memory_mb", samples},
        {"masked_samples", input.faults.not_finite},
        {"mended_guides", input.faults.guides},
        {"mended_parts", input.faults.parts},
        {"negative_values", input.faults.negative}};
    if (future) entry["future"] = *future;
    return entry;
  }

  /// What was remembered of the frames before is of no use to those that follow.
  void end_sequence() {
    for (SequenceState* state : {&state_, &first_half_, &second_half_}) state->end();
  }

  void finish_frame() {
    advance_to(kSteps);
    done_ = 0;
  }

 private:
  InputFrame read(const DenoiseTask& task) const {
    InputFrame input = read_input(task.inputs, job_.render, filter_ ? kRadianceAlone : denoiser_->features(),
                                  job_.samples, job_.threads);
    if (job_.filter_alpha && input.frame.alpha.empty())
      fail("{}: no alpha to filter: the samples have none; leave --alpha filter out",
           task.inputs[0].string());
    return input;
  }

  /// Of the half of the samples from the first or the second on. A budget counts what blending has still to
  /// take, so that it is as large as when the picture was made.
  Image denoise_half(const Frame& frame, int first, SequenceState& state) {
    part_ = 0.25;
    before_ = 0.5 + part_ * first;
    if (filter_) return filter_->denoise(half_of(frame, first), state, threads_);
    const HalfInPlace half = half_in_place(frame, first, denoiser_->network_config().features);
    const int64_t picture = 3 * int64_t(sizeof(float)) * int64_t(frame.plane_size()),
                  there = (1 + first) * picture + int64_t(half.valid.size());
    how_.memory_aside_bytes = frame.bytes() - (blend_bytes(frame) - there);
    return denoiser_->denoise_parts(half.arrays, how_, &state).picture;
  }

  void blend(const Frame& frame, Image& picture) {
    const Image first = denoise_half(frame, 0, first_half_), second = denoise_half(frame, 1, second_half_);
    picture = blend_with_mean(frame, picture, first, second).picture;
  }

  void tell_of_no_halves() {
    if (!told_of_blending_)
      spdlog::warn("one sample a pixel has no halves to compare: such pictures are not blended");
    told_of_blending_ = true;
  }

  /// Of the first frame: the others are alike.
  void tell_what_was_taken(const InputFrame& input) {
    if (told_ || input.taken.empty()) return;
    told_ = true;
    for (const std::string& line : input.taken) spdlog::info("{}", line);
  }

  /// Of a model, where it is worth a line.
  static void tell_what_was_skipped(const Skipped& skipped) {
    if (std::max({skipped.pixels, skipped.samples, skipped.layers}) < 0.01) return;
    spdlog::info(
        "skipped: {:.1f} % of the pixels (even light), {:.1f} % of the samples (equal ones), {:.1f} % of the "
        "layers' pixels (no influence)",
        100 * skipped.pixels, 100 * skipped.samples, 100 * skipped.layers);
  }

  void advance_to(int64_t step) {
    if (step <= done_) return;
    progress_.advance(step - done_);
    done_ = step;
  }

  /// What users should know about the file.
  std::vector<std::string> write(const fs::path& output, const DenoisedParts& denoised,
                                 const InputFrame& input) const {
    if (picture_format(output) != PictureFormat::exr) {
      write_image(output, denoised.picture);
      return {};
    }
    const std::string by = filter_
                               ? fmt::format("ld_denoise {}, filter {}", LD_VERSION, filter_->description())
                               : fmt::format("ld_denoise {}, network {}, weights {}", LD_VERSION,
                                             denoiser_->network_config().name, checksum_);
    PictureLayers layers = {{"", with_alpha(denoised.picture, denoised.alpha)}};
    for (size_t i = 0; i < denoised.parts.size(); ++i)
      layers.emplace_back(input.frame.parts[i].name, denoised.parts[i]);
    std::vector<PicturePart> looked_at;
    if (job_.wants_parts()) looked_at = parts_for_looking(job_, *denoiser_, input.frame, how_);
    return write_picture(output, layers, input.original, looked_at, job_.full_float, by, threads_);
  }

  const DenoiseJob& job_;
  std::optional<Denoiser> denoiser_;  // or:
  std::optional<FrameFilter> filter_;
  std::optional<BackwardPass> backward_;  // of the sequence that is being denoised
  int threads_ = job_.threads > 0 ? job_.threads : default_threads();
  // Of the weights, not their name: equal ones make equal files wherever they lie.
  std::string checksum_ = job_.filter ? std::string() : file_checksum(job_.model);
  Progress progress_;
  DenoiseOptions how_;
  SequenceState state_, first_half_, second_half_;  // of the samples, where pictures are blended
  int64_t done_ = 0;
  double before_ = 0, part_ = 1;  // shares of the frame's work: what is done, what is being done
  bool told_ = false, told_of_blending_ = false;
};

}  // namespace

DenoiseReport run_denoise_job(const DenoiseJob& job) {
  Run run(job);
  DenoiseReport report;
  const auto sequence = [&](size_t i) { return job.tasks[i].place->sequence; };
  for (size_t i = 0; i < job.tasks.size(); ++i) {
    const DenoiseTask& task = job.tasks[i];
    report.stopped = stop_requested();
    if (report.stopped) break;
    if (job.both_ways && (i == 0 || sequence(i) != sequence(i - 1))) {
      size_t last = i + 1;
      while (last < job.tasks.size() && sequence(last) == sequence(i)) ++last;
      report.stopped = !run.go_backwards(i, last);
      if (report.stopped) break;
    }
    try {
      if (is_left_alone(job, task))
        ++report.skipped;
      else
        report.frames.push_back(run.denoise(i));
    } catch (const Cancelled&) {
      report.stopped = true;
      break;
    } catch (const UsageError&) {
      throw;  // it would be the same for every frame
    } catch (const Error& error) {
      if (job.tasks.size() == 1) throw;
      run.end_sequence();
      spdlog::error("{}", error.what());
      report.failed.push_back(task.inputs[0].string());
      report.frames.push_back({{"input", report.failed.back()}, {"error", error.what()}});
    }
    run.finish_frame();
  }
  return report;
}

}  // namespace ld
