// A small builder of ONNX graphs: nodes, constants, weights and arithmetic with sizes that are known only
// when the model runs. Free of LibTorch.
#pragma once

#include <onnx/onnx_pb.h>

#include <initializer_list>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "weights/safetensors.h"

namespace ld {

/// A tensor of the graph, by name.
struct Value {
  std::string name;
};

/// A size or position along an axis: known now, or a value of one int64, shape [1].
struct Dim {
  Dim(int value) : fixed(value) {}      // NOLINT(google-explicit-constructor): {-1, 3, height, width}
  Dim(int64_t value) : fixed(value) {}  // NOLINT(google-explicit-constructor)
  Dim(Value value) : dynamic(std::move(value)) {}  // NOLINT(google-explicit-constructor)
  bool is_fixed() const { return dynamic.name.empty(); }
  int64_t fixed = 0;
  Value dynamic;
};

/// An attribute of a node.
struct Attribute {
  std::string name;
  std::variant<int64_t, float, std::string, std::vector<int64_t>> value;
};

/// The version of the standard operators that the models use; ONNX 1.10 and later know it.
constexpr int64_t kOnnxOpset = 15;

class OnnxGraph {
 public:
  /// `weights`, float32 or float16, become initializers of the same names when parameter() asks for them.
  explicit OnnxGraph(const std::vector<TensorView>& weights);

  /// Prefix of the names of the nodes to come, "unet/encoder0/0": what viewers show.
  void enter(std::string scope) { scope_ = std::move(scope); }

  // What goes in and out, float32; a size is a number or the name of one that is known when the model runs.
  Value input(const std::string& name, const std::vector<std::string>& sizes);
  void output(const Value& value, const std::string& name, const std::vector<std::string>& sizes);

  /// A node with one output, the same one for the same inputs; or a node with several.
  Value op(const std::string& type, const std::vector<Value>& inputs,
           const std::vector<Attribute>& attributes = {});
  std::vector<Value> ops(const std::string& type, const std::vector<Value>& inputs, size_t outputs,
                         const std::vector<Attribute>& attributes = {});

  Value number(float value) { return numbers({value}, {}); }  // a constant float32 scalar
  Value numbers(const std::vector<float>& values, const std::vector<int64_t>& sizes);
  Value whole(const std::vector<int64_t>& values);  // a constant list of int64
  Value dims(const std::vector<Dim>& sizes);        // int64 [n]
  Value size_of(const Value& value, int64_t axis);  // int64 [1]
  /// A weight; matrices [outputs, inputs] come as the 1x1 convolutions [outputs, inputs, 1, 1] that they are.
  /// Throws Error when there is none of that name.
  Value parameter(const std::string& name);

  // Arithmetic with broadcasting.
  Value add(const Value& a, const Value& b) { return op("Add", {a, b}); }
  Value sub(const Value& a, const Value& b) { return op("Sub", {a, b}); }
  Value mul(const Value& a, const Value& b) { return op("Mul", {a, b}); }
  Value div(const Value& a, const Value& b) { return op("Div", {a, b}); }
  Value exp(const Value& x) { return op("Exp", {x}); }
  Value log(const Value& x) { return op("Log", {x}); }
  Value max(const Value& a, const Value& b) { return op("Max", {a, b}); }
  Value min(const Value& a, const Value& b) { return op("Min", {a, b}); }
  Value clip(const Value& x, float least, float most) { return op("Clip", {x, number(least), number(most)}); }
  Value where(const Value& condition, const Value& a, const Value& b) {
    return op("Where", {condition, a, b});
  }
  Value is_zero(const Value& x) { return op("Equal", {x, number(0)}); }
  Value to_float(const Value& x);

  // Shapes.
  Value reshape(const Value& x, const std::vector<Dim>& sizes) { return op("Reshape", {x, dims(sizes)}); }
  Value expand(const Value& x, const std::vector<Dim>& sizes) { return op("Expand", {x, dims(sizes)}); }
  Value unsqueeze(const Value& x, int64_t axis) { return op("Unsqueeze", {x, whole({axis})}); }
  Value squeeze(const Value& x, int64_t axis) { return op("Squeeze", {x, whole({axis})}); }
  Value concat(const std::vector<Value>& values, int64_t axis);
  /// [begin, end) of an axis, every `step`-th.
  Value slice(const Value& x, int64_t axis, const Dim& begin, const Dim& end, int64_t step = 1);
  /// So many entries before and after those of each axis, of this value.
  Value pad(const Value& x, const std::vector<Dim>& before, const std::vector<Dim>& after, float value);

  // Reductions; the axes stay, with size 1, unless `keep` is false.
  Value reduce_sum(const Value& x, const std::vector<int64_t>& axes, bool keep = true);
  Value reduce_max(const Value& x, const std::vector<int64_t>& axes);
  /// What exponents are compared with: the largest of them along the axes, which stay; a number below all
  /// finite ones in place of -inf, because -inf - -inf is NaN.
  Value top(const Value& exponents, const std::vector<int64_t>& axes);

  /// The finished model. Throws Error when a weight was not used, which would be a mistake in the
  /// translation.
  onnx::ModelProto model();

 private:
  std::string new_name(const std::string& type);
  Value constant(onnx::TensorProto::DataType type, const std::vector<int64_t>& sizes, const void* data,
                 size_t bytes);
  void initializer(const std::string& name, onnx::TensorProto::DataType type,
                   const std::vector<int64_t>& sizes, const void* data, size_t bytes);

  onnx::ModelProto model_;
  onnx::GraphProto& graph_;
  std::map<std::string, TensorView> weights_;
  std::map<std::string, Value> parameters_;
  std::map<std::string, Value> constants_, known_;  // by sizes and bytes; by operator, inputs and attributes
  std::string scope_;
  int64_t count_ = 0;
};

}  // namespace ld
