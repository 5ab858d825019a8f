// What a pixel's samples have together.
#include <algorithm>
#include <limits>

#include "ops/kernels/tone_map_row.h"
#include "runtime/frame_exposure.h"
#include "runtime/row_step.h"
#include "runtime/statistics_rows.h"

namespace ld {
std::unique_ptr<Step> make_step(const graph::MaskedMean&, const graph::Node& node, StepContext& context) {
  const RowWindow values = context.input(node, 0), valid = context.input(node, 1), out = context.output(node);
  return row_step(context, valid.pitch, [=](int64_t y, float* share) {
    shares(valid, y, share);
    for (int64_t c = 0; c < out.planes; ++c)
      mean_of(
          valid, y, share, [&](int64_t s) { return values.row(y, s * out.planes + c); }, out.row(y, c));
  });
}

std::unique_ptr<Step> make_step(const graph::Statistics&, const graph::Node& node, StepContext& context) {
  const RowWindow values = context.input(node, 0), valid = context.input(node, 1), out = context.output(node);
  return row_step(context, 2 * valid.pitch, [=](int64_t y, float* share) {
    shares(valid, y, share);
    const int64_t channels = out.planes / 2;
    for (int64_t c = 0; c < channels; ++c)
      mean_and_variance(
          valid, y, share, [&](int64_t s) { return values.row(y, s * channels + c); }, share + valid.pitch,
          out.row(y, c), out.row(y, channels + c));
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
