#include "runtime/row_schedule.h"

#include <algorithm>
#include <variant>

namespace ld {

using graph::Graph;
using graph::ValueId;

/// How far everything has come.
struct RowSchedule::Walk {
  const RowSchedule& schedule;
  const Run& run;
  std::vector<int64_t> made;  // rows of each unit
  int64_t handed_out = 0;     // rows of the outputs

  Walk(const RowSchedule& s, const Run& r) : schedule(s), run(r), made(s.units_.size(), 0) {}

  /// The first row of a value that somebody will read.
  int64_t first_needed(ValueId id) const {
    int64_t first = made[schedule.producer_[id]];
    for (const size_t consumer : schedule.consumers_[id])
      first = std::min(first, graph::rows_read_from(schedule.units_[consumer].reach(schedule.graph_),
                                                    made[consumer], schedule.extents_[id].height));
    if (std::count(schedule.outputs_.begin(), schedule.outputs_.end(), id) > 0)
      first = std::min(first, handed_out);
    return first;
  }

  /// The next block of all outputs; false when there are no more.
  bool advance_outputs(const Done& done) {
    const int64_t height = schedule.extents_[schedule.outputs_[0]].height;
    if (handed_out >= height) return false;
    const int64_t end = std::min(handed_out + schedule.block_, height);
    for (const ValueId output : schedule.outputs_) advance(schedule.producer_[output], end);
    done(handed_out, end);
    handed_out = end;
    if (handed_out == height)  // of a padded picture, rows that no output reads
      for (const ValueId id : schedule.graph_.state)
        advance(schedule.producer_[id], schedule.extents_[id].height);
    return true;
  }

  /// Makes rows of a unit until there are `end`.
  void advance(size_t index, int64_t end) {
    const Unit& unit = schedule.units_[index];
    const ValueId output = unit.outputs[0];
    // Convolutions make rows in pairs (ops/kernels/winograd.h), and would throw away every other one.
    const bool pairs = std::holds_alternative<graph::Convolution>(unit.reach(schedule.graph_));
    const int64_t step = std::max<int64_t>(schedule.block_ >> schedule.graph_[output].level, pairs ? 2 : 1);
    end = std::min(end, schedule.extents_[output].height);
    while (made[index] < end) {
      const int64_t next = std::min(made[index] + step, schedule.extents_[output].height);
      for (const ValueId input : unit.inputs)
        advance(schedule.producer_[input],
                graph::rows_read_to(unit.reach(schedule.graph_), next, schedule.extents_[input].height));
      run(index, made[index], next);
      made[index] = next;
      for (const size_t reader : schedule.eager_[index]) advance(reader, next);
    }
  }
};

RowSchedule::RowSchedule(const Graph& graph, const PictureExtent& picture, int64_t block)
    : graph_(graph),
      block_(block),
      outputs_(graph.outputs()),
      units_(units_of(graph)),
      producer_(graph.values.size()),
      consumers_(graph.values.size()),
      capacity_(graph.values.size(), 0) {
  for (ValueId id = 0; id < graph.values.size(); ++id)
    extents_.push_back(graph::extent_of(graph, id, picture));
  for (size_t u = 0; u < units_.size(); ++u) {
    for (const ValueId output : units_[u].outputs) producer_[output] = u;
    for (const ValueId input : units_[u].inputs) consumers_[input].push_back(u);
  }
  for (size_t u = 0; u < units_.size(); ++u) eager_.push_back(eager_readers(u));
  // The same walk without doing anything says how many rows have to be there.
  const Walk* at = nullptr;
  const Run look = [&](size_t unit, int64_t begin, int64_t end) {
    // A step writes all that it makes, what nobody reads, too.
    for (const ValueId output : units_[unit].outputs)
      capacity_[output] = std::max(capacity_[output], end - std::min(at->first_needed(output), begin));
  };
  Walk walk(*this, look);
  at = &walk;
  while (walk.advance_outputs([](int64_t, int64_t) {})) {
  }
}

std::vector<size_t> RowSchedule::eager_readers(size_t unit) const {
  const auto planes = [&](const std::vector<ValueId>& values) {
    int64_t sum = 0;
    for (const ValueId id : values) sum += extents_[id].planes;
    return sum;
  };
  std::vector<size_t> readers;
  for (const ValueId output : units_[unit].outputs)
    for (const size_t reader : consumers_[output]) {
      const Unit& reading = units_[reader];
      const bool only = std::all_of(reading.inputs.begin(), reading.inputs.end(),
                                    [&](ValueId id) { return producer_[id] == unit; });
      const bool rows_alike = graph::rows_read_to(reading.reach(graph_), 1, 2) == 1;
      if (only && rows_alike && planes(reading.outputs) < planes(reading.inputs) &&
          std::find(readers.begin(), readers.end(), reader) == readers.end())
        readers.push_back(reader);
    }
  return readers;
}

void RowSchedule::walk(const Run& run, const Done& done) const {
  Walk walk(*this, run);
  while (walk.advance_outputs(done)) {
  }
}

}  // namespace ld
