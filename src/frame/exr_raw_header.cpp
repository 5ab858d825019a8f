#include "frame/exr_raw_header.h"

#include <algorithm>

#include "core/error.h"
#include "core/file_identity.h"
#include "frame/exr_check.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

constexpr uint32_t kMagic = 0x01312f76;
constexpr uint32_t kTiledFlag = 0x200, kDeepFlag = 0x800, kMultiPartFlag = 0x1000, kKnownFlags = 0x1e00;
constexpr uint64_t kMaxNameBytes = 255;
constexpr uint64_t kMaxParsedAttribute = uint64_t{1}
                                         << 20;  // of those read here; a channel takes about 20 bytes

/// Names stand in complaints, which are one line of text.
void check_printable(const ExrBytes& file, const std::string& text) {
  const bool control = std::any_of(text.begin(), text.end(), [](char c) {
    return static_cast<unsigned char>(c) < 32 || static_cast<unsigned char>(c) == 127;
  });
  if (control)
    fail("{}: a name in the header holds control characters; the header is damaged; copy or render it again",
         file.path());
}

std::string read_text(ExrBytes& file) {
  std::string text;
  while (const int c = file.number<uint8_t>()) {
    text += static_cast<char>(c);
    if (text.size() > kMaxNameBytes)
      fail("{}: a name in the header has more than {} bytes; the header is damaged", file.path(),
           kMaxNameBytes);
  }
  check_printable(file, text);
  return text;
}

void read_channels(ExrBytes& file, ExrRawPart& part, uint64_t bytes) {
  const uint64_t end = file.position() + bytes;
  for (std::string name = read_text(file); !name.empty(); name = read_text(file)) {
    const auto type = file.number<uint32_t>();
    file.number<uint32_t>();  // perceptual linearity, reserved
    const auto x_step = file.number<int32_t>(), y_step = file.number<int32_t>();
    if (type > 2 || x_step < 1 || y_step < 1 || file.position() > end)
      fail("{}: channel '{}' has pixel type {} and sampling {} x {}; the header is damaged",
           part.where(file.path()), name, type, x_step, y_step);
    // Subsampled channels are refused where they are needed; here they count least.
    if (x_step == 1 && y_step == 1)
      part.pixel_bytes += type == 1 ? 2 : 4;
    else
      part.subsampled = true;
  }
  part.has_channels = true;
}

void read_attribute(ExrBytes& file, ExrRawPart& part, const std::string& name, const std::string& type,
                    uint64_t bytes) {
  const auto expect = [&](bool fits) {
    if (!fits || bytes > kMaxParsedAttribute)
      fail(
          "{}: the attribute '{}' is of type '{}' with {} bytes, which is not what OpenEXR defines; the "
          "header is damaged",
          part.where(file.path()), name, type, bytes);
  };
  if (name == "dataWindow") {
    expect(type == "box2i" && bytes == 16);
    const int64_t left = file.number<int32_t>();
    part.top = file.number<int32_t>();
    part.width = file.number<int32_t>() - left + 1;
    part.height = file.number<int32_t>() - part.top + 1;
    part.has_window = true;
  } else if (name == "channels") {
    expect(type == "chlist");
    read_channels(file, part, bytes);
  } else if (name == "compression") {
    expect(type == "compression" && bytes == 1);
    part.compression = file.number<uint8_t>();
    part.has_compression = true;
  } else if (name == "tiles") {
    expect(type == "tiledesc" && bytes == 9);
    part.tile_width = file.number<uint32_t>();
    part.tile_height = file.number<uint32_t>();
    part.one_level = (file.number<uint8_t>() & 0xf) == 0;
  } else if (name == "chunkCount") {
    expect(type == "int" && bytes == 4);
    part.chunk_count = file.number<int32_t>();
  } else if (name == "name" || name == "type") {
    expect(type == "string" && bytes <= kMaxNameBytes);
    std::string value(bytes, '\0');
    file.read(value.data(), bytes, "within its header");
    check_printable(file, value);
    (name == "name" ? part.name : part.type) = value;
  } else if (type == "preview") {
    expect(bytes >= 8);
    const auto width = uint64_t{file.number<uint32_t>()}, height = uint64_t{file.number<uint32_t>()};
    expect(width <= kMaxImageSide && height <= kMaxImageSide && bytes == 8 + 4 * width * height);
  } else if (type == "stringvector") {
    // OpenEXR makes room for as many characters as each string claims.
    for (const uint64_t end = file.position() + bytes; file.position() < end;) {
      const auto length = uint64_t{file.number<uint32_t>()};
      expect(length <= end - std::min(end, file.position()));
      file.seek(file.position() + length);
    }
  } else if (type == "idmanifest") {
    fail("{}: the attribute '{}' is an ID manifest, which belongs to deep data; write the file without it",
         part.where(file.path()), name);
  }
}

}  // namespace

std::string ExrRawPart::where(const std::string& path) const {
  return name.empty() ? path : fmt::format("{}: part '{}'", path, name);
}

ExrBytes::ExrBytes(const fs::path& path) : path_(path.string()) {
  std::error_code error;
  if (!fs::exists(path, error)) fail("no such file: {}; check the path", path_);
  if (is_special(path)) fail("{} is no regular file; expected one that can be read again", path_);
  if (fs::is_directory(path, error)) fail("{} is a folder; expected an OpenEXR file", path_);
  size_ = fs::file_size(path, error);
  file_.open(path, std::ios::binary);
  if (error || !file_) fail("cannot open {}; check that it is a file and readable", path_);
}

void ExrBytes::read(void* to, size_t bytes, const char* where) {
  if (!file_.read(static_cast<char*>(to), static_cast<std::streamsize>(bytes))) fail_short(where);
}

void ExrBytes::fail_short(const std::string& where) const {
  fail("{}: cut short {} ({} bytes in the file); copy or render it again", path_, where, size_);
}

std::vector<ExrRawPart> read_raw_headers(ExrBytes& file, bool& multi_part) {
  if (file.size() < 8 || file.number<uint32_t>() != kMagic)
    fail("{}: not an OpenEXR file ({} bytes, no magic number); expected a .exr written by a renderer",
         file.path(), file.size());
  const auto version = file.number<uint32_t>();
  if ((version & 0xff) > 2 || (version & ~(kKnownFlags | 0xffU)) != 0)
    fail("{}: OpenEXR format version {:#x}; expected version 2; write it with OpenEXR 2 or 3", file.path(),
         version);
  if ((version & kDeepFlag) != 0) fail_deep(file.path());
  multi_part = (version & kMultiPartFlag) != 0;

  std::vector<ExrRawPart> parts;
  // An empty attribute name ends a part; an empty part ends a multi-part header.
  for (std::string name = read_text(file); !name.empty();) {
    if (parts.size() >= size_t{kMaxExrParts}) fail("{}: more than {} parts", file.path(), kMaxExrParts);
    ExrRawPart& part = parts.emplace_back();
    part.tiled = (version & kTiledFlag) != 0;
    for (; !name.empty(); name = read_text(file)) {
      const std::string type = read_text(file);
      const auto bytes = uint64_t{file.number<uint32_t>()};
      const uint64_t start = file.position();
      if (bytes > file.size() - start)
        file.fail_short(fmt::format("within its header, in the attribute '{}'", name));
      read_attribute(file, part, name, type, bytes);
      file.seek(start + bytes);
    }
    if (multi_part) name = read_text(file);
  }
  if (parts.empty()) fail("{}: an empty header; the file is damaged", file.path());
  return parts;
}

}  // namespace ld
