#include "frame/exr_check.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

#include "core/error.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

constexpr uint32_t kMagic = 0x01312f76;
constexpr uint32_t kTiledFlag = 0x200, kDeepFlag = 0x800, kMultiPartFlag = 0x1000, kKnownFlags = 0x1e00;
constexpr uint64_t kMaxNameBytes = 255;
constexpr uint64_t kMaxParsedAttribute = uint64_t{1}
                                         << 20;  // of those read here; a channel takes about 20 bytes

/// What the library calls a compression, lines of a scan-line chunk, and the most it can shrink pixels by.
struct Compression {
  const char* name;
  uint64_t lines;
  uint64_t best_ratio;
};
// Deflate's bound is 1032:1 (zlib technical notes); PXR24 drops a quarter of a float first. RLE stores up to
// 128 bytes in 2, B44A 32 bytes in 3. PIZ and DWA have no useful bound: an empty chunk takes some 50 bytes.
constexpr std::array<Compression, 10> kCompressions = {{{"NONE", 1, 1},
                                                        {"RLE", 1, 70},
                                                        {"ZIPS", 1, 1100},
                                                        {"ZIP", 16, 1100},
                                                        {"PIZ", 32, 100000},
                                                        {"PXR24", 16, 1500},
                                                        {"B44", 32, 12},
                                                        {"B44A", 32, 12},
                                                        {"DWAA", 32, 100000},
                                                        {"DWAB", 256, 100000}}};

struct RawPart {
  std::string name, type;
  int64_t width = 0, height = 0;
  bool has_window = false, has_channels = false, has_compression = false, tiled = false, one_level = true;
  uint64_t line_bytes = 0;  // of all channels, had each every line
  uint64_t tile_width = 0, tile_height = 0;
  size_t compression = 0;
  int64_t chunk_count = -1;
};

class HeaderScan {
 public:
  explicit HeaderScan(const fs::path& path) : path_(path.string()) {
    std::error_code error;
    if (!fs::exists(path, error)) fail("no such file: {}; check the path", path_);
    if (fs::is_directory(path, error)) fail("{} is a folder; expected an OpenEXR file", path_);
    size_ = fs::file_size(path, error);
    file_.open(path, std::ios::binary);
    if (error || !file_) fail("cannot open {}; check that it is readable", path_);
  }

  void run() {
    if (size_ < 8 || number<uint32_t>() != kMagic)
      fail("{}: not an OpenEXR file ({} bytes, no magic number); expected a .exr written by a renderer",
           path_, size_);
    const auto version = number<uint32_t>();
    if ((version & 0xff) > 2 || (version & ~(kKnownFlags | 0xffU)) != 0)
      fail("{}: OpenEXR format version {:#x}; expected version 2; write it with OpenEXR 2 or 3", path_,
           version);
    if ((version & kDeepFlag) != 0) fail_deep();
    const bool multi_part = (version & kMultiPartFlag) != 0;
    do {
      parts_.emplace_back();
      parts_.back().tiled = (version & kTiledFlag) != 0;
      read_part();
      if (parts_.size() > size_t{kMaxExrParts}) fail("{}: more than {} parts", path_, kMaxExrParts);
    } while (multi_part && peek() != 0);
    if (multi_part) number<uint8_t>();
    for (RawPart& part : parts_) check_part(part, multi_part);
    check_size();
    check_chunks(multi_part);
  }

 private:
  [[noreturn]] void fail_short(const std::string& where) const {
    fail("{}: cut short {} ({} bytes in the file); copy or render it again", path_, where, size_);
  }
  [[noreturn]] void fail_deep() const {
    fail("{}: holds deep data; expected flat parts, one for each sample; see docs/data_format.md", path_);
  }

  /// For complaints: the file, and the part when it is known by name.
  std::string where(const RawPart& part) const {
    return part.name.empty() ? path_ : fmt::format("{}: part '{}'", path_, part.name);
  }

  uint64_t position() { return static_cast<uint64_t>(file_.tellg()); }

  int peek() {
    const int next = file_.peek();
    if (next == std::char_traits<char>::eof()) fail_short("within its header");
    return next;
  }

