#include "graph/graph.h"

#include <utility>

namespace ld::graph {

ValueId Graph::add_value(Value value) {
  values.push_back(std::move(value));
  return values.size() - 1;
}

ValueId Graph::add(Operator op, std::vector<ValueId> inputs, Value output_value) {
  const ValueId id = add_value(std::move(output_value));
  nodes.push_back({std::move(op), std::move(inputs), {id}});
  return id;
}

std::vector<ValueId> Graph::outputs() const {
  std::vector<ValueId> all = {output};
  all.insert(all.end(), further.begin(), further.end());
  return all;
}

}  // namespace ld::graph
