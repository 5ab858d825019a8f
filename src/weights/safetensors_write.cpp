#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>

#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/file_io.h"
#include "weights/safetensors.h"

namespace ld {
namespace {

constexpr const char* dtype_name(DType type) {
  switch (type) {
    case DType::f16:
      return "F16";
    case DType::f32:
      return "F32";
    case DType::f64:
      return "F64";
    case DType::i64:
      return "I64";
    case DType::i8:
      return "I8";
    case DType::u8:
      return "U8";
  }
  return "";
}

void check_tensor(const TensorView& tensor, const std::string& file) {
  auto expected = static_cast<int64_t>(dtype_bytes(tensor.type));
  bool fits = !tensor.name.empty() && tensor.name != "__metadata__";
  for (const int64_t size : tensor.shape)
    fits = fits && size >= 0 && !__builtin_mul_overflow(expected, size, &expected);
  fits =
      fits && static_cast<size_t>(expected) == tensor.bytes && (tensor.data != nullptr || tensor.bytes == 0);
  if (!fits)
    fail("cannot write {}: tensor \"{}\" has {} bytes, which its name, shape or type does not allow", file,
         tensor.name, tensor.bytes);
}

}  // namespace

size_t dtype_bytes(DType type) {
  switch (type) {
    case DType::f16:
      return 2;
    case DType::f32:
      return 4;
    case DType::f64:
    case DType::i64:
      return 8;
    case DType::i8:
    case DType::u8:
      return 1;
  }
  return 0;
}

void write_safetensors(const std::filesystem::path& path, const std::vector<TensorView>& tensors,
                       const Metadata& metadata) {
  // As the reference implementation orders them: by descending alignment, then by name, so that every tensor
  // is aligned to its type and the order in which they were collected leaves no trace.
  std::vector<TensorView> sorted = tensors;
  std::sort(sorted.begin(), sorted.end(), [](const TensorView& a, const TensorView& b) {
    return std::make_tuple(dtype_bytes(b.type), static_cast<int>(a.type), a.name) <
           std::make_tuple(dtype_bytes(a.type), static_cast<int>(b.type), b.name);
  });
  nlohmann::ordered_json header = nlohmann::ordered_json::object();
  if (!metadata.empty()) header["__metadata__"] = metadata;
  size_t offset = 0;
  for (const TensorView& tensor : sorted) {
    check_tensor(tensor, path.string());
    if (header.contains(tensor.name)) fail("cannot write {}: two tensors \"{}\"", path.string(), tensor.name);
    header[tensor.name] = {{"dtype", dtype_name(tensor.type)},
                           {"shape", tensor.shape},
                           {"data_offsets", {offset, offset + tensor.bytes}}};
    offset += tensor.bytes;
  }
  std::string text;
  try {
    text = header.dump();
  } catch (const nlohmann::json::exception& error) {
    fail("cannot write {}: a name or the metadata is not UTF-8 ({})", path.string(), error.what());
  }
  text.resize((text.size() + 7) / 8 * 8, ' ');  // the data starts aligned
  const uint64_t header_bytes = text.size();

  write_atomically(path, [&](const std::filesystem::path& temporary) {
    std::ofstream file(temporary, std::ios::binary);
    file.write(reinterpret_cast<const char*>(&header_bytes), 8);
    file.write(text.data(), static_cast<std::streamsize>(text.size()));
    for (const TensorView& tensor : sorted)
      file.write(static_cast<const char*>(tensor.data), static_cast<std::streamsize>(tensor.bytes));
    file.close();
    if (!file) fail_to_write(path, std::strerror(errno));
  });
}

}  // namespace ld
