#include "export/onnx_graph.h"

#include "core/error.h"

namespace ld {

using onnx::TensorProto;

namespace {

void set_sizes(onnx::ValueInfoProto& info, const std::string& name, const std::vector<std::string>& sizes) {
  info.set_name(name);
  onnx::TypeProto::Tensor& type = *info.mutable_type()->mutable_tensor_type();
  type.set_elem_type(TensorProto::FLOAT);
  for (const std::string& size : sizes) {
    onnx::TensorShapeProto::Dimension& dimension = *type.mutable_shape()->add_dim();
    if (size.find_first_not_of("0123456789") == std::string::npos)
      dimension.set_dim_value(std::stoll(size));
    else
      dimension.set_dim_param(size);
  }
}

void set_attribute(onnx::AttributeProto& to, const Attribute& from) {
  to.set_name(from.name);
  if (const auto* number = std::get_if<int64_t>(&from.value)) {
    to.set_type(onnx::AttributeProto::INT);
    to.set_i(*number);
  } else if (const auto* real = std::get_if<float>(&from.value)) {
    to.set_type(onnx::AttributeProto::FLOAT);
    to.set_f(*real);
  } else if (const auto* text = std::get_if<std::string>(&from.value)) {
    to.set_type(onnx::AttributeProto::STRING);
    to.set_s(*text);
  } else {
    to.set_type(onnx::AttributeProto::INTS);
    for (const int64_t value : std::get<std::vector<int64_t>>(from.value)) to.add_ints(value);
  }
}

}  // namespace

OnnxGraph::OnnxGraph(const std::vector<TensorView>& weights) : graph_(*model_.mutable_graph()) {
  for (const TensorView& weight : weights) weights_[weight.name] = weight;
  model_.set_ir_version(8);  // of ONNX 1.10 to 1.12
  model_.set_producer_name("layer_denoiser");
  model_.set_producer_version(LD_VERSION);
  onnx::OperatorSetIdProto& opset = *model_.add_opset_import();
  opset.set_domain("");
  opset.set_version(kOnnxOpset);
}

std::string OnnxGraph::new_name(const std::string& type) {
  return (scope_.empty() ? "" : scope_ + "/") + type + "_" + std::to_string(count_++);
}

Value OnnxGraph::input(const std::string& name, const std::vector<std::string>& sizes) {
  set_sizes(*graph_.add_input(), name, sizes);
  return {name};
}

void OnnxGraph::output(const Value& value, const std::string& name, const std::vector<std::string>& sizes) {
  onnx::NodeProto& node = *graph_.add_node();
  node.set_op_type("Identity");
  node.set_name(name);
  node.add_input(value.name);
  node.add_output(name);
  set_sizes(*graph_.add_output(), name, sizes);
}

Value OnnxGraph::op(const std::string& type, const std::vector<Value>& inputs,
                    const std::vector<Attribute>& attributes) {
  std::string key = type;
  for (const Value& input : inputs) key += "|" + input.name;
  for (const Attribute& attribute : attributes) {
    onnx::AttributeProto proto;
    set_attribute(proto, attribute);
    key += "|" + proto.SerializeAsString();
  }
  Value& known = known_[key];
  if (known.name.empty()) known = ops(type, inputs, 1, attributes)[0];
  return known;
}

std::vector<Value> OnnxGraph::ops(const std::string& type, const std::vector<Value>& inputs, size_t outputs,
                                  const std::vector<Attribute>& attributes) {
  onnx::NodeProto& node = *graph_.add_node();
  const std::string name = new_name(type);
  node.set_op_type(type);
  node.set_name(name);
  for (const Value& input : inputs) node.add_input(input.name);
  for (const Attribute& attribute : attributes) set_attribute(*node.add_attribute(), attribute);
  std::vector<Value> values;
  for (size_t i = 0; i < outputs; ++i) {
    values.push_back({outputs == 1 ? name : name + "." + std::to_string(i)});
    node.add_output(values.back().name);
  }
  return values;
}

void OnnxGraph::initializer(const std::string& name, TensorProto::DataType type,
                            const std::vector<int64_t>& sizes, const void* data, size_t bytes) {
  TensorProto& tensor = *graph_.add_initializer();
  tensor.set_name(name);
  tensor.set_data_type(type);
  for (const int64_t size : sizes) tensor.add_dims(size);
  tensor.set_raw_data(data, bytes);
}

Value OnnxGraph::constant(TensorProto::DataType type, const std::vector<int64_t>& sizes, const void* data,
                          size_t bytes) {
  std::string key = std::to_string(type);
  for (const int64_t size : sizes) key += " " + std::to_string(size);
  key += ":" + std::string(static_cast<const char*>(data), bytes);
  Value& known = constants_[key];
  if (known.name.empty()) {
    known.name = "constant_" + std::to_string(constants_.size());
    initializer(known.name, type, sizes, data, bytes);
  }
  return known;
}

Value OnnxGraph::numbers(const std::vector<float>& values, const std::vector<int64_t>& sizes) {
  return constant(TensorProto::FLOAT, sizes, values.data(), values.size() * sizeof(float));
}

Value OnnxGraph::whole(const std::vector<int64_t>& values) {
  return constant(TensorProto::INT64, {int64_t(values.size())}, values.data(),
                  values.size() * sizeof(int64_t));
}

Value OnnxGraph::dims(const std::vector<Dim>& sizes) {
  std::vector<Value> parts;
  std::vector<int64_t> fixed;
  const auto finish = [&] {
    if (!fixed.empty()) parts.push_back(whole(fixed));
    fixed.clear();
  };
  for (const Dim& size : sizes) {
    if (size.is_fixed()) {
      fixed.push_back(size.fixed);
      continue;
    }
    finish();
    parts.push_back(size.dynamic);
  }
  finish();
  return parts.size() == 1 ? parts[0] : concat(parts, 0);
}

Value OnnxGraph::size_of(const Value& value, int64_t axis) {
  return op("Shape", {value}, {{"start", axis}, {"end", axis + 1}});
}

Value OnnxGraph::parameter(const std::string& name) {
  const auto found = weights_.find(name);
  if (found == weights_.end()) fail("the network has no weight '{}' for its ONNX form", name);
  Value& value = parameters_[name];
  if (!value.name.empty()) return value;
  const TensorView& weight = found->second;
  std::vector<int64_t> sizes = weight.shape;
  if (sizes.size() == 2) sizes.insert(sizes.end(), {1, 1});
  const bool half = weight.type == DType::f16;
  initializer(name, half ? TensorProto::FLOAT16 : TensorProto::FLOAT, sizes, weight.data, weight.bytes);
  value.name = name;
  if (half) value = to_float(value);
  return value;
}

Value OnnxGraph::to_float(const Value& x) {
  return op("Cast", {x}, {{"to", int64_t(TensorProto::FLOAT)}});
}

Value OnnxGraph::concat(const std::vector<Value>& values, int64_t axis) {
  return values.size() == 1 ? values[0] : op("Concat", values, {{"axis", axis}});
}

Value OnnxGraph::slice(const Value& x, int64_t axis, const Dim& begin, const Dim& end, int64_t step) {
  std::vector<Value> inputs = {x, dims({begin}), dims({end}), whole({axis})};
  if (step != 1) inputs.push_back(whole({step}));
  return op("Slice", inputs);
}

Value OnnxGraph::pad(const Value& x, const std::vector<Dim>& before, const std::vector<Dim>& after,
                     float value) {
  std::vector<Dim> sizes = before;
  sizes.insert(sizes.end(), after.begin(), after.end());
  return op("Pad", {x, dims(sizes), number(value)});
}

Value OnnxGraph::reduce_sum(const Value& x, const std::vector<int64_t>& axes, bool keep) {
  return op("ReduceSum", {x, whole(axes)}, {{"keepdims", int64_t(keep)}});
}

Value OnnxGraph::reduce_max(const Value& x, const std::vector<int64_t>& axes) {
  return op("ReduceMax", {x}, {{"axes", axes}, {"keepdims", int64_t{1}}});
}

Value OnnxGraph::top(const Value& exponents, const std::vector<int64_t>& axes) {
  return max(reduce_max(exponents, axes), number(-3e38F));
}

onnx::ModelProto OnnxGraph::model() {
  for (const auto& [name, weight] : weights_)
    if (parameters_.count(name) == 0) fail("the ONNX form of the network leaves out its weight '{}'", name);
  graph_.set_name("denoiser");
  return model_;
}

}  // namespace ld
