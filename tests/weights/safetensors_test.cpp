#include "weights/safetensors.h"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>

#include "core/file_io.h"
#include "core/random.h"
#include "tests/support/damage.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

/// Header text and data as a file; the length is the header's unless given.
void write_raw(const fs::path& path, const std::string& header, const std::string& data,
               uint64_t length = UINT64_MAX) {
  if (length == UINT64_MAX) length = header.size();
  std::string bytes(8, '\0');
  std::memcpy(bytes.data(), &length, 8);
  std::ofstream(path, std::ios::binary) << bytes << header << data;
}

struct Sample {
  std::vector<float> floats = {1.5F, -2, 3, 4, 5, 6};
  std::vector<uint16_t> halves = {0x3c00, 0x7bff, 0};
  std::vector<double> doubles = {0.1};
  std::vector<int64_t> integers = {-1, INT64_MAX};
  std::vector<uint8_t> bytes = {255};

  std::vector<TensorView> views() const {
    return {
        {"b.weight", DType::f32, {2, 3}, floats.data(), 24}, {"mask", DType::u8, {1}, bytes.data(), 1},
        {"a.half", DType::f16, {3, 1}, halves.data(), 6},    {"scalar", DType::f64, {}, doubles.data(), 8},
        {"steps", DType::i64, {2}, integers.data(), 16},     {"empty", DType::f32, {4, 0, 2}, nullptr, 0}};
  }
};

TEST(Safetensors, RoundTripOfEveryType) {
  const TemporaryFolder folder;
  const Sample sample;
  const Metadata metadata = {{"format", "test"}, {"text", "quote \" newline \n umlaut \xc3\xa4"}};
  write_safetensors(folder / "file.safetensors", sample.views(), metadata);
  const SafetensorsFile file(folder / "file.safetensors");
  EXPECT_EQ(file.metadata(), metadata);
  EXPECT_EQ(file.metadata_value("format"), "test");
  ASSERT_EQ(file.tensors().size(), sample.views().size());
  for (const TensorView& expected : sample.views()) {
    const TensorView& found = file.tensor(expected.name);
    EXPECT_EQ(found.type, expected.type) << expected.name;
    EXPECT_EQ(found.shape, expected.shape) << expected.name;
    ASSERT_EQ(found.bytes, expected.bytes) << expected.name;
    EXPECT_EQ(std::string(static_cast<const char*>(found.data), found.bytes),
              std::string(static_cast<const char*>(expected.bytes > 0 ? expected.data : ""), expected.bytes))
        << expected.name;
    EXPECT_EQ(reinterpret_cast<uintptr_t>(found.data) % dtype_bytes(found.type), 0u) << expected.name;
  }
  EXPECT_ERROR(file.tensor("b.weigth"), "nearest: \"b.weight\"");
  EXPECT_ERROR(file.metadata_value("none"), "no \"none\" in its metadata");
}

TEST(Safetensors, TheSameTensorsGiveTheSameBytesInAnyOrder) {
  const TemporaryFolder folder;
  const Sample sample;
  std::vector<TensorView> views = sample.views();
  write_safetensors(folder / "a", views, {{"k", "v"}, {"l", "w"}});
  std::reverse(views.begin(), views.end());
  write_safetensors(folder / "b", views, {{"l", "w"}, {"k", "v"}});
  EXPECT_EQ(read_file(folder / "a"), read_file(folder / "b"));
}

