// Renders of other programs to training frames, or to a frame alone, and HDF5 in and out (docs/import.md):
// `ld_import --preset NAME --reference REF.exr --out DATA --name NAME --split train SAMPLE.exr ...`.

#include <fmt/ranges.h>

#include <iostream>

#include "apps/app.h"
#include "apps/output_check.h"
#include "core/error.h"
#include "core/log.h"
#include "frame/frame_file.h"
#include "frame/frame_pair.h"
#include "import/frame_import.h"
#include "import/hdf5_layout.h"

namespace {

struct Options {
  std::string preset, mapping, camera, view, reference, frame;
  std::vector<std::string> assignments, files, also;
  ld::DataSetPlace place;
  std::string from_hdf5, to_hdf5, depth = "linear";
  bool allow_identical = false, print_mapping = false;
};

void declare(CLI::App& app, Options& o) {
  app.add_option("files", o.files,
                 "OpenEXR files, one sample a pixel each unless the mapping says otherwise");
  app.add_option("--preset", o.preset,
                 fmt::format("who rendered them: {}", fmt::join(ld::preset_names(), ", ")));
  app.add_option("--mapping", o.mapping, "YAML file instead of a preset (docs/import.md)");
  ld::repeated(app.add_option("--set", o.assignments,
                              "key.sub=value, on top of the preset or mapping; may be repeated; ld_inspect "
                              "--keys mapping lists the keys"));
  app.add_flag("--print-mapping", o.print_mapping,
               "print the preset's YAML, to start one's own from, and stop");
  app.add_option("--camera", o.camera,
                 "YAML file of the camera (docs/import.md; default: what the files say)");
  app.add_option("--view", o.view,
                 "of files with several views, such as left and right (default: the first)");
  ld::repeated(app.add_option("--also", o.also,
                              "parts of the light whose names fit this (*, ?, [...]) become layers of the "
                              "frame (docs/import.md); may be repeated (default: none)"));
  app.add_option("--reference", o.reference, "the converged picture, in the same layout");
  app.add_option("--out", o.place.folder, "folder of the data set to add to");
  app.add_option("--name", o.place.name, "name of the frame in the data set");
  app.add_option("--split", o.place.split, "train, validation or test")
      ->check(CLI::IsMember({"train", "validation", "test"}));
  app.add_option("--sequence", o.place.sequence,
                 "number of the sequence that the frame belongs to (default: none)")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--position", o.place.position, "its position there, from 0 (default: none)")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--frame", o.frame,
                 "write the frame alone to this file (.exr), without reference and manifest");
  app.add_option("--from-hdf5", o.from_hdf5,
                 "add the frames of this HDF5 file of samples, and of --reference, to the data set --out");
  app.add_option(
      "--to-hdf5", o.to_hdf5,
      "write a split of the data set --out to this HDF5 file of samples, and its references to --reference");
  app.add_option("--hdf5-depth", o.depth,
                 "what depths of other programs' HDF5 files are: linear, or d / (d + 1)")
      ->check(CLI::IsMember({"linear", "ratio"}))
      ->capture_default_str();
  app.add_flag("--allow-identical", o.allow_identical, "let samples pass that are the same in every pixel");
}

bool is_hdf5(const Options& o) {
  return !o.from_hdf5.empty() || !o.to_hdf5.empty();
}

void need_split(const Options& o) {
  if (o.frame.empty() && o.place.split.empty())
    ld::fail_command_line("--out needs --split: train, validation or test");
}

