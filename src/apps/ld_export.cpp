// Weights for deployment: `ld_export --model RUN_OR_FILE --format safetensors|onnx --out FILE`.

#include "apps/app.h"
#include "apps/output_check.h"
#include "core/error.h"
#include "core/file_io.h"
#include "core/log.h"
#include "export/model_card.h"
#include "export/onnx_export.h"
#include "export/quantised_export.h"
#include "export/safetensors_export.h"
#include "ops/runtime.h"
#include "weights/weight_file.h"

namespace {

nlohmann::ordered_json to_json(const ld::Parity& parity) {
  return {{"largest_relative_difference", parity.largest_relative_difference}, {"allowed", parity.tolerance}};
}

void report(const std::string& what, const ld::Parity& parity) {
  spdlog::info("{}: largest relative difference {:.2g} (allowed {:.2g})", what,
               parity.largest_relative_difference, parity.tolerance);
}

/// Weights of convolutions in 8 bits, without LibTorch.
ld::Metadata export_int8(const ld::QuantisedExport& options, nlohmann::ordered_json& json) {
  const ld::QuantisedResult result = ld::export_quantised(options);
  const ld::QuantisedMeasure& found = result.measure;
  spdlog::info("{} written", options.out.string());
  spdlog::info(
      "on {} validation frames: SMAPE {:.5f} as i8, {:.5f} as f32, {:+.2f} % (allowed {:+.2f} %); {:.1f} ms "
      "a "
      "frame as i8, {:.1f} as f32, {:.2f} of it",
      found.frames, found.smape_int8, found.smape_float32, 100 * (found.smape_ratio() - 1),
      100 * options.allowed, found.ms_a_frame_int8, found.ms_a_frame_float32, found.time_ratio());
  json["validation"] = ld::to_json(found);
  return result.metadata;
}

struct Request {
  std::string model, untrained, mix, format, out, dtype, calibrate, check_data, card;
  std::vector<std::filesystem::path> frames;
  double mix_share = 0.5;
  std::optional<double> allowed;
};

void declare(CLI::App& options, Request& request) {
  CLI::Option* trained =
      options.add_option("--model", request.model, "weights (.safetensors), checkpoint folder or run folder");
  options
      .add_option("--untrained", request.untrained,
                  "instead: training config whose network is exported with random weights, to try a runtime")
      ->excludes(trained);
  options.add_option("--format", request.format, "safetensors, or onnx for other programs' runtimes")
      ->required()
      ->check(CLI::IsMember({"safetensors", "onnx"}));
  options.add_option("--out", request.out, "file to write (.safetensors or .onnx, as --format says)")
      ->required();
  options.add_option("--mix", request.mix,
                     "weights to average with those of --model, such as those that its training began with: "
                     "what it learnt without all that it forgot (default: none)");
  options.add_option("--mix-share", request.mix_share, "share of the weights of --mix")
      ->check(ld::number_within(0, 1))
      ->capture_default_str();
  options
      .add_option(
          "--dtype", request.dtype,
          "number format of the weights: f16 (half the size), f32 (every bit) or i8 (convolutions in 8 "
          "bits, faster; needs --calibrate) (default: f16 for safetensors, f32 for onnx)")
      ->check(CLI::IsMember({"f16", "f32", "i8"}));
  options.add_option("--calibrate", request.calibrate,
                     "data set that --dtype i8 is calibrated (training split) and measured on (validation "
                     "split): a folder with manifest.json");
  ld::repeated(options.add_option(
      "--check-frame", request.frames,
      "frame (.exr) to measure the differences on, besides three random pictures; may be repeated (default: "
      "none)"));
  options.add_option(
      "--check-data", request.check_data,
      "also write those pictures and the network's output for them, as safetensors (default: nowhere)");
  options
      .add_option("--allowed", request.allowed,
                  "largest relative difference between the ONNX graph and the C++ network (default: 0.0001); "
                  "with --dtype i8, how much larger than in float32 the SMAPE may be (default: 0.01)")
      ->check(ld::number_within(0, 1));
  options.add_option("--card", request.card,
                     "also write a page about the file for people (.md; default: nowhere)");
}

}  // namespace

