// What a pixel's samples have together.
#include <algorithm>
#include <limits>

#include "ops/kernels/tone_map_row.h"
#include "runtime/frame_exposure.h"
#include "runtime/parallel.h"
#include "runtime/step.h"

namespace ld {
namespace {

/// A step of which each row is made by itself, in a row of memory of its own.
template <class Row>
class RowStep : public Step {
 public:
  RowStep(StepContext& context, int64_t scratch, Row row)
      : context_(context),
        row_(std::move(row)),
        scratch_(size_t(context.threads), std::vector<float>(size_t(scratch))) {}
  void run(int64_t begin, int64_t end) override {
    parallel_for(context_.threads, end - begin,
                 [&](int64_t i, int thread) { row_(begin + i, scratch_[size_t(thread)].data()); });
  }

 private:
  StepContext& context_;
  Row row_;
  std::vector<std::vector<float>> scratch_;
};

template <class Row>
std::unique_ptr<Step> row_step(StepContext& context, int64_t scratch, Row row) {
  return std::make_unique<RowStep<Row>>(context, scratch, std::move(row));
}

/// What each valid item of a pixel counts for in a mean.
void shares(const RowWindow& valid, int64_t y, float* __restrict share) {
  const int64_t width = valid.width;
  std::fill_n(share, width, 0.0f);
  for (int64_t s = 0; s < valid.planes; ++s) {
    const float* __restrict drawn = valid.row(y, s);
    for (int64_t x = 0; x < width; ++x) share[x] += drawn[x];
  }
  for (int64_t x = 0; x < width; ++x) share[x] = 1 / std::max(share[x], 1.0f);
}

/// out = the mean of channel c over the valid items, of value(item's row, x).
template <class Value>
void mean_of(const RowWindow& values, const RowWindow& valid, int64_t y, int64_t c,
             const float* __restrict share, float* __restrict out, const Value& value) {
  const int64_t channels = values.planes / valid.planes, width = values.width;
  std::fill_n(out, width, 0.0f);
  for (int64_t s = 0; s < valid.planes; ++s) {
    const float* __restrict drawn = valid.row(y, s);
    const float* __restrict from = values.row(y, s * channels + c);
    for (int64_t x = 0; x < width; ++x) out[x] += drawn[x] * share[x] * value(from, x);
  }
}

}  // namespace

std::unique_ptr<Step> make_step(const graph::MaskedMean&, const graph::Node& node, StepContext& context) {
  const RowWindow values = context.input(node, 0), valid = context.input(node, 1), out = context.output(node);
  return row_step(context, valid.pitch, [=](int64_t y, float* share) {
    shares(valid, y, share);
    for (int64_t c = 0; c < out.planes; ++c)
      mean_of(values, valid, y, c, share, out.row(y, c),
              [](const float* from, int64_t x) { return from[x]; });
  });
}

std::unique_ptr<Step> make_step(const graph::Statistics&, const graph::Node& node, StepContext& context) {
  const RowWindow values = context.input(node, 0), valid = context.input(node, 1), out = context.output(node);
  return row_step(context, 2 * valid.pitch, [=](int64_t y, float* share) {
    float* missed = share + valid.pitch;
    shares(valid, y, share);
    const int64_t channels = out.planes / 2;
    for (int64_t c = 0; c < channels; ++c) {
      float* mean = out.row(y, c);
      mean_of(values, valid, y, c, share, mean, [](const float* from, int64_t x) { return from[x]; });
      // The mean of many values is rounded; what it misses is the mean of the rest.
      mean_of(values, valid, y, c, share, missed,
              [=](const float* from, int64_t x) { return from[x] - mean[x]; });
      mean_of(values, valid, y, c, share, out.row(y, channels + c), [=](const float* from, int64_t x) {
        const float rest = from[x] - mean[x] - missed[x];
        return rest * rest;
      });
      for (int64_t x = 0; x < out.width; ++x) mean[x] += missed[x];
    }
  });
}

std::unique_ptr<Step> make_step(const graph::AnyValid&, const graph::Node& node, StepContext& context) {
  const RowWindow valid = context.input(node, 0), out = context.output(node);
  return row_step(context, 0, [=](int64_t y, float*) {
    for (int64_t x = 0; x < out.width; ++x) {
      float any = 0;
      for (int64_t s = 0; s < valid.planes; ++s) any = std::max(any, valid.row(y, s)[x]);
      out.row(y)[x] = any;
    }
  });
}

std::unique_ptr<Step> make_step(const graph::LogValid&, const graph::Node& node, StepContext& context) {
  const RowWindow valid = context.input(node, 0), out = context.output(node);
  return row_step(context, 0, [=](int64_t y, float*) {
    for (int64_t s = 0; s < valid.planes; ++s)
      for (int64_t x = 0; x < out.width; ++x)
        out.row(y, s)[x] = valid.row(y, s)[x] != 0 ? 0.0f : -std::numeric_limits<float>::infinity();
  });
}

std::unique_ptr<Step> make_step(const graph::FirstValid&, const graph::Node& node, StepContext& context) {
  const RowWindow values = context.input(node, 0), valid = context.input(node, 1), out = context.output(node);
  return row_step(context, 0, [=](int64_t y, float*) {
    const int64_t channels = values.planes / valid.planes;
    for (int64_t x = 0; x < out.width; ++x) {
      int64_t first = 0;
      while (first + 1 < valid.planes && valid.row(y, first)[x] == 0) ++first;
      if (valid.row(y, first)[x] == 0) first = 0;
      for (int64_t s = 0; s < valid.planes; ++s) {
        const int64_t from = valid.row(y, s)[x] != 0 ? s : first;
        for (int64_t c = 0; c < channels; ++c)
          out.row(y, s * channels + c)[x] = values.row(y, from * channels + c)[x];
      }
    }
  });
}

std::unique_ptr<Step> make_step(const graph::ToneMapped& op, const graph::Node& node, StepContext& context) {
  const RowWindow values = context.input(node, 0), radiance = context.input(node, 1),
                  valid = context.input(node, 2), out = context.output(node);
  return row_step(context, 0, [=, &context](int64_t y, float*) {
    for (int64_t c = 0; c < out.planes; ++c) std::copy_n(values.row(y, c), out.width, out.row(y, c));
    for (int64_t c = 0; c < 3; ++c) {
      float* tone = out.row(y, op.first + c);
      expose_row(radiance.row(y, c), context.exposure, tone, out.width);
      tone_map_row(tone, tone, out.width);
      for (int64_t x = 0; x < out.width; ++x) tone[x] *= valid.row(y)[x];
    }
  });
}

}  // namespace ld
