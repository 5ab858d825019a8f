#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "core/error.h"
#include "core/json_text.h"
#include "core/shown_text.h"
#include "weights/safetensors.h"

namespace ld {
namespace {

using nlohmann::json;

constexpr uint64_t kMaxHeaderBytes = 100'000'000;  // the format's own limit

/// A file mapped for reading; unmaps unless released, so that a constructor may throw half-way.
class Mapping {
 public:
  explicit Mapping(const std::filesystem::path& path) {
    const std::string name = path.string();
    const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor < 0) fail("cannot open {}: {}; check the path", name, std::strerror(errno));
    struct stat status = {};
    const bool known = fstat(descriptor, &status) == 0;
    const bool regular = known && S_ISREG(status.st_mode);
    bytes = regular ? static_cast<size_t>(status.st_size) : 0;
    if (bytes > 0) data = mmap(nullptr, bytes, PROT_READ, MAP_PRIVATE, descriptor, 0);
    const int reason = errno;
    close(descriptor);
    if (!regular) fail("{} is no regular file; expected a .safetensors file", name);
    if (data == MAP_FAILED) fail("cannot map {}: {}", name, std::strerror(reason));
  }
  ~Mapping() {
    if (data != nullptr && data != MAP_FAILED) munmap(data, bytes);
  }
  Mapping(const Mapping&) = delete;
  Mapping& operator=(const Mapping&) = delete;

  void* data = nullptr;
  size_t bytes = 0;
};

DType dtype_of(const std::string& name, const std::string& where) {
  if (name == "F16") return DType::f16;
  if (name == "F32") return DType::f32;
  if (name == "F64") return DType::f64;
  if (name == "I64") return DType::i64;
  if (name == "I8") return DType::i8;
  if (name == "U8") return DType::u8;
  fail("{}: dtype \"{}\"; expected one of F16, F32, F64, I64, I8, U8; convert the tensor", where,
       shown(name));
}

/// A list of whole numbers >= 0 that fit int64.
std::vector<int64_t> whole_numbers(const json& entry, const char* key, const std::string& where) {
  const auto it = entry.find(key);
  if (it == entry.end() || !it->is_array()) fail("{}: no list \"{}\"; the file is damaged", where, key);
  std::vector<int64_t> numbers;
  for (const json& number : *it) {
    if (!number.is_number_unsigned() || number.get<uint64_t>() > uint64_t{INT64_MAX})
      fail("{}: \"{}\" holds {}; expected whole numbers of at least 0; the file is damaged", where, key,
           shown(number.dump(-1, ' ', false, json::error_handler_t::replace)));
    numbers.push_back(number.get<int64_t>());
  }
  return numbers;
}

/// Bytes of a tensor of this shape; -1 on overflow.
int64_t shape_bytes(const std::vector<int64_t>& shape, DType type) {
  int64_t bytes = static_cast<int64_t>(dtype_bytes(type));
  for (const int64_t size : shape)
    if (__builtin_mul_overflow(bytes, size, &bytes)) return -1;
  return bytes;
}

TensorView parse_entry(const std::string& name, const json& entry, const char* data, size_t data_bytes,
                       const std::string& where) {
  if (!entry.is_object())
    fail("{}: is {}; expected {{dtype, shape, data_offsets}}", where, entry.type_name());
  for (const auto& item : entry.items())
    if (item.key() != "dtype" && item.key() != "shape" && item.key() != "data_offsets")
      fail("{}: unknown key \"{}\"; expected dtype, shape and data_offsets; the file is damaged", where,
           shown(item.key()));
  const auto dtype = entry.find("dtype");
  if (dtype == entry.end() || !dtype->is_string()) fail("{}: no text \"dtype\"; the file is damaged", where);
  TensorView tensor;
  tensor.name = name;
  tensor.type = dtype_of(dtype->get<std::string>(), where);
  tensor.shape = whole_numbers(entry, "shape", where);
  const std::vector<int64_t> offsets = whole_numbers(entry, "data_offsets", where);
  if (offsets.size() != 2 || offsets[0] > offsets[1] || static_cast<uint64_t>(offsets[1]) > data_bytes)
    fail(
        "{}: \"data_offsets\" is {}; expected [begin, end] within the {} bytes of data; the file is damaged "
        "or cut short",
        where, shown(entry.at("data_offsets").dump()), data_bytes);
  const int64_t expected = shape_bytes(tensor.shape, tensor.type);
  if (expected != offsets[1] - offsets[0])
    fail("{}: shape {} of {} takes {} bytes, but data_offsets span {}; the file is damaged", where,
         shown(entry.at("shape").dump()), dtype->get<std::string>(),
         expected < 0 ? std::string("more than 2^63") : std::to_string(expected), offsets[1] - offsets[0]);
  tensor.data = data + offsets[0];
  tensor.bytes = static_cast<size_t>(expected);
  return tensor;
}

Metadata parse_metadata(const json& entry, const std::string& where) {
  if (!entry.is_object()) fail("{}: is {}; expected texts by name", where, entry.type_name());
  Metadata metadata;
  for (const auto& item : entry.items()) {
    if (!item.value().is_string())
      fail("{}: \"{}\" is {}; the format allows texts only", where, shown(item.key()),
           item.value().type_name());
    metadata[item.key()] = item.value().get<std::string>();
  }
  return metadata;
}

/// In the order of their data; every byte of it belongs to one tensor.
void check_layout(std::vector<TensorView>& tensors, const char* data, size_t data_bytes,
                  const std::string& file) {
  const auto begin = [&](const TensorView& tensor) {
    return static_cast<size_t>(static_cast<const char*>(tensor.data) - data);
  };
  std::sort(tensors.begin(), tensors.end(), [&](const TensorView& a, const TensorView& b) {
    return std::make_tuple(begin(a), a.bytes, a.name) < std::make_tuple(begin(b), b.bytes, b.name);
  });
  size_t end = 0;
  for (const TensorView& tensor : tensors) {
    if (begin(tensor) != end)
      fail(
          "{}: tensor \"{}\" begins at byte {} of the data; expected {}, where the one before it ends; the "
          "tensors {}; the "
          "file is damaged",
          file, shown(tensor.name), begin(tensor), end, begin(tensor) < end ? "overlap" : "leave a gap");
    end += tensor.bytes;
  }
  if (end != data_bytes)
    fail("{}: {} bytes of data, but the tensors take {}; the file is cut short or has something appended",
         file, data_bytes, end);
}

}  // namespace

