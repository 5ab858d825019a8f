// What the frame before has left, moved to where its surfaces are now, and what becomes of it
// (models/history.h, ops/kernels/warp_taps.h).
#include <array>

#include "export/onnx_walk.h"
#include "frame/schema.h"
#include "models/network_numbers.h"
#include "ops/kernels/warp_taps.h"

namespace ld {
namespace {

/// Graph::state in its order.
enum StatePart : size_t { kLight, kFrames, kSurface };

Value all_of(OnnxGraph& g, const std::vector<Value>& conditions) {
  Value all = conditions[0];
  for (size_t i = 1; i < conditions.size(); ++i) all = g.op("And", {all, conditions[i]});
  return all;
}

Value less(OnnxGraph& g, const Value& a, const Value& b) {
  return g.op("Greater", {b, a});
}
Value at_most(OnnxGraph& g, const Value& a, const Value& b) {
  return g.op("LessOrEqual", {a, b});
}
Value root(OnnxGraph& g, const Value& x) {
  return g.op("Sqrt", {x});
}
Value to_whole(OnnxGraph& g, const Value& x) {
  return g.op("Cast", {x}, {{"to", int64_t(onnx::TensorProto::INT64)}});
}

Value channels_from(OnnxGraph& g, const Value& planes, int64_t first, int64_t count) {
  return g.slice(planes, 1, first, first + count);
}

/// 0, 1, ..., `size` - 1 along the columns or rows of [1, 1, rows, columns].
Value counted_along(OnnxGraph& g, const Value& size, bool columns) {
  const Value numbers = g.op("Range", {g.number(0), g.squeeze(size, 0), g.number(1)});
  return g.reshape(numbers, {1, 1, columns ? 1 : -1, columns ? -1 : 1});
}

/// |n|, of the normal of a surface [B, 4, H, W].
Value length_of_normal(OnnxGraph& g, const Value& surface) {
  const Value n = channels_from(g, surface, 1, 3);
  return root(g, g.reduce_sum(g.mul(n, n), {1}));
}

/// may_be_same_surface() of two surfaces [B, 4, H, W].
Value may_be_same(OnnxGraph& g, const Value& a, const Value& b) {
  const Value one = g.number(1), ratio = g.number(float(kGuideDepthRatio));
  const Value depth_a = channels_from(g, a, 0, 1), depth_b = channels_from(g, b, 0, 1);
  const Value a_deeper = g.mul(depth_a, g.sub(one, depth_b)), b_deeper = g.mul(depth_b, g.sub(one, depth_a));
  const Value cosine = g.reduce_sum(g.mul(channels_from(g, a, 1, 3), channels_from(g, b, 1, 3)), {1});
  const Value lengths = g.mul(length_of_normal(g, a), length_of_normal(g, b));
  return all_of(g,
                {at_most(g, a_deeper, g.mul(ratio, b_deeper)), at_most(g, b_deeper, g.mul(ratio, a_deeper)),
                 at_most(g, g.mul(g.number(float(kGuideNormal)), lengths), cosine)});
}

/// Channels of the sample that stands for each pixel: of the valid ones that of the lower median depth, the
/// first of equals.
class Representative {
 public:
  Representative(OnnxWalk& at, int64_t depth) : g_(at.g), features_(at.read(0)), valid_(at.read(1)) {
    const Value drawn = g_.op("Not", {g_.is_zero(valid_)});
    // Of equal values TopK has the first first.
    const Value depths = g_.where(drawn, of_samples(depth, 1), g_.number(kInfinity));
    const Value order = g_.ops("TopK", {depths, g_.size_of(valid_, 1)}, 2,
                               {{"axis", int64_t{1}}, {"largest", int64_t{0}}, {"sorted", int64_t{1}}})[1];
    const Value count = g_.reduce_sum(g_.to_float(drawn), {1});
    const Value middle =
        g_.max(g_.op("Floor", {g_.mul(g_.sub(count, g_.number(1)), g_.number(0.5F))}), g_.number(0));
    none_ = g_.squeeze(g_.is_zero(count), 1);
    sample_ = g_.op("GatherElements", {order, to_whole(g_, middle)}, {{"axis", int64_t{1}}});
  }

