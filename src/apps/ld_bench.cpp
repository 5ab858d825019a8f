// Times operators and networks against their LibTorch compositions: `ld_bench ops`, `ld_bench network`; the
// renderer against Embree: `ld_bench render`; the filters pass by pass: `ld_bench filters`; says what the
// networks of training configurations cost: `ld_bench config FILE ...`; and sets the error of trained models
// against their time and memory: `ld_bench tradeoff --data DIR --model NAME=FILE ...`.

#include <filesystem>
#include <iostream>

#include "apps/app.h"
#include "benchmark/bench_report.h"
#include "benchmark/filter_speed.h"
#include "benchmark/loader.h"
#include "benchmark/network_sweeps.h"
#include "benchmark/render_speed.h"
#include "benchmark/size_times.h"
#include "benchmark/tradeoff.h"
#include "core/file_io.h"
#include "core/log.h"
#include "ops/runtime.h"

namespace {

struct Options {
  ld::BenchSizes sizes;
  ld::MeasureOptions measure;
  std::vector<std::string> only;
  std::vector<int64_t> spp = {1, 2, 4, 8, 16, 32, 64};
  std::string out;
  std::vector<std::string> files;
  ld::LoaderBench loader;
  ld::TradeoffOptions tradeoff;
  std::vector<std::string> filters, assignments;  // of the trade-off
};

/// Pictures of 32x32 with 2 samples and one run each: whether everything works, not how fast.
void make_quick(Options& options) {
  options.sizes.inference = options.sizes.training = 32;
  options.sizes.spp = 2;
  options.sizes.pictures = {{32, 32}, {48, 33}};
  options.measure.repeats = 1;
  options.spp = {1, 8};
}

/// Text to standard output and, with --out, a file.
void publish(const Options& options, const std::string& file, const std::string& table) {
  std::cout << table << "\n" << std::flush;
  if (!options.out.empty()) ld::write_file_atomically(std::filesystem::path(options.out) / file, table);
}

template <class Plot>
void draw(const Options& options, const std::string& file, const Plot& plot) {
  if (!options.out.empty())
    ld::write_file_atomically(std::filesystem::path(options.out) / file, ld::to_svg(plot));
}

template <class Row>
void add_names(const std::vector<Row>& rows, std::vector<std::string>& names) {
  for (const Row& row : rows) names.push_back(row.name);
}

double sgemm_speed(const Options& options) {
  return ld::sgemm_gflops(options.sizes.quick ? 256 : 2048, options.measure.repeats);
}

double memory_speed(const Options& options) {
  return ld::memory_gb_per_s(options.measure.repeats, int64_t(1) << (options.sizes.quick ? 20 : 25));
}

nlohmann::ordered_json run_rows(const Options& options, const std::vector<ld::RowSpec>& specs,
                                const std::string& name, int threads) {
  const double sgemm = sgemm_speed(options);
  spdlog::info("sgemm: {:.1f} GFLOP/s on {} threads", sgemm, threads);
  const auto rows = ld::run_rows(ld::chosen_rows(specs, options.only), options.measure, sgemm);
  if (!rows.empty()) publish(options, name + ".md", ld::markdown_rows(rows));
  nlohmann::ordered_json json = {{"version", LD_VERSION},
                                 {"threads", threads},
                                 {"quick", options.sizes.quick},
                                 {"inference_size", options.sizes.inference},
                                 {"training_size", options.sizes.training},
                                 {"spp", options.sizes.spp},
                                 {"sgemm_gflops", sgemm},
                                 {"rows", nlohmann::ordered_json::array()}};
  for (const ld::BenchRow& row : rows) json["rows"].push_back(ld::to_json(row));
  return json;
}

void run_sizes(const Options& options, const std::vector<ld::SizeRow>& rows, nlohmann::ordered_json& json) {
  const auto chosen = ld::chosen_rows(rows, options.only);
  if (chosen.empty()) return;
  const ld::MachineSpeed machine = {json.at("sgemm_gflops"), memory_speed(options)};
  json["memory_gb_per_s"] = machine.memory_gb_per_s;
  std::vector<ld::SizeTime> times;
  for (const ld::SizeRow& row : chosen) {
    spdlog::info("{} ...", row.name);
    times.push_back(ld::time_size(row, options.measure.repeats));
  }
  publish(options, "sizes.md", ld::markdown(times, machine));
  json["sizes"] = ld::to_json(times, machine);
}

void run_cost(const Options& options, nlohmann::ordered_json& json) {
  const auto costs = ld::cost_by_samples(options.sizes, options.spp);
  publish(options, "cost.md", ld::markdown(costs, options.spp));
  draw(options, "cost.svg", ld::figure(costs, options.spp));
  json["cost"] = ld::to_json(costs, options.spp);
}

void run_stages(const Options& options, nlohmann::ordered_json& json) {
  const auto stages = ld::time_by_stage(options.sizes, options.measure.repeats);
  publish(options, "stages.md", ld::markdown(stages));
  draw(options, "stages.svg", ld::figure(stages));
  json["stages"] = ld::to_json(stages);
}

void run_samples(const Options& options, nlohmann::ordered_json& json) {
  const auto times = ld::time_by_samples(options.sizes, options.spp, options.measure.repeats);
  publish(options, "samples.md", ld::markdown(times));
  draw(options, "samples.svg", ld::figure(times));
  json["samples"] = ld::to_json(times);
}

/// A table of its own, which --only picks like a row.
struct Sweep {
  std::string name;
  void (*run)(const Options&, nlohmann::ordered_json&);
};
std::vector<Sweep> sweeps() {
  return {{"cost", run_cost}, {"stages", run_stages}, {"samples", run_samples}};
}

nlohmann::ordered_json run_network(const Options& options, int threads) {
  const auto rows = ld::network_rows(options.sizes);
  const auto sizes = ld::size_rows(options.sizes);
  std::vector<std::string> names;
  add_names(rows, names);
  add_names(sizes, names);
  add_names(sweeps(), names);
  ld::check_only(options.only, names);
  auto json = run_rows(options, rows, "network", threads);
  run_sizes(options, sizes, json);
  for (const Sweep& sweep : ld::chosen_rows(sweeps(), options.only)) sweep.run(options, json);
  return json;
}

nlohmann::ordered_json run_ops(const Options& options, int threads) {
  const auto rows = ld::operator_rows(options.sizes);
  std::vector<std::string> names;
  add_names(rows, names);
  ld::check_only(options.only, names);
  return run_rows(options, rows, "ops", threads);
}

struct Commands {
  CLI::App *ops, *network, *render, *filters, *loader, *config, *tradeoff;
};

void declare_tradeoff(CLI::App& command, Options& options) {
  ld::TradeoffOptions& tradeoff = options.tradeoff;
  command.fallthrough();
  command.add_option("--data", tradeoff.data, "data set")->required();
  command.add_option("--split", tradeoff.split, "which frames")->capture_default_str();
  ld::repeated(command.add_option("--model", tradeoff.models,
                                  "NAME=FILE: weights, checkpoint or run; may be repeated (default: none)"));
  ld::repeated(
      command.add_option("--images", tradeoff.images,
                         "NAME=DIR: another denoiser's pictures of the same frames and its cost.json; may be "
                         "repeated (default: none)"));
  ld::repeated(command.add_option("--filter", options.filters,
                                  "eaw or svgf, or NAME= and one of them; may be repeated (default: none)"));
  ld::repeated(command.add_option("--set", options.assignments,
                                  "NAME.key=value for the filter of that name; may be repeated"));
  command.add_option("--metric", tradeoff.metric, "the error of the figure and of what counts as beaten")
      ->capture_default_str();
  command.add_option("--frames-limit", tradeoff.frames_limit, "only the first so many frames (default: all)");
  command
      .add_option("--samples", tradeoff.samples,
                  "only the first so many samples of each frame (default: all)")
      ->check(ld::whole_number_within(1, 4096));
  command.add_option("--repeats", tradeoff.repeats, "timed runs of each model on each frame")
      ->check(ld::whole_number_within(1, 1000))
      ->capture_default_str();
  command.add_option("--out", options.out,
                     "folder for tradeoff.md and tradeoff.svg (default: the table is printed, no more)");
}

void declare_loader(CLI::App& command, ld::LoaderBench& loader) {
  command.fallthrough();
  command.add_option("--data", loader.data, "data set")->required();
  command.add_option("--training", loader.training, "config that is trained on it")->capture_default_str();
  command.add_option("--network", loader.network, "config whose training step a batch is compared with")
      ->capture_default_str();
  command.add_option("--crop", loader.crop, "side of the crops, pixels")->capture_default_str();
  command.add_option("--batch", loader.batch, "crops a step")->capture_default_str();
  command.add_option("--workers", loader.workers, "threads that prepare batches")->capture_default_str();
  ld::repeated(command.add_option("--samples", loader.samples,
                                  "LEAST,MOST: samples that a batch draws (default: all)"))
      ->delimiter(',');
  command.add_option("--epochs", loader.epochs, "of each measurement")
      ->check(ld::whole_number_within(2, 1000))
      ->capture_default_str();
}

Commands declare(CLI::App& app, Options& options) {
  Commands commands;
  commands.ops = app.add_subcommand("ops", "each operator, forward and with its backward pass");
  commands.network = app.add_subcommand(
      "network",
      "whole networks; the runtime on several sizes; cost, time by stage and by number of samples");
  commands.render = app.add_subcommand("render", "the path tracer against Embree alone on the same rays");
  commands.filters = app.add_subcommand("filters", "EAW and SVGF at 1920x1080 and at half as many rows");
  commands.loader = app.add_subcommand("loader", "crops from a data set, and the making of their cache");
  declare_loader(*commands.loader, options.loader);
  commands.tradeoff =
      app.add_subcommand("tradeoff", "trained models on a data set: error against time and memory");
  declare_tradeoff(*commands.tradeoff, options);
  commands.config = app.add_subcommand("config", "what the networks of training configurations cost");
  commands.config->add_option("files", options.files, "YAML configurations")->required();
  for (CLI::App* command :
       {commands.ops, commands.network, commands.render, commands.filters, commands.config}) {
    command->fallthrough();  // --json, --threads after the subcommand
    command->add_option("--repeats", options.measure.repeats, "timed runs of each row")
        ->check(ld::whole_number_within(1, 1000))
        ->capture_default_str();
    command->add_flag("--quick", options.sizes.quick, "small networks, tiny pictures, one run: a test");
  }
  for (CLI::App* command : {commands.ops, commands.network}) {
    command->add_option(
        "--out", options.out,
        "folder for the tables (.md) and figures (.svg) (default: tables are printed, no more)");
    ld::repeated(command->add_option(
        "--only", options.only,
        "only this row, or of network the table cost, stages or samples; may be repeated (default: all)"));
    command->add_option("--configs", options.sizes.configs, "folder of the networks' YAML files")
        ->capture_default_str();
  }
  ld::repeated(
      commands.network->add_option(
          "--spp", options.spp, "numbers of samples, ascending, with commas, for cost and time by samples"))
      ->delimiter(',')
      ->check(ld::whole_number_within(1, 4096))
      ->capture_default_str();
  app.require_subcommand(1);
  app.footer(
      "ld_bench SUBCOMMAND --help lists the options of each.\n\n"
      "Examples:\n"
      "  ld_bench ops --quick\n"
      "  ld_bench tradeoff --data out/quickstart/data --model mine=out/run --out out/tradeoff");
  return commands;
}

nlohmann::ordered_json run_rendering(const Options& options, int threads) {
  const int size = options.sizes.quick ? 16 : 256;
  const auto speeds =
      ld::measure_rendering(size, options.sizes.quick ? 1 : 8, options.measure.repeats, threads);
  std::cout << ld::markdown(speeds, threads);
  return ld::to_json(speeds);
}

nlohmann::ordered_json run_filters(const Options& options, int threads) {
  const bool quick = options.sizes.quick;
  const auto times =
      ld::measure_filters(quick ? 48 : 1920, quick ? 32 : 1080, options.measure.repeats, threads);
  const ld::MachineSpeed machine = {sgemm_speed(options), memory_speed(options)};
  std::cout << ld::markdown(times, machine);
  return ld::to_json(times, machine);
}

nlohmann::ordered_json run_tradeoff(Options& options, int threads) {
  options.tradeoff.threads = threads;
  std::vector<std::string> assignments = options.assignments;
  options.tradeoff.filters = ld::parse_filter_arguments(options.filters, assignments);
  if (!assignments.empty())
    ld::fail_command_line("--set {}: no --filter has that name; expected NAME.key=value", assignments[0]);
  const auto tradeoff = ld::measure_tradeoff(options.tradeoff);
  if (!tradeoff) {
    spdlog::warn("stopped before the last frame: nothing was written, because half a set would mislead");
    return nullptr;
  }
  publish(options, "tradeoff.md", ld::markdown(*tradeoff));
  draw(options, "tradeoff.svg", ld::figure(*tradeoff));
  return ld::to_json(*tradeoff);
}

nlohmann::ordered_json run_configs(const Options& options) {
  nlohmann::ordered_json json;
  for (const std::string& file : options.files)
    json.push_back(ld::measure_network(file, options.sizes, options.measure.repeats));
  std::cout << json.dump(2) << "\n";
  return json;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  ld::Application app("ld_bench",
                      "Times operators, networks, the renderer and the loader; error against cost.");
  const Commands commands = declare(app.options(), options);

  return app.run(argc, argv, [&] {
    app.refuse_overwriting({}, {options.files.begin(), options.files.end()});
    ld::configure_runtime(app.threads());
    if (options.sizes.quick) make_quick(options);
    nlohmann::ordered_json json;
    if (commands.ops->parsed()) {
      json = run_ops(options, app.threads());
    } else if (commands.network->parsed()) {
      json = run_network(options, app.threads());
    } else if (commands.render->parsed()) {
      json = run_rendering(options, app.threads());
    } else if (commands.filters->parsed()) {
      json = run_filters(options, app.threads());
    } else if (commands.loader->parsed()) {
      json = ld::bench_loader(options.loader);
      std::cout << ld::markdown_loader(json);
    } else if (commands.tradeoff->parsed()) {
      json = run_tradeoff(options, app.threads());
    } else {
      json = run_configs(options);
    }
    if (!json.is_null()) app.write_json(json);
  });
}