SafetensorsFile::SafetensorsFile(const std::filesystem::path& path) : path_(path) {
  const std::string file = path.string();
  Mapping mapping(path);
  if (mapping.bytes < 8)
    fail("{}: {} bytes; expected a safetensors file, which starts with 8 bytes of header length", file,
         mapping.bytes);
  const char* bytes = static_cast<const char*>(mapping.data);
  uint64_t header_bytes = 0;
  std::memcpy(&header_bytes, bytes, 8);  // little endian, as are the machines this project supports
  if (header_bytes > kMaxHeaderBytes || header_bytes > mapping.bytes - 8)
    fail("{}: the header's length says {} bytes, but {} follow; the file is cut short or no safetensors file",
         file, header_bytes, mapping.bytes - 8);
  const char* data = bytes + 8 + header_bytes;
  const size_t data_bytes = mapping.bytes - 8 - header_bytes;

  const json header = parse_json(std::string(bytes + 8, header_bytes), file + ": header");
  if (!header.is_object()) fail("{}: the header is {}; expected a JSON object", file, header.type_name());
  for (const auto& item : header.items()) {
    if (item.key() == "__metadata__")
      metadata_ = parse_metadata(item.value(), file + ": __metadata__");
    else
      tensors_.push_back(parse_entry(item.key(), item.value(), data, data_bytes,
                                     fmt::format("{}: tensor \"{}\"", file, shown(item.key()))));
  }
  check_layout(tensors_, data, data_bytes, file);
  std::swap(map_, mapping.data);
  map_bytes_ = mapping.bytes;
}

SafetensorsFile::~SafetensorsFile() {
  munmap(map_, map_bytes_);
}

const TensorView& SafetensorsFile::tensor(const std::string& name) const {
  for (const TensorView& tensor : tensors_)
    if (tensor.name == name) return tensor;
  std::vector<std::string> names;
  for (const TensorView& tensor : tensors_) names.push_back(tensor.name);
  const std::string nearest = nearest_word(name, names);
  fail("{}: no tensor \"{}\" among its {}{}; was it made by another network?", path_.string(), name,
       tensors_.size(), nearest.empty() ? "" : fmt::format(" (nearest: \"{}\")", shown(nearest)));
}

const std::string& SafetensorsFile::metadata_value(const std::string& key) const {
  const auto it = metadata_.find(key);
  if (it == metadata_.end())
    fail("{}: no \"{}\" in its metadata; expected a file written by this project", path_.string(), key);
  return it->second;
}

}  // namespace ld
