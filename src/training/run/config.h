// Everything that `ld_train --config` reads. The defaults are the recipe of [MH20] (Munkberg and Hasselgren
// 2020), section 4.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/config_visitor.h"
#include "losses/clip_loss_config.h"
#include "losses/loss_names.h"
#include "models/network_config.h"

namespace ld {

/// One of several data sets.
struct DataSetConfig {
  std::string path;   // folder with manifest.json
  double weight = 1;  // crops come from each set in proportion, however many frames it has

  template <class Visitor>
  void visit(Visitor& v) {
    v.field("path", path);
    v.field("weight", weight, Range{1e-6, 1e6});
  }
};

struct DataConfig {
  std::string path;                  // folder with manifest.json
  std::vector<DataSetConfig> paths;  // several data sets, in place of `path`
  int64_t crop = 128;                // side of the square crops, pixels
  int64_t clip = 1;        // frames of a crop that follow one another in a sequence; 1: single frames
  int64_t batch = 4;       // crops a batch, of all processes together
  bool flips = true;       // mirror crops in x and in y, each half of the time
  bool rotations = true;   // turn crops by 0, 90, 180 or 270 degrees
  bool reversal = false;   // let half of the clips run backwards in time
  int64_t difficulty = 1;  // of so many crops of a frame, one is taken in proportion to how noisy it is
  // [LEAST, MOST]: how many of a frame's samples a batch uses (dataset/sample_draw.h); []: all of them.
  std::vector<int64_t> samples;
  int64_t validation_samples = 0;  // the first so many of each frame validate; 0: MOST, or all of them
  /// What the network's picture is compared with: the frames' references; or `samples`: those of a frame that
  /// the network does not see, so that noisy frames alone will do (training/held_out.h).
  std::string targets = "reference";
  int64_t held_out = 5;  // with targets from samples, one in so many frames validates, where no split says so
  double drop = 0;       // share of crops that lack a feature of network.optional, for each of them
  double exposure = 0;   // stops: radiance times 2^u, u uniform in [-exposure, exposure]
  bool colours = false;  // give crops red, green and blue in any of their six orders
  double tint = 0;       // radiance times a factor for each channel, uniform in [0, tint]; 0: none
  double stop = 0;       // share of clips that show one frame, with other samples each time
  double freeze = 0;     // share of clips that stay at one of their frames, likewise
  std::string cache;     // folder of cache files; "": .cache in each data set; none: no files
  int64_t cache_megabytes = 4096;  // memory for frames where no cache file can be written
  int64_t workers = 2;             // threads that prepare batches; 0: each when it is needed

  bool sample_targets() const { return targets == "samples"; }

  template <class Visitor>
  void visit(Visitor& v) {
    v.field("path", path);
    v.sections("paths", paths);
    v.field("crop", crop, Range{1, 16384});
    v.field("clip", clip, Range{1, 1024});
    v.field("batch", batch, Range{1, 4096});
    v.field("flips", flips);
    v.field("rotations", rotations);
    v.field("reversal", reversal);
    v.field("difficulty", difficulty, Range{1, 1024});
    v.field("samples", samples, Range{1, 4096});
    v.field("validation_samples", validation_samples, Range{0, 4096});
    v.field("targets", targets, {"reference", "samples"});
    v.field("held_out", held_out, Range{2, 1000});
    v.field("drop", drop, Range{0, 1});
    v.field("exposure", exposure, Range{0, 10});
    v.field("colours", colours);
    v.field("tint", tint, Range{0, 100});
    v.field("stop", stop, Range{0, 1});
    v.field("freeze", freeze, Range{0, 1});
    v.field("cache", cache);
    v.field("cache_megabytes", cache_megabytes, at_least(0));
    v.field("workers", workers, Range{0, 64});
  }
};

/// Schedule "one_cycle" (training/run/schedule.h).
struct OneCycleConfig {
  double rise = 0.3;    // share of the steps until the peak
  double start = 0.04;  // the first rate, as a fraction of the peak's
  double end = 4e-6;    // the last rate, likewise

  template <class Visitor>
  void visit(Visitor& v) {
    v.field("rise", rise, Range{0, 1});
    v.field("start", start, Range{1e-9, 1});
    v.field("end", end, Range{0, 1});
  }
};

struct OptimizerConfig {
  std::string name = "adam";          // Adam (Kingma and Ba 2015), or adamw (Loshchilov and Hutter 2019)
  double weight_decay = 0;            // of adamw: a step takes this times the rate of the weights away
  double learning_rate = 0.005;       // the highest rate of the schedule
  double beta1 = 0.9;                 // of Adam: decay of the averaged gradients
  double beta2 = 0.999;               // of Adam: decay of the averaged squares of gradients
  double epsilon = 1e-8;              // of Adam: added to the root of the averaged squares
  std::string schedule = "constant";  // of the learning rate (training/run/schedule.h)
  OneCycleConfig one_cycle;
  int64_t step_epochs = 100;  // of schedule "step": after so many epochs the rate falls
  double step_factor = 0.5;   // of schedule "step": the rate times this
  double ramp_epochs = 10;    // of schedule "inverse_root": epochs over which the rate rises
  double ramp_start = 0.1;    // of schedule "inverse_root": the first rate, as a fraction of the peak's
  int64_t warmup_steps = 0;   // the rate rises linearly over so many steps
  double clip_norm = 0;       // largest norm of all gradients together; 0: no limit
  double clip_value = 0;      // largest absolute gradient; 0: no limit
  int64_t accumulate = 1;     // batches a step: their gradients are averaged, in the memory that one takes
  int64_t truncation = 0;  // of networks that remember: frames that a gradient goes back through; 0: the clip
  bool recompute = false;  // of networks that remember: run frames again when their gradients are made, so
                           // that the activations of one frame exist at a time (a third more time)
  /// Of networks in two stages: which of them learns from what (training/optimizer/stage_scheme.h).
  std::string scheme = "end_to_end";
  double head_weight = 1;  // of scheme "two_heads": of the loss of the first stage
  double ema = 0;          // decay of the averaged weights (training/optimizer/weight_average.h); 0: none

