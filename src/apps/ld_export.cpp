// Weights for deployment: `ld_export --model RUN_OR_FILE --format safetensors --out FILE`.

#include "apps/app.h"
#include "core/log.h"
#include "export/safetensors_export.h"
#include "ops/runtime.h"

int main(int argc, char** argv) {
  std::string model, format, out, dtype = "f16";
  ld::Application app("ld_export",
                      "Exports a checkpoint's weights to one deployable file, with a parity check.");
  app.options()
      .add_option("--model", model, "weights (.safetensors), checkpoint folder or run folder")
      ->required();
  app.options()
      .add_option("--format", format, "safetensors")
      ->required()
      ->check(CLI::IsMember({"safetensors"}));
  app.options().add_option("--out", out, "file to write")->required();
  app.options()
      .add_option("--dtype", dtype, "number format: f16 (half the size) or f32 (every bit)")
      ->check(CLI::IsMember({"f16", "f32"}))
      ->capture_default_str();

  return app.run(argc, argv, [&] {
    ld::configure_runtime(app.threads());
    const ld::Parity parity =
        ld::export_safetensors(model, out, dtype == "f16" ? ld::DType::f16 : ld::DType::f32);
    spdlog::info(
        "{} written as {}; parity with the original: largest relative difference {:.2g} (allowed {:.2g})",
        out, dtype, parity.largest_relative_difference, parity.tolerance);
    app.write_json({{"file", out},
                    {"dtype", dtype},
                    {"largest_relative_difference", parity.largest_relative_difference},
                    {"tolerance", parity.tolerance}});
  });
}