void check(const Options& o) {
  if (o.place.sequence.has_value() != o.place.position.has_value())
    ld::fail_command_line("expected both --sequence and --position, or neither");
  if (o.place.sequence && (is_hdf5(o) || !o.frame.empty()))
    ld::fail_command_line(
        "--sequence and --position are places in a data set's manifest; neither HDF5 nor --frame goes with "
        "them");
  ld::require_extension("--frame", o.frame, {".exr"});
  ld::require_extension("--to-hdf5", o.to_hdf5, {".h5", ".hdf5"});
  if (!o.to_hdf5.empty()) ld::require_extension("--reference", o.reference, {".h5", ".hdf5"});
  if (is_hdf5(o)) {
    if (!o.from_hdf5.empty() && !o.to_hdf5.empty())
      ld::fail_command_line("expected either --from-hdf5 or --to-hdf5");
    if (o.place.folder.empty() || o.reference.empty() || (o.place.name.empty() && o.to_hdf5.empty()))
      ld::fail_command_line(
          "HDF5 needs --out, --reference and, to read it, --name, which the names of frames begin with");
    if (!o.files.empty() || !o.preset.empty() || !o.mapping.empty() || !o.frame.empty() || !o.view.empty() ||
        !o.also.empty())
      ld::fail_command_line(
          "HDF5 files have one layout: no preset, mapping, --view, --also, --frame or other files go with "
          "them");
    need_split(o);
    return;
  }
  if (o.preset.empty() == o.mapping.empty()) ld::fail_command_line("expected either --preset or --mapping");
  if (o.print_mapping && o.preset.empty())
    ld::fail_command_line("--print-mapping prints a preset; name it with --preset");
  if (o.print_mapping) return;
  if (o.frame.empty() == o.place.folder.empty())
    ld::fail_command_line("expected either --out for a data set or --frame for a frame alone");
  if (o.frame.empty() && (o.place.name.empty() || o.reference.empty()))
    ld::fail_command_line(
        "--out needs --name and --reference; a frame without a reference is written with --frame");
  need_split(o);
  if (!o.frame.empty() && !o.reference.empty())
    ld::fail_command_line("--frame takes no --reference; a pair belongs into a data set: --out and --name");
}

std::vector<std::filesystem::path> outputs_of(const Options& o) {
  std::vector<std::filesystem::path> outputs = {o.frame, o.to_hdf5};
  if (!o.to_hdf5.empty()) outputs.emplace_back(o.reference);
  if (!o.place.folder.empty() && !o.place.name.empty() && !is_hdf5(o)) {
    outputs.push_back(ld::frame_path(o.place.folder, o.place.name));
    outputs.push_back(ld::reference_path(o.place.folder, o.place.name));
    outputs.push_back(o.place.folder / "manifest.json");
  }
  return outputs;
}

std::vector<std::filesystem::path> inputs_of(const Options& o) {
  std::vector<std::filesystem::path> inputs = {o.mapping, o.camera, o.from_hdf5};
  if (o.to_hdf5.empty()) inputs.emplace_back(o.reference);
  inputs.insert(inputs.end(), o.files.begin(), o.files.end());
  return inputs;
}

ld::Hdf5Report exchange_hdf5(const Options& o) {
  if (!o.to_hdf5.empty()) return ld::data_set_to_hdf5(o.place.folder, o.place.split, o.to_hdf5, o.reference);
  ld::require_no_fault_in_hdf5(o.from_hdf5, o.reference);
  return ld::data_set_from_hdf5(o.from_hdf5, o.reference, o.place.folder, o.place.name, o.place.split,
                                o.depth == "ratio" ? ld::Hdf5Depth::ratio : ld::Hdf5Depth::linear);
}

void report(const Options& o, const ld::Hdf5Report& done) {
  if (done.stopped && !o.to_hdf5.empty()) {
    spdlog::warn("stopped after {} frames: {} and {} are not written; start the same command again",
                 done.frames, o.to_hdf5, o.reference);
    return;
  }
  spdlog::info("{} frames; left out {}; {} samples masked for NaN or infinity", done.frames,
               done.left_out.empty() ? "nothing" : fmt::format("{}", fmt::join(done.left_out, ", ")),
               done.faulty_samples);
  if (done.clamped > 0)
    spdlog::info("{} radiance channels of the samples were beyond half's range: darkened with their colours",
                 done.clamped);
  if (done.stopped)
    spdlog::warn("stopped: those {} frames are in {}, the others are not; start the same command again",
                 done.frames, o.place.folder.string());
}