TEST(Safetensors, RefusesToWriteWhatItCouldNotRead) {
  const TemporaryFolder folder;
  const Sample sample;
  const auto write = [&](const TensorView& view, const Metadata& metadata = {}) {
    write_safetensors(folder / "file", {view, {"other", DType::u8, {1}, sample.bytes.data(), 1}}, metadata);
  };
  EXPECT_ERROR(write({"a", DType::f32, {2, 2}, sample.floats.data(), 24}), "tensor \"a\" has 24 bytes");
  EXPECT_ERROR(write({"a", DType::f32, {-1, -6}, sample.floats.data(), 24}), "tensor \"a\"");
  EXPECT_ERROR(write({"a", DType::f32, {6}, nullptr, 24}), "tensor \"a\"");
  EXPECT_ERROR(write({"", DType::f32, {6}, sample.floats.data(), 24}), "tensor \"\"");
  EXPECT_ERROR(write({"__metadata__", DType::f32, {6}, sample.floats.data(), 24}), "__metadata__");
  EXPECT_ERROR(write({"other", DType::f32, {6}, sample.floats.data(), 24}), "two tensors \"other\"");
  EXPECT_ERROR(write({"a", DType::f32, {6}, sample.floats.data(), 24}, {{"k", "\xff"}}), "not UTF-8");
  EXPECT_FALSE(fs::exists(folder / "file"));
}

TEST(Safetensors, CutShortAtEveryLengthIsAnError) {
  const TemporaryFolder folder;
  const Sample sample;
  write_safetensors(folder / "whole", sample.views(), {{"format", "test"}});
  const std::string bytes = read_file(folder / "whole");
  for (size_t length = 0; length < bytes.size(); ++length) {
    write_new_file(folder / "cut", bytes.substr(0, length));
    const std::string text = error_text([&] { SafetensorsFile file(folder / "cut"); });
    EXPECT_NE(text.find("cut: "), std::string::npos) << length << ": " << text;
    if (HasFailure()) return;
  }
  std::ofstream(folder / "long", std::ios::binary) << bytes << "x";
  EXPECT_ERROR(SafetensorsFile(folder / "long"), "has something appended");
}

