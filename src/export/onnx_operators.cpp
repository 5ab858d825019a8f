#include "export/onnx_operators.h"

#include <algorithm>
#include <map>

#include "core/error.h"

namespace ld {
namespace {

using torch::Tensor;
using Inputs = std::vector<Tensor>;
using Outputs = std::vector<Tensor>;

/// The attributes of a node.
class Attributes {
 public:
  explicit Attributes(const onnx::NodeProto& node) : node_(node) {}

  int64_t integer(const std::string& name, int64_t missing) const {
    const onnx::AttributeProto* attribute = find(name);
    return attribute == nullptr ? missing : attribute->i();
  }
  double real(const std::string& name, double missing) const {
    const onnx::AttributeProto* attribute = find(name);
    return attribute == nullptr ? missing : double(attribute->f());
  }
  std::string text(const std::string& name, const std::string& missing) const {
    const onnx::AttributeProto* attribute = find(name);
    return attribute == nullptr ? missing : attribute->s();
  }
  std::vector<int64_t> integers(const std::string& name, const std::vector<int64_t>& missing) const {
    const onnx::AttributeProto* attribute = find(name);
    return attribute == nullptr ? missing
                                : std::vector<int64_t>(attribute->ints().begin(), attribute->ints().end());
  }
  /// ONNX has "before" and "after" of all axes, LibTorch one number for both.
  std::vector<int64_t> symmetric_pads() const {
    const std::vector<int64_t> pads = integers("pads", {0, 0, 0, 0});
    if (pads.size() != 4 || pads[0] != pads[2] || pads[1] != pads[3])
      fail("ONNX node {}: pads are not those of a picture, as many before as after", node_.name());
    return {pads[0], pads[1]};
  }
  size_t outputs() const { return size_t(node_.output_size()); }
  const std::string& node() const { return node_.name(); }

