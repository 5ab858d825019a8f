#include <algorithm>

#include "graph/operators.h"

namespace ld::graph {
namespace {

/// One past the last input row for output rows before `end`.
struct ReadTo {
  int64_t end, height;
  template <class Op>
  int64_t operator()(const Op&) const {
    return end;
  }
  /// Rows are made in pairs (ops/kernels/winograd.h).
  int64_t operator()(const Convolution&) const { return (end + 1) / 2 * 2 + 1; }
  int64_t operator()(const EdgeConvolution& op) const { return end + op.kernel / 2; }
  int64_t operator()(const SpaceToDepth&) const { return 2 * end; }
  int64_t operator()(const HalveLight&) const { return 2 * end; }
  int64_t operator()(const DepthToSpace&) const { return (end + 1) / 2; }
  int64_t operator()(const GatherTaps& op) const { return end + op.kernel / 2; }
  int64_t operator()(const MaxPool&) const { return 2 * end; }
  int64_t operator()(const Halve&) const { return 2 * end; }
  int64_t operator()(const Received& op) const { return end + op.kernel / 2; }
  /// Bilinear: with n = 2^levels, row y blends (y - n / 2) / n, rounded down, and the next.
  int64_t operator()(const Upsample& op) const {
    const int64_t n = int64_t(1) << op.levels;
    return op.bilinear ? (end - 1 + n / 2) / n + 1 : (end - 1) / n + 1;
  }
  /// Whole strips of sources.
  int64_t operator()(const Splat& op) const {
    return (end + op.kernel / 2 + op.rows - 1) / op.rows * op.rows;
  }
  int64_t operator()(const Gather& op) const { return end + op.kernel / 2; }
  int64_t operator()(const Blur& op) const { return end + op.kernel / 2; }
  int64_t operator()(const ModulationFactors&) const { return end + 1; }
  int64_t operator()(const Compare& op) const { return end + op.radius; }
};

/// The first input row that output rows from `begin` on still read.
struct ReadFrom {
  int64_t begin, height;
  template <class Op>
  int64_t operator()(const Op&) const {
    return begin;
  }
  /// The last row is there again for those that are padded to.
  int64_t operator()(const Pad&) const { return std::min(begin, height - 1); }
  int64_t operator()(const Convolution&) const { return begin / 2 * 2 - 1; }
  int64_t operator()(const EdgeConvolution& op) const { return begin - op.kernel / 2; }
  int64_t operator()(const SpaceToDepth&) const { return 2 * begin; }
  int64_t operator()(const HalveLight&) const { return 2 * begin; }
  int64_t operator()(const DepthToSpace&) const { return begin / 2; }
  int64_t operator()(const GatherTaps& op) const { return begin - op.kernel / 2; }
  int64_t operator()(const MaxPool&) const { return 2 * begin; }
  int64_t operator()(const Halve&) const { return 2 * begin; }
  int64_t operator()(const Received& op) const { return begin - op.kernel / 2; }
  int64_t operator()(const Upsample& op) const {
    const int64_t n = int64_t(1) << op.levels;
    return op.bilinear ? (begin + n / 2) / n - 1 : begin / n;
  }
  /// What the rows before have read is summed already.
  int64_t operator()(const Splat& op) const {
    return begin == 0 ? 0 : (begin + op.kernel / 2 + op.rows - 1) / op.rows * op.rows;
  }
  int64_t operator()(const Gather& op) const { return begin - op.kernel / 2; }
  int64_t operator()(const Blur& op) const { return begin - op.kernel / 2; }
  int64_t operator()(const ModulationFactors&) const { return begin - 1; }
  int64_t operator()(const Compare& op) const { return begin - op.radius; }
};

/// What reads neighbours, or has its own way with borders.
struct ReadsAround {
  template <class Op>
  bool operator()(const Op&) const {
    return false;
  }
  bool operator()(const Pad&) const { return true; }
  bool operator()(const Convolution&) const { return true; }
  bool operator()(const EdgeConvolution&) const { return true; }
  bool operator()(const SpaceToDepth&) const { return true; }
  bool operator()(const HalveLight&) const { return true; }
  bool operator()(const DepthToSpace&) const { return true; }
  bool operator()(const GatherTaps&) const { return true; }
  bool operator()(const MaxPool&) const { return true; }
  bool operator()(const Upsample&) const { return true; }
  bool operator()(const Halve&) const { return true; }
  bool operator()(const Received&) const { return true; }
  bool operator()(const Splat&) const { return true; }
  bool operator()(const Gather&) const { return true; }
  bool operator()(const Blur&) const { return true; }
  bool operator()(const ModulationFactors&) const { return true; }
  bool operator()(const Recall&) const { return true; }  // of the frame before
  bool operator()(const Compare&) const { return true; }
  bool operator()(const RecallPart&) const { return true; }  // of the frame before
};

}  // namespace

bool is_pixelwise(const Operator& op) {
  return !std::visit(ReadsAround(), op);
}

int64_t rows_read_to(const Operator& op, int64_t end, int64_t height) {
  return std::clamp<int64_t>(std::visit(ReadTo{end, height}, op), 0, height);
}

int64_t rows_read_from(const Operator& op, int64_t begin, int64_t height) {
  return std::clamp<int64_t>(std::visit(ReadFrom{begin, height}, op), 0, height);
}

Span pixels_read(const Operator& op, Span made, int64_t size) {
  if (made.empty()) return {};
  if (const auto* splat = std::get_if<Splat>(&op))  // strips say what is kept, not what is sent
    return {std::max<int64_t>(made.begin - splat->kernel / 2, 0),
            std::min(made.end + splat->kernel / 2, size)};
  return {rows_read_from(op, made.begin, size), rows_read_to(op, made.end, size)};
}

}  // namespace ld::graph