int main(int argc, char** argv) {
  Request request;
  ld::Application app(
      "ld_export", "Exports a network to one deployable file and measures what that changes in its output.");
  CLI::App& options = app.options();
  declare(options, request);
  options.footer(
      "Examples:\n"
      "  ld_export --model out/run --format safetensors --out denoiser.safetensors\n"
      "  ld_export --model out/run --format safetensors --dtype i8 --calibrate out/quickstart/data --out "
      "fast.safetensors\n"
      "  ld_export --model out/run --format onnx --dtype f16 --out denoiser.onnx");

  return app.run(argc, argv, [&] {
    auto& [model, untrained, mix, format, out, dtype, calibrate, check_data, card, frames, mix_share,
           allowed] = request;
    if (model.empty() == untrained.empty()) ld::fail_command_line("give --model or --untrained");
    const bool int8 = dtype == "i8";
    if (!mix.empty() && (int8 || model.empty()))
      ld::fail_command_line("--mix is for --model in f16 or f32; export so first, then that file as i8");
    if (int8 != !calibrate.empty()) ld::fail_command_line("--dtype i8 and --calibrate go together");
    if (int8 && (format != "safetensors" || model.empty() || !frames.empty() || !check_data.empty()))
      ld::fail_command_line(
          "--dtype i8 is for --model and --format safetensors, without --check-frame and --check-data");
    ld::require_extension("--out", out, {format == "onnx" ? ".onnx" : ".safetensors"});
    ld::require_extension("--check-data", check_data, {".safetensors"});
    ld::require_extension("--card", card, {".md"});
    ld::require_writable({out, check_data, card, app.json_path()});
    std::vector<std::filesystem::path> inputs_read = frames;
    inputs_read.insert(inputs_read.end(), {model, untrained, calibrate, mix});
    for (const std::string& name : {model, mix})
      if (!name.empty()) inputs_read.push_back(ld::resolve_model(name));
    app.refuse_overwriting({out, check_data, card}, inputs_read);
    ld::configure_runtime(app.threads());
    if (dtype.empty()) dtype = format == "onnx" ? "f32" : "f16";
    ld::Metadata metadata;
    nlohmann::ordered_json json = {{"file", out}, {"format", format}, {"dtype", dtype}};
    if (int8) {
      metadata = export_int8(
          {model, calibrate, out, allowed.value_or(ld::kQuantisedTolerance), app.threads()}, json);
    } else {
      const ld::DType type = dtype == "f16" ? ld::DType::f16 : ld::DType::f32;
      ld::ExportSource source = untrained.empty() ? ld::load_source(model)
                                                  : ld::untrained_source(untrained, app.seed().value_or(1));
      if (!mix.empty()) ld::mix_in(mix, mix_share, source);
      const std::vector<ld::NetworkInput> inputs = ld::parity_inputs(source.network->config(), frames);

      if (format == "onnx") {
        const ld::OnnxExport result =
            ld::export_onnx(source, out, type, inputs, allowed.value_or(ld::kOnnxTolerance));
        spdlog::info("{} written: {} nodes, weights as {}", out, result.nodes, dtype);
        report("weights as " + dtype, result.weights);
        report("ONNX graph and C++ network", result.graph);
        metadata = ld::export_metadata(source, type, result.weights, &result.graph, inputs.size());
        json["rounded_weights"] = to_json(result.weights);
        json["onnx"] = to_json(result.graph);
      } else {
        const ld::Parity parity = ld::export_safetensors(source, out, type, inputs);
        spdlog::info("{} written", out);
        report("weights as " + dtype, parity);
        metadata = ld::export_metadata(source, type, parity, nullptr, inputs.size());
        json["rounded_weights"] = to_json(parity);
      }
      if (!check_data.empty()) ld::write_check_data(check_data, source, type, inputs);
    }
    if (!card.empty())
      ld::write_file_atomically(card,
                                ld::model_card(std::filesystem::path(out).filename().string(), metadata));
    app.write_json(json);
  });
}
