#include <fmt/ranges.h>

#include "apps/inspect/inspect.h"
#include "core/error.h"
#include "core/file_io.h"
#include "export/onnx_file.h"

namespace ld {
namespace {

constexpr size_t kLargestModel = size_t{1} << 31;  // the format's own limit

/// "radiance [B, S, 3, H, W]".
std::string text_of(const onnx::ValueInfoProto& value) {
  std::vector<std::string> sizes;
  for (const auto& size : value.type().tensor_type().shape().dim())
    sizes.push_back(size.has_dim_param() ? size.dim_param() : std::to_string(size.dim_value()));
  return fmt::format("{} [{}]", value.name(), fmt::join(sizes, ", "));
}

}  // namespace

void inspect_onnx(Report& report) {
  report.kind = "ONNX model";
  report.attempt([&] {
    const onnx::ModelProto model = parse_onnx(read_file(report.path, kLargestModel), report.path);
    report.facts["producer"] = model.producer_name() + " " + model.producer_version();
    for (const auto& opset : model.opset_import())
      if (opset.domain().empty()) report.facts["opset"] = opset.version();
    std::vector<std::string> inputs, outputs;
    for (const auto& input : model.graph().input()) inputs.push_back(text_of(input));
    for (const auto& output : model.graph().output()) outputs.push_back(text_of(output));
    report.facts["inputs"] = inputs;
    report.facts["outputs"] = outputs;
    report.facts["operators"] = model.graph().node_size();
    int64_t parameters = 0;
    for (const auto& tensor : model.graph().initializer()) {
      int64_t count = 1;
      for (const int64_t size : tensor.dims()) count *= size;
      parameters += count;
    }
    report.facts["numbers"] = parameters;
    for (const auto& entry : model.metadata_props()) report.facts[entry.key()] = entry.value();
  });
}

}  // namespace ld