void report(const ld::ImportedFrame& imported, const std::string& where) {
  ld::warn_about_faults(where, imported.faults);
  for (const std::string& note : imported.notes) spdlog::warn("{}: {}", where, note);
  if (!imported.repeated.empty())
    spdlog::warn("{}: {} the same in all samples: networks on samples learn less from it", where,
                 fmt::join(imported.repeated, ", "));
  if (imported.counts.above_maximum > 0)
    spdlog::info("{}: {} colour values above the mapping's maximum set to it", where,
                 imported.counts.above_maximum);
  if (imported.counts.beyond_half > 0)
    spdlog::warn("{}: {} depths beyond 65504 count as escaped; scale them with --set depth.scale=[...]",
                 where, imported.counts.beyond_half);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  ld::Application app("ld_import", "Turns renders of other programs into training frames.");
  declare(app.options(), options);
  app.options().footer(
      "Examples:\n"
      "  ld_import --preset cycles --camera camera.yaml --reference reference.exr --out my_data --name "
      "shot_0001 \\\n"
      "            --split train sample_*.exr\n"
      "  ld_import --preset mitsuba --print-mapping");
  return app.run(argc, argv, [&] {
    check(options);
    app.refuse_overwriting(outputs_of(options), inputs_of(options));
    std::vector<std::filesystem::path> to_write = outputs_of(options);
    to_write.emplace_back(app.json_path());
    ld::require_writable(to_write);
    if (is_hdf5(options)) {
      const ld::Hdf5Report done = exchange_hdf5(options);
      report(options, done);
      if (done.stopped && !options.to_hdf5.empty()) return;
      app.write_json({{"frames", done.frames},
                      {"left_out", done.left_out},
                      {"masked_samples", done.faulty_samples},
                      {"clamped", done.clamped}});
      return;
    }
    if (options.print_mapping) {
      std::cout << ld::preset_text(options.preset) << std::flush;
      return;
    }
    ld::ImportMapping mapping = ld::read_mapping(options.preset, options.mapping, options.assignments);
    if (!options.view.empty()) mapping.view = options.view;
    const bool alone = !options.frame.empty();
    if (!alone) ld::check_place(options.place);
    std::optional<ld::ViewCamera> camera;
    if (!options.camera.empty()) camera = ld::read_camera(options.camera);

    const ld::ImportedFrame imported = ld::import_frame({options.files.begin(), options.files.end()}, mapping,
                                                        camera, options.allow_identical, options.also);
    mapping.view = imported.view;  // of the reference, too
    const ld::Frame& frame = imported.frame;
    const std::string target = alone ? options.frame : options.place.name;
    report(imported, target);
    if (alone)
      ld::write_frame(options.frame, frame);
    else
      ld::add_to_data_set(options.place, frame, ld::import_picture(options.reference, mapping));

    std::vector<std::string> absent;
    for (const std::string& feature : ld::feature_names())
      if (!frame.holds(feature)) absent.push_back(feature);
    if (!imported.view_text.empty()) spdlog::info("{}: {}", target, imported.view_text);
    spdlog::info("{}: {} x {} pixels, {} samples; holds {}{}; absent {}", target, frame.width, frame.height,
                 frame.spp, fmt::join(frame.features, ", "), frame.alpha.empty() ? "" : ", alpha",
                 fmt::join(absent, ", "));
    for (const ld::LightPart& part : frame.parts)
      spdlog::info("{}: holds the part '{}' of the light", target, part.name);
    if (!imported.unused.empty())
      spdlog::info("{}: channels that no feature took: {}; --set FEATURE.channels=[...] names them", target,
                   fmt::join(imported.unused, ", "));
    app.write_json({{"width", frame.width},
                    {"height", frame.height},
                    {"samples", frame.spp},
                    {"features", frame.features},
                    {"absent", absent},
                    {"alpha", !frame.alpha.empty()},
                    {"unused_channels", imported.unused},
                    {"masked_samples", imported.faults.not_finite},
                    {"mended_guides", imported.faults.guides},
                    {"colours_above_maximum", imported.counts.above_maximum}});
  });
}
