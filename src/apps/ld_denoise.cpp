// Denoises frames with trained weights: `ld_denoise --model FILE INPUT... --output FILE`.

#include <chrono>
#include <filesystem>

#include "apps/app.h"
#include "core/error.h"
#include "core/log.h"
#include "core/signals.h"
#include "frame/frame_file.h"
#include "frame/frame_pair.h"
#include "inference/denoiser.h"
#include "ops/runtime.h"

namespace {

namespace fs = std::filesystem;

/// One input: the output is a file. Several: a folder of files named like the inputs.
fs::path output_path(const fs::path& output, const fs::path& input, size_t inputs) {
  return inputs == 1 ? output : output / input.filename();
}

nlohmann::ordered_json denoise_file(const ld::Denoiser& denoiser, const fs::path& input,
                                    const fs::path& output) {
  ld::Faults faults;
  ld::Frame frame = ld::read_frame(input, denoiser.features(), faults);
  const int width = frame.width, height = frame.height, spp = frame.spp;
  const auto start = std::chrono::steady_clock::now();
  const ld::Image image = denoiser.denoise(std::move(frame));
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  ld::write_image(output, image);
  ld::warn_about_faults(input, faults);
  spdlog::info("{} ({}x{}, {} spp) denoised in {:.2f} s: {}", input.string(), width, height, spp, seconds,
               output.string());
  return {{"input", input.string()},
          {"output", output.string()},
          {"width", width},
          {"height", height},
          {"spp", spp},
          {"seconds", seconds},
          {"masked_samples", faults.not_finite},
          {"negative_values", faults.negative}};
}

}  // namespace

int main(int argc, char** argv) {
  std::string model, output;
  std::vector<std::string> inputs;
  ld::Application app("ld_denoise", "Denoises frames of samples with trained weights.");
  app.options()
      .add_option("--model", model, "weights (.safetensors), checkpoint folder or run folder")
      ->required();
  app.options().add_option("inputs", inputs, "frames (EXR with sample parts)")->required();
  app.options()
      .add_option("--output", output, "image to write (.exr, .png); a folder for several inputs")
      ->required();

  return app.run(argc, argv, [&] {
    ld::configure_runtime(app.threads());
    const ld::Denoiser denoiser(model);
    nlohmann::ordered_json report = nlohmann::ordered_json::array();
    for (const std::string& input : inputs) {
      if (ld::stop_requested()) break;
      report.push_back(denoise_file(denoiser, input, output_path(output, input, inputs.size())));
    }
    app.write_json(report);
  });
}