  /// [B, count, H, W] of the features from `first` on; zeros where that is -1. `other` where no sample is
  /// valid.
  Value channels(int64_t first, int64_t count, float other) const {
    const Value index = g_.expand(sample_, {1, 1, count, 1, 1});
    const Value taken =
        g_.squeeze(g_.op("GatherElements", {of_samples(first, count), index}, {{"axis", int64_t{1}}}), 1);
    return g_.where(none_, g_.number(other), taken);
  }
  /// [B, 1, H, W]: where no sample is valid.
  const Value& none() const { return none_; }

 private:
  Value of_samples(int64_t first, int64_t count) const {
    if (first >= 0) return g_.slice(features_, 2, first, first + count);
    return g_.expand(g_.mul(valid_, g_.number(0)), {1, 1, count, 1, 1});
  }

  OnnxGraph& g_;
  Value features_, valid_, none_, sample_;
};

}  // namespace

void to_onnx(const graph::Recall& op, OnnxWalk& at) {
  OnnxGraph& g = at.g;
  const Representative shown(at, op.depth);
  const Value surface = g.concat({shown.channels(op.depth, 1, 0), shown.channels(op.normal, 3, 0)}, 1);
  const Value before = at.state(kLight), frames = at.state(kFrames), seen = at.state(kSurface);

  // The encoding "squash" (frame/encoding.h), infinite where nothing finite is encoded so, and nowhere.
  const Value encoded = shown.channels(op.flow, 2, 1), flow_room = g.sub(g.number(1), g.op("Abs", {encoded})),
              no_flow = at_most(g, flow_room, g.number(0));
  const Value flow = g.where(no_flow, g.number(kInfinity),
                             g.div(g.mul(g.number(float(find_feature("flow").scale)), encoded),
                                   g.where(no_flow, g.number(1), flow_room)));

  const Value width = at.width(at.out()), height = at.height(at.out()), w = g.to_float(width),
              h = g.to_float(height), minus_one = g.number(-1), zero = g.number(0), one = g.number(1);
  const Value x = g.add(counted_along(g, w, true), channels_from(g, flow, 0, 1)),
              y = g.add(counted_along(g, h, false), channels_from(g, flow, 1, 1));
  // Written so that NaN is outside too.
  const Value inside =
      all_of(g, {less(g, minus_one, x), less(g, x, w), less(g, minus_one, y), less(g, y, h)});
  const Value in_x = g.where(inside, x, zero), in_y = g.where(inside, y, zero);
  const Value left = g.op("Floor", {in_x}), top = g.op("Floor", {in_y});
  const Value fx = g.sub(in_x, left), fy = g.sub(in_y, top);

  // All that is looked up, one behind the other: [B, C + 1 + 4, H W].
  const int64_t channels = at.out(0).channels, all = channels + 5;
  const Value planes = g.reshape(g.concat({before, frames, seen}, 1), {at.batch(), all, -1});
  std::array<Value, 4> weights, found;
  for (int i = 0; i < 4; ++i) {
    const bool right = i % 2 != 0, low = i / 2 != 0;
    const Value column = right ? g.add(left, one) : left, row = low ? g.add(top, one) : top;
    const Value share = g.mul(right ? fx : g.sub(one, fx), low ? fy : g.sub(one, fy));
    const Value held_column = g.max(g.min(column, g.sub(w, one)), zero),
                held_row = g.max(g.min(row, g.sub(h, one)), zero);
    const Value place = g.add(g.mul(to_whole(g, held_row), width), to_whole(g, held_column));
    const Value index = g.expand(g.reshape(place, {at.batch(), 1, -1}), {1, all, 1});
    found[size_t(i)] = g.reshape(g.op("GatherElements", {planes, index}, {{"axis", int64_t{2}}}),
                                 {at.batch(), all, height, width});
    const Value there = found[size_t(i)];
    const Value counts =
        all_of(g, {inside, g.op("Equal", {column, held_column}), g.op("Equal", {row, held_row}),
                   less(g, zero, channels_from(g, there, channels, 1)),
                   may_be_same(g, surface, channels_from(g, there, channels + 1, 4))});
    weights[size_t(i)] = g.where(counts, share, zero);
  }
  Value sum = weights[0];
  for (size_t i = 1; i < 4; ++i) sum = g.add(sum, weights[i]);
  const Value valid = at_most(g, g.number(float(kLeastWarpWeight)), sum);
  const Value whole = g.where(valid, sum, one);
  Value past;
  for (size_t i = 0; i < 4; ++i) {
    const Value part =
        g.mul(g.where(valid, g.div(weights[i], whole), zero), channels_from(g, found[i], 0, channels + 1));
    past = i == 0 ? part : g.add(past, part);
  }
  at.make(g.unsqueeze(channels_from(g, past, 0, channels), 1), 0);
  at.make(g.unsqueeze(channels_from(g, past, channels, 1), 1), 1);
  at.make(g.unsqueeze(surface, 1), 2);
}

/// Means over the neighbourhood in place of sums: r and s are ratios.
void to_onnx(const graph::Compare& op, OnnxWalk& at) {
  OnnxGraph& g = at.g;
  const Value frames = at.read_picture(2), one = g.number(1), none = g.is_zero(frames);
  const Value known = g.where(none, g.number(0), one);
  const auto told = [&](size_t input) {
    return g.min(channels_from(g, at.read_picture(input), 0, 3), g.number(float(kLargestCompared)));
  };
  const Value now = told(0), past = told(1);
  const Value difference = g.mul(known, g.sub(past, now)), sum = g.mul(known, g.add(past, now));
  const auto over_neighbourhood = [&](const Value& x) {
    const int64_t side = 2 * op.radius + 1;
    return g.op("AveragePool", {x},
                {{"kernel_shape", std::vector<int64_t>{side, side}},
                 {"pads", std::vector<int64_t>(4, op.radius)},
                 {"count_include_pad", int64_t{1}}});
  };
  const auto relative = [&](const Value& d, const Value& t) {
    const Value ratio = g.div(g.op("Abs", {d}), g.where(g.is_zero(t), one, t));
    return g.div(g.reduce_sum(ratio, {1}), g.number(3));
  };
  const Value seen =
      g.concat({relative(difference, sum), relative(over_neighbourhood(difference), over_neighbourhood(sum)),
                g.div(one, g.where(none, one, frames))},
               1);
  at.make_picture(g.mul(known, seen));
}

void to_onnx(const graph::Remember&, OnnxWalk& at) {
  OnnxGraph& g = at.g;
  const Value before = at.read(3), none = g.is_zero(before), one = g.number(1), zero = g.number(0);
  const Value n = g.where(none, one, before);
  const Value k = g.where(none, zero, g.op("Sigmoid", {g.add(at.read(0), g.log(n))})), rest = g.sub(one, k);
  const Value share = g.add(g.mul(g.mul(rest, rest), n), g.mul(k, k));

  const Value light = at.read(1), past = at.read(2);
  const auto told = [&](const Value& x) {
    return g.reduce_sum(g.min(g.slice(x, 2, 0, 3), g.number(float(kLargestCompared))), {2});
  };
  const Value most = told(past), dark = g.is_zero(most);
  const Value believed = g.where(
      dark, one,
      g.min(g.div(g.mul(g.number(float(kBrightestHistory)), told(light)), g.where(dark, one, most)), one));
  at.make(g.add(light, g.mul(k, g.sub(g.mul(believed, past), light))), 0);
  at.make(g.mul(at.read(4), g.min(g.div(n, share), g.number(float(kLongestHistory)))), 1);
}

}  // namespace ld
