#include "frame/exr_check.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <vector>

#include "core/error.h"
#include "frame/exr_raw_header.h"

namespace ld {
namespace {

/// By OpenEXR's number: lines of a scan-line chunk, the most it can shrink pixels by, and whether it is plain
/// deflate.
struct Compression {
  uint64_t lines;
  uint64_t best_ratio;
  bool deflate;
};
// Deflate's bound is 1032:1 (zlib's technical notes); PXR24 drops a quarter of a float first. RLE stores up
// to 128 bytes in 2, B44A 32 bytes in 3. PIZ and DWA have no useful bound: an empty chunk takes some 50
// bytes.
constexpr std::array<Compression, 10> kCompressions = {{{1, 1, false},           // none
                                                        {1, 70, false},          // RLE
                                                        {1, 1100, true},         // ZIPS
                                                        {16, 1100, true},        // ZIP
                                                        {32, 100000, false},     // PIZ
                                                        {16, 1500, false},       // PXR24
                                                        {32, 12, false},         // B44
                                                        {32, 12, false},         // B44A
                                                        {32, 100000, false},     // DWAA
                                                        {256, 100000, false}}};  // DWAB

uint64_t divide_up(uint64_t size, uint64_t block) {
  return (size + block - 1) / block;
}

/// Completes chunk_count and `tiled`.
void check_part(ExrRawPart& part, bool multi_part, const std::string& path) {
  const std::string where = part.where(path);
  if (!part.has_window || !part.has_channels || !part.has_compression)
    fail("{}: the header lacks '{}'; the file is damaged", where,
         !part.has_window ? "dataWindow" : (!part.has_channels ? "channels" : "compression"));
  if (part.type.rfind("deep", 0) == 0) fail_deep(path);
  if (part.compression >= kCompressions.size())
    fail("{}: unknown compression {}; write it with ZIP", where, part.compression);
  if (!part.type.empty()) part.tiled = part.type == "tiledimage";
  if (part.width < 1 || part.height < 1 || part.width > kMaxImageSide || part.height > kMaxImageSide)
    fail("{}: the data window is {} x {} pixels; expected from 1 x 1 to {} x {}", where, part.width,
         part.height, kMaxImageSide, kMaxImageSide);
  if (part.tiled &&
      (part.tile_width < 1 || part.tile_height < 1 || part.tile_width > 4096 || part.tile_height > 4096))
    fail("{}: tiles of {} x {} pixels; expected from 1 x 1 to 4096 x 4096", where, part.tile_width,
         part.tile_height);
  if (multi_part && (part.type.empty() || part.name.empty() || part.chunk_count < 1))
    fail("{}: a part lacks its name, type or chunkCount; the header is damaged", where);
  if (part.tiled && !part.one_level) return;  // mip maps: only OpenEXR knows how many chunks
  const auto width = static_cast<uint64_t>(part.width), height = static_cast<uint64_t>(part.height);
  const uint64_t chunks = part.tiled ? divide_up(width, part.tile_width) * divide_up(height, part.tile_height)
                                     : divide_up(height, kCompressions[part.compression].lines);
  const auto expected = static_cast<int64_t>(chunks);
  if (multi_part && part.chunk_count != expected)
    fail("{}: chunkCount is {}; expected {} for {} x {} pixels; the header is damaged", where,
         part.chunk_count, expected, width, height);
  part.chunk_count = expected;
}

/// No compression makes the declared pixels fit into fewer bytes than this.
void check_size(const std::vector<ExrRawPart>& parts, const ExrBytes& file) {
  uint64_t least = 0, pixels_bytes = 0;
  for (const ExrRawPart& part : parts) {
    const uint64_t bytes =
        part.pixel_bytes * static_cast<uint64_t>(part.width) * static_cast<uint64_t>(part.height);
    pixels_bytes += bytes;
    least += bytes / kCompressions[part.compression].best_ratio;
    least +=
        static_cast<uint64_t>(std::max<int64_t>(part.chunk_count, 0)) * 16;  // table entry and chunk header
  }
  if (least > file.size())
    fail(
        "{}: the header declares {} bytes of pixels ({} parts, the first {} x {}), which cannot be in a file "
        "of {} "
        "bytes; it is cut short or its header is damaged; copy or render it again",
        file.path(), pixels_bytes, parts.size(), parts[0].width, parts[0].height, file.size());
}

/// Bytes of the pixels of chunk `index` of the part.
uint64_t chunk_pixel_bytes(const ExrRawPart& part, uint64_t index) {
  const auto width = static_cast<uint64_t>(part.width), height = static_cast<uint64_t>(part.height);
  const uint64_t lines = part.tiled ? part.tile_height : kCompressions[part.compression].lines;
  const uint64_t columns = part.tiled ? part.tile_width : width;
  const uint64_t across = divide_up(width, columns);
  const uint64_t x = index % across * columns, y = index / across * lines;
  return std::min(columns, width - x) * std::min(lines, height - y) * part.pixel_bytes;
}

/// How many bytes `packed` unpacks to, at most `limit` + 1; 0 when it is not deflate data.
uint64_t unpacked_bytes(const std::vector<uint8_t>& packed, uint64_t limit) {
  std::vector<uint8_t> unpacked(limit + 1);
  auto bytes = static_cast<uLongf>(unpacked.size());
  return uncompress(unpacked.data(), &bytes, packed.data(), static_cast<uLong>(packed.size())) == Z_OK ? bytes
                                                                                                       : 0;
}

/// A chunk: part number in multi-part files, then tile x, y, level x, level y or the line; the data's size;
/// the data.
void check_chunk(ExrBytes& file, const ExrRawPart& part, bool multi_part, uint64_t index, uint64_t offset) {
  constexpr const char* kInside = "within its pixels";
  file.seek(offset + (multi_part ? 4 : 0) + (part.tiled ? 16 : 4));
  const auto bytes = uint64_t{file.number<uint32_t>(kInside)};
  if (bytes > file.size() - file.position()) file.fail_short(kInside);
  if (part.subsampled) return;
  const uint64_t expected = chunk_pixel_bytes(part, index);
  const Compression& compression = kCompressions[part.compression];
  uint64_t found = bytes;  // a chunk that does not shrink is stored as it is
  if (bytes < expected && compression.deflate) {
    std::vector<uint8_t> packed(bytes);
    file.read(packed.data(), bytes, kInside);
    found = unpacked_bytes(packed, expected);
  } else if (bytes < expected && compression.best_ratio > 1) {
    return;
  }
  if (found != expected)
    fail(
        "{}: chunk {} does not hold the {} bytes of pixels that the header promises; the file is damaged; "
        "copy or "
        "render it again",
        part.where(file.path()), index, expected);
}

/// Every chunk has been written and begins within the file; the first and the last of each part are as large
/// as the header says. A wrong data window, channel list or tile size shows in one of the two.
std::vector<std::vector<uint64_t>> check_chunks(ExrBytes& file, const std::vector<ExrRawPart>& parts,
                                                bool multi_part) {
  struct Chunk {
    uint64_t index, offset;
  };
  std::vector<std::vector<Chunk>> checked(parts.size());
  std::vector<std::vector<uint64_t>> offsets(parts.size());
  Chunk last = {0, 0};
  const ExrRawPart* last_part = nullptr;
  for (size_t i = 0; i < parts.size(); ++i) {
    if (parts[i].chunk_count < 0) break;  // where the next table starts is unknown
    const auto count = static_cast<uint64_t>(parts[i].chunk_count);
    for (uint64_t index = 0; index < count; ++index) {
      const auto offset = file.number<uint64_t>();
      if (offset == 0)
        fail("{}: incomplete, chunk {} of {} was never written; the renderer was stopped; render it again",
             parts[i].where(file.path()), index, count);
      if (offset >= file.size()) file.fail_short(fmt::format("before its pixels at byte {}", offset));
      if (parts[i].tiled && !parts[i].one_level) continue;
      offsets[i].push_back(offset);
      if (index == 0 || index + 1 == count) checked[i].push_back({index, offset});
      if (offset > last.offset) {
        last = {index, offset};
        last_part = &parts[i];
      }
    }
  }
  for (size_t i = 0; i < parts.size(); ++i)
    for (const Chunk& chunk : checked[i]) check_chunk(file, parts[i], multi_part, chunk.index, chunk.offset);
  if (last_part != nullptr) check_chunk(file, *last_part, multi_part, last.index, last.offset);
  return offsets;
}

}  // namespace

void fail_deep(const std::string& path) {
  fail("{}: holds deep data; expected flat parts, one for each sample; see docs/data_format.md", path);
}

int lines_of_chunk(const ExrRawPart& part) {
  return static_cast<int>(kCompressions[part.compression].lines);
}

ExrChunks check_exr_file(const std::filesystem::path& path) {
  ExrBytes file(path);
  ExrChunks chunks;
  chunks.parts = read_raw_headers(file, chunks.multi_part);
  for (ExrRawPart& part : chunks.parts) check_part(part, chunks.multi_part, file.path());
  check_size(chunks.parts, file);
  chunks.offsets = check_chunks(file, chunks.parts, chunks.multi_part);
  return chunks;
}

}  // namespace ld
