// What a frame, image, data set, config, weight file, checkpoint or run is, and what is wrong with it:
// `ld_inspect PATH [--verify] [--frames N] [--json FILE]`. Which keys configurations take:
// `ld_inspect --keys KIND`.

#include <iostream>
#include <string>

#include "apps/app.h"
#include "apps/inspect/inspect.h"
#include "apps/inspect/keys.h"
#include "core/error.h"
#include "core/log.h"
#include "core/signals.h"

int main(int argc, char** argv) {
  std::string path, kind;
  ld::InspectOptions options;
  ld::Application app("ld_inspect",
                      "Says what a path is and what is wrong with it; exit code 1 when something is.");
  app.options().add_option("path", path,
                           "frame or image (.exr), weights (.safetensors), ONNX model, config (.yaml), data "
                           "set, checkpoint or run");
  app.options()
      .add_option(
          "--keys", kind,
          "instead of a path: print all keys of this kind of YAML file with their types, defaults and "
          "ranges")
      ->check(CLI::IsMember(ld::key_kinds()));
  app.options().add_flag("--verify", options.verify, "compare the checksums of all files of a data set");
  app.options()
      .add_option("--frames", options.frames,
                  "of a data set, examine the samples of so many frames only, spread over it (default: all)")
      ->check(ld::whole_number_within(1, 1'000'000));
  app.options().footer(
      "Examples:\n"
      "  ld_inspect out/quickstart/data\n"
      "  ld_inspect --keys train");
  return app.run(argc, argv, [&] {
    if (path.empty() == kind.empty()) ld::fail_command_line("expected a path or --keys KIND, one of them");
    if (!kind.empty()) {
      const std::vector<ld::ConfigKey> keys = ld::keys_of(kind);
      std::cout << ld::keys_text(keys) << std::flush;
      app.write_json(ld::keys_json(keys));
      return;
    }
    app.refuse_overwriting({}, {path});
    options.threads = app.threads();
    const ld::Report report = ld::inspect(path, options);
    if (ld::stop_requested()) {
      spdlog::warn("stopped before all of {} was read: no report, because half of one would mislead", path);
      return;
    }
    std::cout << ld::report_text(report) << std::flush;
    app.write_json(ld::report_json(report));
    if (!report.problems.empty())
      ld::fail("{}: {} problem{} found; the report names them", path, report.problems.size(),
               report.problems.size() == 1 ? "" : "s");
  });
}
