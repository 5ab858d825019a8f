// Named tensors in one file: the safetensors format (https://github.com/huggingface/safetensors), free of
// LibTorch. 8 bytes of header length (little endian), a JSON header, the data. Nothing in it is executed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace ld {

enum class DType { f16, f32, f64, i64, i8, u8 };
size_t dtype_bytes(DType type);

struct TensorView {
  std::string name;
  DType type = DType::f32;
  std::vector<int64_t> shape;
  const void* data = nullptr;
  size_t bytes = 0;

  int64_t numbers() const { return static_cast<int64_t>(bytes / dtype_bytes(type)); }
};

using Metadata = std::map<std::string, std::string>;

/// A memory-mapped file; the views live as long as it does.
class SafetensorsFile {
 public:
  /// Checks the whole header before anything is used: lengths, offsets without gaps or overlaps, shapes that
  /// match the byte counts, duplicate names. Throws Error saying which entry lies and what was expected.
  explicit SafetensorsFile(const std::filesystem::path& path);
  ~SafetensorsFile();
  SafetensorsFile(const SafetensorsFile&) = delete;
  SafetensorsFile& operator=(const SafetensorsFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  const Metadata& metadata() const { return metadata_; }
  const std::vector<TensorView>& tensors() const { return tensors_; }  // in the order of their data
  /// Throws Error when there is no such tensor.
  const TensorView& tensor(const std::string& name) const;
  /// Throws Error when there is no such entry.
  const std::string& metadata_value(const std::string& key) const;

 private:
  std::filesystem::path path_;
  void* map_ = nullptr;
  size_t map_bytes_ = 0;
  Metadata metadata_;
  std::vector<TensorView> tensors_;
};

/// Writes atomically; the same tensors and metadata give the same bytes.
void write_safetensors(const std::filesystem::path& path, const std::vector<TensorView>& tensors,
                       const Metadata& metadata);

}  // namespace ld