 private:
  const onnx::AttributeProto* find(const std::string& name) const {
    for (const onnx::AttributeProto& attribute : node_.attribute())
      if (attribute.name() == name) return &attribute;
    return nullptr;
  }
  const onnx::NodeProto& node_;
};

std::vector<int64_t> list(const Tensor& t) {
  const Tensor flat = t.contiguous();
  return {flat.data_ptr<int64_t>(), flat.data_ptr<int64_t>() + flat.numel()};
}

Tensor cast(const Inputs& in, const Attributes& attributes) {
  switch (attributes.integer("to", 0)) {
    case onnx::TensorProto::FLOAT:
      return in[0].to(torch::kFloat32);
    case onnx::TensorProto::INT64:
      return in[0].to(torch::kInt64);
    default:
      fail("ONNX node {}: a cast to another type than float and int64", attributes.node());
  }
}

Tensor convolution(const Inputs& in, const Attributes& attributes) {
  return at::conv2d(in[0], in[1], in.size() > 2 ? in[2] : Tensor(), {1, 1}, attributes.symmetric_pads());
}

Tensor max_pool(const Inputs& in, const Attributes& attributes) {
  return at::max_pool2d(in[0], attributes.integers("kernel_shape", {}),
                        attributes.integers("strides", {1, 1}), attributes.symmetric_pads());
}

Tensor average_pool(const Inputs& in, const Attributes& attributes) {
  return at::avg_pool2d(in[0], attributes.integers("kernel_shape", {}),
                        attributes.integers("strides", {1, 1}), attributes.symmetric_pads(),
                        /*ceil_mode=*/false, attributes.integer("count_include_pad", 0) != 0);
}

/// Of equal values the first first, as ONNX has it.
Outputs top_k(const Inputs& in, const Attributes& attributes) {
  const int64_t axis = attributes.integer("axis", -1);
  const auto [values, order] =
      at::sort(in[0], /*stable=*/true, axis, /*descending=*/attributes.integer("largest", 1) != 0);
  const int64_t count = in[1].item<int64_t>();
  return {values.narrow(axis, 0, count), order.narrow(axis, 0, count)};
}

Tensor range(const Inputs& in, const Attributes&) {
  return at::arange(in[0].item(), in[1].item(), in[2].item(), in[0].options());
}

Tensor pad(const Inputs& in, const Attributes& attributes) {
  const std::vector<int64_t> sizes = list(in[1]);
  const size_t axes = sizes.size() / 2;
  std::vector<int64_t> pairs;  // last axis first
  for (size_t axis = axes; axis-- > 0;) {
    pairs.push_back(sizes[axis]);
    pairs.push_back(sizes[axis + axes]);
  }
  if (attributes.text("mode", "constant") == "constant")
    return at::constant_pad_nd(in[0], pairs, in.size() > 2 ? in[2].item() : at::Scalar(0));
  pairs.resize(4);  // edge: of pictures
  return at::replication_pad2d(in[0], pairs);
}

Tensor resize(const Inputs& in, const Attributes& attributes) {
  const std::vector<int64_t> sizes = list(in[3]), picture = {sizes[2], sizes[3]};
  const std::string how = attributes.text("mode", "nearest") + " " +
                          attributes.text("coordinate_transformation_mode", "half_pixel");
  if (how == "linear half_pixel") return at::upsample_bilinear2d(in[0], picture, /*align_corners=*/false);
  if (how == "nearest asymmetric" && attributes.text("nearest_mode", "") == "floor")
    return at::upsample_nearest2d(in[0], picture);
  fail("ONNX node {}: a Resize of another kind ({})", attributes.node(), how);
}

Tensor slice(const Inputs& in, const Attributes&) {
  return in[0].slice(in[3].item<int64_t>(), in[1].item<int64_t>(), in[2].item<int64_t>(),
                     in.size() > 4 ? in[4].item<int64_t>() : 1);
}

Tensor shape(const Inputs& in, const Attributes& attributes) {
  const std::vector<int64_t> sizes = in[0].sizes().vec();
  const int64_t begin = attributes.integer("start", 0), end = attributes.integer("end", in[0].dim());
  return torch::tensor(std::vector<int64_t>(sizes.begin() + begin, sizes.begin() + end), torch::kInt64);
}

Tensor expand(const Inputs& in, const Attributes&) {
  return in[0].expand(at::infer_size(in[0].sizes(), list(in[1])));
}

Tensor reduce_sum(const Inputs& in, const Attributes& attributes) {
  return in[0].sum(list(in[1]), attributes.integer("keepdims", 1) != 0);
}

Tensor reduce_max(const Inputs& in, const Attributes& attributes) {
  return in[0].amax(attributes.integers("axes", {}), attributes.integer("keepdims", 1) != 0);
}

/// The first largest, as ONNX has it.
Tensor arg_max(const Inputs& in, const Attributes& attributes) {
  return in[0].argmax(attributes.integer("axis", 0), attributes.integer("keepdims", 1) != 0);
}

Tensor divide(const Inputs& in, const Attributes&) {
  return in[0].is_floating_point() ? in[0] / in[1] : at::div(in[0], in[1], "trunc");
}

using Operator = Tensor (*)(const Inputs&, const Attributes&);

const std::map<std::string, Operator>& operators() {
  static const std::map<std::string, Operator> by_name = {
      {"Abs", [](const Inputs& in, const Attributes&) { return in[0].abs(); }},
      {"Add", [](const Inputs& in, const Attributes&) { return in[0] + in[1]; }},
      {"And", [](const Inputs& in, const Attributes&) { return in[0].logical_and(in[1]); }},
      {"ArgMax", arg_max},
      {"AveragePool", average_pool},
      {"Cast", cast},
      {"Clip",
       [](const Inputs& in, const Attributes&) { return at::minimum(at::maximum(in[0], in[1]), in[2]); }},
      {"Concat", [](const Inputs& in, const Attributes& a) { return at::cat(in, a.integer("axis", 0)); }},
      {"Conv", convolution},
      {"DepthToSpace", [](const Inputs& in, const Attributes&) { return at::pixel_shuffle(in[0], 2); }},
      {"Div", divide},
      {"Equal", [](const Inputs& in, const Attributes&) { return in[0].eq(in[1]); }},
      {"Exp", [](const Inputs& in, const Attributes&) { return in[0].exp(); }},
      {"Expand", expand},
      {"Floor", [](const Inputs& in, const Attributes&) { return in[0].floor(); }},
      {"GatherElements",
       [](const Inputs& in, const Attributes& a) { return in[0].gather(a.integer("axis", 0), in[1]); }},
      {"Greater", [](const Inputs& in, const Attributes&) { return in[0].gt(in[1]); }},
      {"Identity", [](const Inputs& in, const Attributes&) { return in[0]; }},
      {"LeakyRelu",
       [](const Inputs& in, const Attributes& a) { return at::leaky_relu(in[0], a.real("alpha", 0.01)); }},
      {"LessOrEqual", [](const Inputs& in, const Attributes&) { return in[0].le(in[1]); }},
      {"Log", [](const Inputs& in, const Attributes&) { return in[0].log(); }},
      {"Max", [](const Inputs& in, const Attributes&) { return at::maximum(in[0], in[1]); }},
      {"MaxPool", max_pool},
      {"Min", [](const Inputs& in, const Attributes&) { return at::minimum(in[0], in[1]); }},
      {"Mod", [](const Inputs& in, const Attributes&) { return at::remainder(in[0], in[1]); }},
      {"Mul", [](const Inputs& in, const Attributes&) { return in[0] * in[1]; }},
      {"Not", [](const Inputs& in, const Attributes&) { return in[0].logical_not(); }},
      {"Pad", pad},
      {"Pow", [](const Inputs& in, const Attributes&) { return in[0].pow(in[1]); }},
      {"Range", range},
      {"ReduceMax", reduce_max},
      {"ReduceSum", reduce_sum},
      {"Relu", [](const Inputs& in, const Attributes&) { return in[0].relu(); }},
      {"Reshape", [](const Inputs& in, const Attributes&) { return in[0].reshape(list(in[1])); }},
      {"Resize", resize},
      {"Shape", shape},
      {"Sigmoid", [](const Inputs& in, const Attributes&) { return in[0].sigmoid(); }},
      {"Sign", [](const Inputs& in, const Attributes&) { return in[0].sign(); }},
      {"Slice", slice},
      {"Sqrt", [](const Inputs& in, const Attributes&) { return in[0].sqrt(); }},
      {"Squeeze", [](const Inputs& in, const Attributes&) { return in[0].squeeze(in[1].item<int64_t>()); }},
      {"Sub", [](const Inputs& in, const Attributes&) { return in[0] - in[1]; }},
      {"Tanh", [](const Inputs& in, const Attributes&) { return in[0].tanh(); }},
      {"Unsqueeze",
       [](const Inputs& in, const Attributes&) { return in[0].unsqueeze(in[1].item<int64_t>()); }},
      {"Where", [](const Inputs& in, const Attributes&) { return at::where(in[0], in[1], in[2]); }},
  };
  return by_name;
}

}  // namespace

Outputs run_onnx_node(const onnx::NodeProto& node, const Inputs& inputs) {
  const Attributes attributes(node);
  if (node.op_type() == "Split") {
    const int64_t axis = attributes.integer("axis", 0);
    return inputs[0].split(inputs[0].size(axis) / int64_t(attributes.outputs()), axis);
  }
  if (node.op_type() == "TopK") return top_k(inputs, attributes);
  const auto known = operators().find(node.op_type());
  if (known == operators().end())
    fail("ONNX node {}: operator {} is none that this project writes", node.name(), node.op_type());
  return {known->second(inputs, attributes)};
}

}  // namespace ld
