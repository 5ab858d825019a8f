// ONNX models as bytes: in, out and checked. Free of LibTorch.
#pragma once

#include <onnx/onnx_pb.h>

#include <filesystem>
#include <string>

namespace ld {

/// The model as a file holds it. Throws Error when it is beyond the 2 GB of the format.
std::string onnx_bytes(const onnx::ModelProto& model);

/// Parses what onnx_bytes() or another program wrote; `name` is what complaints call it. Throws Error when it
/// is no ONNX model or when ONNX's own checker or its strict shape inference rejects it.
onnx::ModelProto parse_onnx(const std::string& bytes, const std::string& name);

}  // namespace ld