TEST(Safetensors, EveryLieIsNamed) {
  const TemporaryFolder folder;
  const fs::path path = folder / "file";
  EXPECT_ERROR(SafetensorsFile(folder / "none"), "cannot open");
  EXPECT_ERROR(SafetensorsFile(folder.path()), "no regular file");
  const auto read = [&](const std::string& header, const std::string& data = "12345678",
                        uint64_t length = UINT64_MAX) {
    write_raw(path, header, data, length);
    SafetensorsFile file(path);
  };
  const auto read_tensor = [&](const std::string& entry) { read("{\"t\": " + entry + "}"); };
  EXPECT_ERROR(read("{}", "", 3), "the header's length says 3 bytes, but 2 follow");
  EXPECT_ERROR(read("{}", "", uint64_t{1} << 63), "the header's length says");
  EXPECT_ERROR(read("{}", "", UINT64_MAX - 7), "the header's length says");
  EXPECT_ERROR(read("{\"t\"", ""), "not valid JSON");
  EXPECT_ERROR(read("", ""), "not valid JSON");
  EXPECT_ERROR(read("\xff\xfe", ""), "not valid JSON");
  EXPECT_ERROR(read("[]", ""), "the header is array");
  EXPECT_ERROR(read("{}"), "8 bytes of data, but the tensors take 0");
  EXPECT_ERROR(read(std::string(200000, '['), ""), "deep");
  EXPECT_ERROR(read("{\"__metadata__\": 3}", ""), "__metadata__: is number");
  EXPECT_ERROR(read("{\"__metadata__\": {\"steps\": 3}}", ""),
               "\"steps\" is number; the format allows texts only");
  EXPECT_ERROR(read_tensor("5"), "tensor \"t\": is number");
  EXPECT_ERROR(read_tensor(R"({"dtype": "F32", "shape": [2], "data_offsets": [0, 8], "x": 1})"),
               "unknown key \"x\"");
  EXPECT_ERROR(read_tensor(R"({"shape": [2], "data_offsets": [0, 8]})"), "no text \"dtype\"");
  EXPECT_ERROR(read_tensor(R"({"dtype": "BF16", "shape": [4], "data_offsets": [0, 8]})"), "dtype \"BF16\"");
  EXPECT_ERROR(read_tensor(R"({"dtype": "F32", "data_offsets": [0, 8]})"), "no list \"shape\"");
  EXPECT_ERROR(read_tensor(R"({"dtype": "F32", "shape": [-2], "data_offsets": [0, 8]})"),
               "\"shape\" holds -2");
  EXPECT_ERROR(read_tensor(R"({"dtype": "F32", "shape": [2.0], "data_offsets": [0, 8]})"),
               "\"shape\" holds 2.0");
  EXPECT_ERROR(read_tensor(R"({"dtype": "F32", "shape": [2], "data_offsets": [0]})"),
               "expected [begin, end]");
  EXPECT_ERROR(read_tensor(R"({"dtype": "F32", "shape": [2], "data_offsets": [8, 0]})"),
               "expected [begin, end]");
  EXPECT_ERROR(read_tensor(R"({"dtype": "F32", "shape": [2], "data_offsets": [4, 12]})"),
               "expected [begin, end]");
  EXPECT_ERROR(read_tensor(R"({"dtype": "F32", "shape": [2], "data_offsets": [0, 18446744073709551615]})"),
               "holds 1844");
  EXPECT_ERROR(read_tensor(R"({"dtype": "F32", "shape": [3], "data_offsets": [0, 8]})"),
               "takes 12 bytes, but data_offsets span 8");
  EXPECT_ERROR(
      read_tensor(R"({"dtype": "F32", "shape": [4611686018427387904, 4, 2], "data_offsets": [0, 8]})"),
      "takes more than 2^63 bytes");
  EXPECT_ERROR(read_tensor(R"({"dtype": "U8", "shape": [4], "data_offsets": [4, 8]})"), "leave a gap");
  EXPECT_ERROR(read_tensor(R"({"dtype": "U8", "shape": [4], "data_offsets": [0, 4]})"),
               "but the tensors take 4");
  EXPECT_ERROR(read(R"({"a": {"dtype": "U8", "shape": [8], "data_offsets": [0, 8]},
                        "b": {"dtype": "U8", "shape": [4], "data_offsets": [4, 8]}})"),
               "overlap");
  EXPECT_ERROR(read(R"({"a": {"dtype": "U8", "shape": [8], "data_offsets": [0, 8]},
                        "a": {"dtype": "U8", "shape": [8], "data_offsets": [0, 8]}})"),
               "duplicate key \"a\"");
  read_tensor(R"({"dtype": "F32", "shape": [2], "data_offsets": [0, 8]})");
}

TEST(Safetensors, RandomBytesGiveAFileOrAnError) {
  const TemporaryFolder folder;
  const Sample sample;
  write_safetensors(folder / "whole", sample.views(), {{"format", "test"}});
  const std::string bytes = read_file(folder / "whole");
  int errors = 0;
  for (uint32_t trial = 0; trial < 3000; ++trial) {
    RandomStream random(9, RandomPurpose::test, trial);
    std::string changed = bytes;
    for (uint32_t flips = 1 + random.below(3); flips > 0; --flips)
      changed[random.below(static_cast<uint32_t>(bytes.size()))] = static_cast<char>(random.bits());
    write_new_file(folder / "fuzz", changed);
    SCOPED_TRACE("trial " + std::to_string(trial));
    try {
      const SafetensorsFile file(folder / "fuzz");
      std::string data;  // every byte that a view promises can be read
      for (const TensorView& tensor : file.tensors())
        data.append(static_cast<const char*>(tensor.data), tensor.bytes);
      EXPECT_LT(data.size(), bytes.size());
    } catch (const Error& error) {
      ++errors;
      EXPECT_NE(std::string(error.what()).find("fuzz"), std::string::npos) << error.what();
    }
  }
  EXPECT_GT(errors, 1000);
}

}  // namespace
}  // namespace ld
