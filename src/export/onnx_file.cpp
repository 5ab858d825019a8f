#include "export/onnx_file.h"

#include <onnx/checker.h>
#include <onnx/shape_inference/implementation.h>

#include <limits>

#include "core/error.h"
#include "core/shown_text.h"

namespace ld {
namespace {}  // namespace

std::string onnx_bytes(const onnx::ModelProto& model) {
  if (model.ByteSizeLong() > size_t{std::numeric_limits<int>::max()})
    fail("the ONNX model takes {} MB, but the format ends at 2147; export with --dtype f16",
         model.ByteSizeLong() / 1'000'000);
  return model.SerializeAsString();
}

onnx::ModelProto parse_onnx(const std::string& bytes, const std::string& name) {
  onnx::ModelProto model;
  if (!model.ParseFromString(bytes) || model.graph().node_size() == 0)
    fail("{}: no ONNX model; expected a file that ld_export --format onnx wrote", name);
  try {
    onnx::checker::check_model(model);
    onnx::ModelProto inferred = model;
    onnx::shape_inference::InferShapes(inferred, onnx::OpSchemaRegistry::Instance(),
                                       onnx::ShapeInferenceOptions{true, 1, true});
  } catch (const std::runtime_error& error) {
    fail("{}: not a valid ONNX model: {}", name, one_line(error.what()));
  }
  return model;
}

}  // namespace ld