  template <class Visitor>
  void visit(Visitor& v) {
    v.field("name", name, {"adam", "adamw"});
    v.field("weight_decay", weight_decay, Range{0, 1});
    v.field("learning_rate", learning_rate, Range{0, 10});
    v.field("beta1", beta1, Range{0, 0.999999});
    v.field("beta2", beta2, Range{0, 0.999999});
    v.field("epsilon", epsilon, Range{1e-30, 1});  // at 0, Adam divides 0 by 0
    v.field("schedule", schedule, {"constant", "step", "cosine", "one_cycle", "inverse_root"});
    v.section("one_cycle", one_cycle);
    v.field("step_epochs", step_epochs, at_least(1));
    v.field("step_factor", step_factor, Range{0, 1});
    v.field("ramp_epochs", ramp_epochs, Range{1e-6, 1e6});
    v.field("ramp_start", ramp_start, Range{1e-9, 1});
    v.field("warmup_steps", warmup_steps, at_least(0));
    v.field("clip_norm", clip_norm, at_least(0));
    v.field("clip_value", clip_value, at_least(0));
    v.field("accumulate", accumulate, Range{1, 4096});
    v.field("truncation", truncation, Range{0, 1024});
    v.field("recompute", recompute);
    v.field("scheme", scheme, {"end_to_end", "two_heads", "concurrent", "separate"});
    v.field("head_weight", head_weight, Range{0, 1e6});
    v.field("ema", ema, Range{0, 0.999999});
  }
};

/// How a run is followed, where it pauses and what it keeps. These may change between a run and its
/// continuation (but not `minutes`, which has become `steps`); what else may is in training/run/run_folder.h.
struct RunConfig {
  int64_t max_steps = 0;           // stop early after so many steps; 0: after the last epoch
  int64_t log_every = 50;          // steps between lines of metrics.csv
  int64_t validate_every = 500;    // steps between validations
  int64_t checkpoint_every = 500;  // steps between checkpoints; one is always written at the end
  double max_minutes = 0;          // stop after so much time since the program started; 0: no limit
  int64_t keep = 2;                // newest checkpoints kept, besides the best
  int64_t max_skipped = 10;        // so many steps in a row without a finite gradient end the run
  int64_t images = 4;              // validation frames in TensorBoard; 0: none
  double minutes = 0;  // a new run's schedule has as many steps as there is time for; 0: `epochs` decides
  std::string device = "cpu";  // where networks and losses run: cpu, or cuda, the first GPU that is visible

  template <class Visitor>
  void visit(Visitor& v) {
    v.field("max_steps", max_steps, at_least(0));
    v.field("log_every", log_every, at_least(1));
    v.field("validate_every", validate_every, at_least(1));
    v.field("checkpoint_every", checkpoint_every, at_least(1));
    v.field("max_minutes", max_minutes, Range{0, 1e7});
    v.field("keep", keep, Range{2, 10000});  // one to fall back on
    v.field("max_skipped", max_skipped, at_least(1));
    v.field("images", images, Range{0, 64});
    v.field("minutes", minutes, Range{0, 1e7});
    v.field("device", device, {"cpu", "cuda"});
  }
};

/// What counts as a collapse (training/run/collapse_watch.h), and what is done about it. May change between a
/// run and its continuation.
struct WatchConfig {
  bool enabled = true;       // notice a collapse and undo it
  double loss_factor = 1.5;  // a loss above this times the usual one is raised
  int64_t window = 25;       // steps whose median loss is looked at
  int64_t patience = 4;      // raised windows in a row that are a collapse
  double entropy = 0.1;      // kernels of a lower mean entropy, in nats, are one tap; 0: not watched
  int64_t retries = 3;       // times that a run goes back to its best checkpoint

  template <class Visitor>
  void visit(Visitor& v) {
    v.field("enabled", enabled);
    v.field("loss_factor", loss_factor, Range{1.01, 1e6});
    v.field("window", window, Range{1, 10000});
    v.field("patience", patience, Range{1, 10000});
    v.field("entropy", entropy, Range{0, 10});
    v.field("retries", retries, Range{0, 1000});
  }
};

struct TrainConfig {
  uint64_t seed = 1;           // of the first weights, of the order of the data, of the crops
  std::string init;            // weights to begin with: a weight file, checkpoint or run; "": random ones
  std::string loss = "smape";  // what a step makes smaller (docs/training.md)
  ClipLossConfig clip_loss;    // of clips: how the losses of their frames add up, and what comes beside
  int64_t epochs = 1000;  // length of the schedule; an epoch has a crop for each frame of the training splits
  int64_t steps = 0;      // length of the schedule in place of `epochs`; 0: run.minutes or `epochs` decide
  NetworkConfig network;
  DataConfig data;
  OptimizerConfig optimizer;
  RunConfig run;
  WatchConfig watch;

  template <class Visitor>
  void visit(Visitor& v) {
    v.field("seed", seed);
    v.field("init", init);
    v.field("loss", loss, loss_names());
    v.section("clip_loss", clip_loss);
    v.field("epochs", epochs, at_least(1));
    v.field("steps", steps, at_least(0));
    v.section("network", network);
    v.section("data", data);
    v.section("optimizer", optimizer);
    v.section("run", run);
    v.section("watch", watch);
  }
};

}  // namespace ld
