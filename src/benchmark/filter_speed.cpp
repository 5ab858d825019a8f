#include "benchmark/filter_speed.h"

#include <fmt/format.h>

#include <cmath>

#include "benchmark/measure.h"
#include "core/text_table.h"
#include "filters/frame_filter.h"
#include "runtime/parallel.h"

namespace ld {
namespace {

/// Boxes of 100 pixels a side before one another, lit with noise; all move by a fraction of a pixel.
Frame box_frame(int width, int height, int threads) {
  Frame frame(width, height, 1, kAllChannels);
  frame.features = filter_features();
  frame.features.emplace_back("radiance");
  frame.info.depth_scale = 10;
  frame.info.world_to_camera = Matrix4{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  // ndc = x / -z: a view of 90 degrees along -z
  frame.info.world_to_ndc = Matrix4{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, -1, 0, 0, 0, 0};
  const int albedo = find_feature("albedo").offset;
  parallel_for(threads, height, [&](int64_t y, int) {
    auto noise = uint32_t(y + 1) * 2654435769U;
    for (int x = 0; x < width; ++x) {
      const size_t p = size_t(y) * size_t(width) + size_t(x);
      const int64_t box = 1 + x / 100 + 40 * (y / 100);
      const float angle = 0.3F * std::sin(0.05F * float(x) + float(box));
      frame.plane(0, kIdOffset)[p] = float(box);
      frame.plane(0, kDepthOffset)[p] = 8 + float(box % 5) + 0.002F * float(x % 100);
      frame.plane(0, kNormalOffset)[p] = std::sin(angle);
      frame.plane(0, kNormalOffset + 2)[p] = std::cos(angle);
      frame.plane(0, kFlowOffset)[p] = 0.25F;
      frame.plane(0, kFlowOffset + 1)[p] = 0.5F;
      for (int c = 0; c < 3; ++c) {
        noise = noise * 1664525U + 1013904223U;
        const float direct = float(noise >> 8) * 0x1p-24F, indirect = float(noise & 0xffU) * 0x1p-8F;
        frame.plane(0, albedo + c)[p] = 0.5F;
        frame.plane(0, kDirectOffset + c)[p] = direct;
        frame.plane(0, kIndirectOffset + c)[p] = indirect;
        frame.plane(0, kRadianceOffset + c)[p] = direct + indirect;
      }
    }
  });
  return frame;
}

/// One filter that walks a sequence, and its passes alone.
class TimedFilter {
 public:
  TimedFilter(const std::string& kind, int signals, const Frame& frame, int threads)
      : name_(fmt::format("{}_{}_{}x{}", kind, signals, frame.width, frame.height)),
        frame_(frame),
        signals_(signals),
        threads_(threads),
        filter_({kind, kind, {signals == 1 ? "split=false" : "split=true"}}) {
    svgf_.light.split = signals == 2;
    constexpr int kSettled = 5;  // frames until all pixels have their own variance
    for (int i = 0; i < kSettled; ++i) denoise();
    read();
    if (!filter_.is_temporal()) return;
    // A history of its own, as the filter leaves it.
    for (int i = 0; i < kSettled; ++i) {
      svgf(surfaces_, light_.signals, state_, memory_, svgf_, threads_);
      read();
    }
  }

  void time() {
    whole_.push_back(time_ms([&] { denoise(); }));
    guides_.push_back(time_ms([&] { read(); }));
    if (filter_.is_temporal()) {
      const double all = time_ms([&] { svgf(surfaces_, light_.signals, state_, memory_, svgf_, threads_); });
      read();
      temporal_.push_back(time_ms([&] { temporal(); }));
      levels_.push_back(all - temporal_.back());
    } else {
      levels_.push_back(time_ms([&] { eaw(surfaces_, light_.signals, spare_, eaw_, threads_); }));
    }
  }

  FilterTime result() const {
    FilterTime time;
    time.name = name_;
    time.ms = median(whole_);
    time.guides_ms = median(guides_);
    time.levels_ms = median(levels_);
    if (filter_.is_temporal()) time.temporal_ms = median(temporal_);
    const double pixels = double(frame_.width) * double(frame_.height), n = signals_;
    const double taps = 24.0 * double(eaw_.levels) * pixels, exp2 = 13;
    // Frame to guides: samples in, surfaces, flow, albedo, emission and signals out. Then signals, albedo and
    // emission to the picture, and that to the image.
    double planes = 20 + 3 * n + 17 + 3 * n + 15;
    if (filter_.is_temporal()) {
      // w_n 12, w_z 5, h 1; a signal: luminance 5, w_l 3, h w 1, sums 7, variance 3
      time.operations = taps * (18 + n * (19 + exp2));
      planes += double(svgf_.levels) * (7 + 8 * n);  // id, normal, depth, slopes; light in and out
      planes += 3 + 15 + (3 + 3 + 4 + 6) * n + 2;    // slopes; surfaces, flow, signals twice, history
      planes += n + 9;                               // variances in recombination; antialiasing
    } else {
      // guides 19; a signal: |d|^2 8, w 2, h w 1, sums 7
      time.operations = taps * (19 + n * (18 + exp2));
      planes += double(eaw_.levels) * (7 + 6 * n);  // id, normal, position; light in and out
    }
    time.bytes = planes * pixels * sizeof(float);
    return time;
  }

 private:
  void denoise() {
    sequence_.advance(SequencePlace{0, position_++}, frame_.width, frame_.height);
    filter_.denoise(frame_, sequence_, threads_);
  }
  void read() { read_guides(frame_, svgf_.light, surfaces_, light_, threads_); }
  void temporal() {
    depth_slopes(surfaces_, memory_.slopes, threads_);
    accumulate(surfaces_, memory_.slopes, light_.signals, state_, svgf_, memory_.light[0], memory_.moments,
               threads_);
    estimate_variance(surfaces_, memory_.slopes, memory_.moments, memory_.light[0], memory_.light[1], svgf_,
                      threads_);
  }

  std::string name_;
  const Frame& frame_;
  int signals_, threads_;
  FrameFilter filter_;
  SequenceState sequence_;
  int64_t position_ = 0;
  EawSettings eaw_;
  SvgfSettings svgf_;
  Surfaces surfaces_;
  Illumination light_;
  RowPlanes spare_;
  SvgfState state_;
  SvgfMemory memory_;
  std::vector<double> whole_, guides_, temporal_, levels_;
};

double arithmetic_ms(const FilterTime& time, const MachineSpeed& machine) {
  return 1e-6 * time.operations / machine.sgemm_gflops;
}

double memory_ms(const FilterTime& time, const MachineSpeed& machine) {
  return 1e-6 * time.bytes / machine.memory_gb_per_s;
}

}  // namespace

std::vector<FilterTime> measure_filters(int width, int height, int repeats, int threads) {
  std::vector<Frame> frames;
  frames.push_back(box_frame(width, height / 2, threads));
  frames.push_back(box_frame(width, height, threads));
  std::vector<FilterTime> times;
  for (const std::string& kind : filter_kinds())
    for (const int signals : {1, 2}) {
      TimedFilter half(kind, signals, frames[0], threads), whole(kind, signals, frames[1], threads);
      for (int i = 0; i < repeats; ++i) {  // in turns
        half.time();
        whole.time();
      }
      times.push_back(half.result());
      times.push_back(whole.result());
    }
  return times;
}

std::string markdown(const std::vector<FilterTime>& times, const MachineSpeed& machine) {
  std::vector<TableRow> table = {{"filter, signals, size", "ms", "guides", "temporal", "levels", "rest",
                                  "arithmetic alone", "memory alone"}};
  const auto shared = [](double ms, double whole) {
    return fmt::format("{:.0f} ({:.0f} %)", ms, 100 * ms / whole);
  };
  for (const FilterTime& time : times)
    table.push_back({time.name, fmt::format("{:.0f}", time.ms), fmt::format("{:.0f}", time.guides_ms),
                     fmt::format("{:.0f}", time.temporal_ms), fmt::format("{:.0f}", time.levels_ms),
                     fmt::format("{:.0f}", time.ms - time.guides_ms - time.temporal_ms - time.levels_ms),
                     shared(arithmetic_ms(time, machine), time.ms),
                     shared(memory_ms(time, machine), time.ms)});
  return markdown_table(table, 1) + fmt::format("\nsgemm {:.1f} GFLOP/s, memory {:.1f} GB/s.\n",
                                                machine.sgemm_gflops, machine.memory_gb_per_s);
}

nlohmann::ordered_json to_json(const std::vector<FilterTime>& times, const MachineSpeed& machine) {
  nlohmann::ordered_json json = {{"sgemm_gflops", machine.sgemm_gflops},
                                 {"memory_gb_per_s", machine.memory_gb_per_s},
                                 {"filters", nlohmann::ordered_json::array()}};
  for (const FilterTime& time : times)
    json["filters"].push_back({{"name", time.name},
                               {"ms", time.ms},
                               {"guides_ms", time.guides_ms},
                               {"temporal_ms", time.temporal_ms},
                               {"levels_ms", time.levels_ms},
                               {"operations", time.operations},
                               {"bytes", time.bytes},
                               {"arithmetic_ms", arithmetic_ms(time, machine)},
                               {"memory_ms", memory_ms(time, machine)}});
  return json;
}

}  // namespace ld