  template <class Number>
  Number number() {
    // EXR is little endian, as are the machines this project supports.
    Number value{};
    if (!file_.read(reinterpret_cast<char*>(&value), sizeof value)) fail_short("within its header");
    return value;
  }

  std::string text() {
    std::string result;
    while (const int c = number<uint8_t>()) {
      result += static_cast<char>(c);
      if (result.size() > kMaxNameBytes)
        fail("{}: a name in the header has more than {} bytes; the header is damaged", path_, kMaxNameBytes);
    }
    return result;
  }

  void read_part() {
    RawPart& part = parts_.back();
    for (std::string name = text(); !name.empty(); name = text()) {
      const std::string type = text();
      const auto bytes = static_cast<uint64_t>(number<uint32_t>());
      const uint64_t start = position();
      if (bytes > size_ - start) fail_short(fmt::format("within its header, in the attribute '{}'", name));
      read_attribute(part, name, type, bytes);
      file_.seekg(static_cast<std::streamoff>(start + bytes));
    }
  }

  void read_attribute(RawPart& part, const std::string& name, const std::string& type, uint64_t bytes) {
    const auto expect = [&](bool fits) {
      if (!fits || bytes > kMaxParsedAttribute)
        fail(
            "{}: the attribute '{}' is of type '{}' with {} bytes, which is not what OpenEXR defines; the "
            "header is "
            "damaged",
            where(part), name, type, bytes);
    };
    if (name == "dataWindow") {
      expect(type == "box2i" && bytes == 16);
      const int64_t left = number<int32_t>(), top = number<int32_t>();
      part.width = number<int32_t>() - left + 1;
      part.height = number<int32_t>() - top + 1;
      part.has_window = true;
    } else if (name == "channels") {
      expect(type == "chlist");
      part.has_channels = true;
      read_channels(part, bytes);
    } else if (name == "compression") {
      expect(type == "compression" && bytes == 1);
      part.compression = number<uint8_t>();
      part.has_compression = true;
      if (part.compression >= kCompressions.size())
        fail("{}: unknown compression {}; write it with ZIP", where(part), part.compression);
    } else if (name == "tiles") {
      expect(type == "tiledesc" && bytes == 9);
      part.tile_width = number<uint32_t>();
      part.tile_height = number<uint32_t>();
      part.one_level = (number<uint8_t>() & 0xf) == 0;
    } else if (name == "chunkCount") {
      expect(type == "int" && bytes == 4);
      part.chunk_count = number<int32_t>();
    } else if (name == "name" || name == "type") {
      expect(type == "string" && bytes <= kMaxNameBytes);
      std::string value(bytes, '\0');
      file_.read(value.data(), static_cast<std::streamsize>(bytes));
      (name == "name" ? part.name : part.type) = value;
    } else if (type == "preview") {
      expect(bytes >= 8);
      const auto width = static_cast<uint64_t>(number<uint32_t>()),
                 height = static_cast<uint64_t>(number<uint32_t>());
      expect(width <= kMaxImageSide && height <= kMaxImageSide && bytes == 8 + 4 * width * height);
    } else if (type == "idmanifest") {
      fail("{}: the attribute '{}' is an ID manifest, which belongs to deep data; write the file without it",
           where(part), name);
    }
  }

  void read_channels(RawPart& part, uint64_t bytes) {
    const uint64_t end = position() + bytes;
    for (std::string name = text(); !name.empty(); name = text()) {
      const auto type = number<uint32_t>();
      number<uint32_t>();  // perceptual linearity, reserved
      const auto x_step = number<int32_t>(), y_step = number<int32_t>();
      if (type > 2 || x_step < 1 || y_step < 1 || position() > end)
        fail("{}: channel '{}' has pixel type {} and sampling {} x {}; the header is damaged", where(part),
             name, type, x_step, y_step);
      // Subsampled channels are refused where they are needed; here they count least.
      if (x_step == 1 && y_step == 1) part.line_bytes += type == 1 ? 2 : 4;
    }
  }

  void check_part(RawPart& part, bool multi_part) {
    if (!part.has_window || !part.has_channels || !part.has_compression)
      fail("{}: the header lacks '{}'; the file is damaged", where(part),
           !part.has_window     ? "dataWindow"
           : !part.has_channels ? "channels"
                                : "compression");
    if (part.type.rfind("deep", 0) == 0) fail_deep();
    if (!part.type.empty()) part.tiled = part.type == "tiledimage";
    if (part.width < 1 || part.height < 1 || part.width > kMaxImageSide || part.height > kMaxImageSide)
      fail("{}: the data window is {} x {} pixels; expected from 1 x 1 to {} x {}", where(part), part.width,
           part.height, kMaxImageSide, kMaxImageSide);
    if (part.tiled &&
        (part.tile_width < 1 || part.tile_height < 1 || part.tile_width > 4096 || part.tile_height > 4096))
      fail("{}: tiles of {} x {} pixels; expected from 1 x 1 to 4096 x 4096", where(part), part.tile_width,
           part.tile_height);
    if (multi_part && (part.type.empty() || part.name.empty() || part.chunk_count < 1))
      fail("{}: a part lacks its name, type or chunkCount; the header is damaged", where(part));
    if (part.tiled && !part.one_level) return;  // mip maps: only OpenEXR knows how many chunks
    const auto width = static_cast<uint64_t>(part.width), height = static_cast<uint64_t>(part.height);
    const uint64_t lines = kCompressions[part.compression].lines;
    const auto blocks = [](uint64_t size, uint64_t block) { return (size + block - 1) / block; };
    const auto expected =
        static_cast<int64_t>(part.tiled ? blocks(width, part.tile_width) * blocks(height, part.tile_height)
                                        : blocks(height, lines));
    if (multi_part && part.chunk_count != expected)
      fail("{}: chunkCount is {}; expected {} for {} x {} pixels; the header is damaged", where(part),
           part.chunk_count, expected, width, height);
    part.chunk_count = expected;
  }

  /// No compression makes the declared pixels fit into fewer bytes than this.
  void check_size() {
    uint64_t least = 0, pixels_bytes = 0;
    for (const RawPart& part : parts_) {
      const uint64_t bytes =
          part.line_bytes * static_cast<uint64_t>(part.width) * static_cast<uint64_t>(part.height);
      pixels_bytes += bytes;
      least += bytes / kCompressions[part.compression].best_ratio;
      least +=
          static_cast<uint64_t>(std::max<int64_t>(part.chunk_count, 0)) * 16;  // table entry and chunk header
    }
    if (least > size_)
      fail(
          "{}: the header declares {} bytes of pixels ({} parts, the first {} x {}), which cannot be in a "
          "file of {} "
          "bytes; it is cut short or its header is damaged; copy or render it again",
          path_, pixels_bytes, parts_.size(), parts_[0].width, parts_[0].height, size_);
  }

  /// Every chunk has been written, and the last of them ends within the file.
  void check_chunks(bool multi_part) {
    uint64_t last = 0;
    bool last_tiled = false;
    for (const RawPart& part : parts_) {
      if (part.chunk_count < 0) return;
      for (int64_t i = 0; i < part.chunk_count; ++i) {
        const auto offset = number<uint64_t>();
        if (offset == 0)
          fail("{}: incomplete, chunk {} of {} was never written; the renderer was stopped; render it again",
               where(part), i, part.chunk_count);
        if (offset >= size_)
          fail_short(fmt::format("after byte {}, where pixels should follow at {}", size_, offset));
        if (offset > last) {
          last = offset;
          last_tiled = part.tiled;
        }
      }
    }
    // A chunk: part number in multi-part files, then tile x, y, level x, level y or the line; then the data's
    // size.
    const uint64_t data_size_at = last + (multi_part ? 4 : 0) + (last_tiled ? 16 : 4);
    if (data_size_at + 4 > size_) fail_short("within its last chunk");
    file_.seekg(static_cast<std::streamoff>(data_size_at));
    const auto data_size = static_cast<uint64_t>(number<uint32_t>());
    if (data_size_at + 4 + data_size > size_)
      fail("{}: cut short, its last chunk ends at byte {} of {}; copy or render it again", path_,
           data_size_at + 4 + data_size, size_);
  }

  std::string path_;
  uint64_t size_ = 0;
  std::ifstream file_;
  std::vector<RawPart> parts_;
};

}  // namespace

void check_exr_file(const fs::path& path) {
  HeaderScan(path).run();
}

}  // namespace ld
