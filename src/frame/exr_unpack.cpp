#include "frame/exr_unpack.h"

#include <fcntl.h>
#include <libdeflate.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <new>

#include "core/error.h"
#include "frame/exr_reader.h"
#include "frame/half_rows.h"

namespace ld {
namespace {

constexpr size_t kNone = 0, kZips = 2, kZip = 3;  // OpenEXR's numbers of compressions
constexpr int kBandRows = 64;                     // at least, of a part that is not tiled

/// A plane, and where its channel lies among the words of 16 bits that a row of a chunk has for each pixel.
struct UnpackedPlane {
  size_t first_word;
  bool is_half;
  float* pixels;
};

/// Bytes of a chunk, which deflated chunks have in two halves: low bytes of words, then high ones.
struct ChunkBytes {
  const uint8_t *low, *high;
  size_t step;  // from word to word
};

/// A thread's memory for the chunks of a band.
struct ChunkMemory {
  std::vector<uint8_t> packed, unpacked;
  std::unique_ptr<libdeflate_decompressor, void (*)(libdeflate_decompressor*)> decompressor{
      libdeflate_alloc_decompressor(), libdeflate_free_decompressor};

  /// Whether `packed` holds exactly as many bytes as `unpacked` has.
  bool unpack() {
    if (!decompressor) throw std::bad_alloc();
    return libdeflate_zlib_decompress(decompressor.get(), packed.data(), packed.size(), unpacked.data(),
                                      unpacked.size(), nullptr) == LIBDEFLATE_SUCCESS;
  }
};

class Unpacker : public ExrUnpacker {
 public:
  Unpacker(const ExrFile& file, const std::string& path, const ExrChunks& chunks, size_t part)
      : file_(file),
        where_(chunks.parts[part].where(path)),
        header_(chunks.parts[part]),
        offsets_(chunks.offsets[part]),
        part_(chunks.multi_part ? static_cast<int>(part) : -1),
        width_(static_cast<int>(header_.width)),
        height_(static_cast<int>(header_.height)),
        chunk_width_(header_.tiled ? static_cast<int>(header_.tile_width) : width_),
        chunk_height_(header_.tiled ? static_cast<int>(header_.tile_height) : lines_of_chunk(header_)),
        across_((width_ + chunk_width_ - 1) / chunk_width_),
        band_rows_(header_.tiled ? chunk_height_ : std::max(chunk_height_, kBandRows)) {}

  void add(const UnpackedPlane& plane) { planes_.push_back(plane); }
  void set_words(size_t words) { words_ = words; }

  int bands() const override { return (height_ + band_rows_ - 1) / band_rows_; }

  std::pair<int, int> read(int band) const override {
    const int top = band * band_rows_, bottom = std::min(top + band_rows_, height_);
    ChunkMemory memory;
    for (int y = top; y < bottom; y += chunk_height_)
      for (int column = 0; column < across_; ++column) read_chunk(y, column, memory);
    return {top, bottom - top};
  }

 private:
  [[noreturn]] void fail_damaged(size_t chunk, const char* what) const {
    fail("{}: cannot read its pixels: chunk {} {}; the file is damaged; copy or render it again", where_,
         chunk, what);
  }

  void read_bytes(size_t chunk, void* to, size_t bytes, uint64_t offset) const {
    if (!file_.read(to, bytes, offset)) fail_damaged(chunk, "is cut short");
  }

  /// Reads what stands before the bytes of a chunk, and then these. A chunk begins with its part in files of
  /// several, then its tile and level or its first line, then its size.
  void read_packed(int y, int column, size_t chunk, size_t most, std::vector<uint8_t>& packed) const;
  void read_chunk(int y, int column, ChunkMemory& memory) const;
  void spread(int x, int y, int columns, int rows, const ChunkBytes& bytes) const;

  const ExrFile& file_;
  std::string where_;
  const ExrRawPart& header_;
  const std::vector<uint64_t>& offsets_;
  int part_, width_, height_, chunk_width_, chunk_height_, across_, band_rows_;
  size_t words_ = 0;
  std::vector<UnpackedPlane> planes_;
};

void Unpacker::read_packed(int y, int column, size_t chunk, size_t most, std::vector<uint8_t>& packed) const {
  int32_t head[6];
  const size_t numbers = (part_ >= 0 ? 1 : 0) + (header_.tiled ? 4 : 1) + 1;
  read_bytes(chunk, head, numbers * sizeof *head, offsets_[chunk]);
  const int32_t* number = head;
  bool right = part_ < 0 || *number++ == part_;
  if (header_.tiled) {
    right =
        right && number[0] == column && number[1] == y / chunk_height_ && number[2] == 0 && number[3] == 0;
    number += 4;
  } else {
    right = right && *number++ == header_.top + y;
  }
  if (!right) fail_damaged(chunk, "is another one");
  if (*number < 0 || static_cast<size_t>(*number) > most) fail_damaged(chunk, "is too large");
  packed.resize(static_cast<size_t>(*number));
  read_bytes(chunk, packed.data(), packed.size(), offsets_[chunk] + numbers * sizeof *head);
}

void Unpacker::read_chunk(int y, int column, ChunkMemory& memory) const {
  const int x = column * chunk_width_;
  const int columns = std::min(chunk_width_, width_ - x), rows = std::min(chunk_height_, height_ - y);
  const size_t size = static_cast<size_t>(columns) * static_cast<size_t>(rows) * words_ * 2;
  const int index = y / chunk_height_ * across_ + column;
  const auto chunk = static_cast<size_t>(index);
  const std::vector<uint8_t>&packed = memory.packed, &unpacked = memory.unpacked;
  read_packed(y, column, chunk, size, memory.packed);
  if (packed.size() == size) {  // what does not shrink is stored as it is
    spread(x, y, columns, rows, {packed.data(), packed.data() + 1, 2});
    return;
  }
  memory.unpacked.resize(size);
  if (header_.compression == kNone || !memory.unpack())
    fail_damaged(chunk, "does not hold the pixels that the header promises");
  undo_differences(memory.unpacked.data(), size);
  spread(x, y, columns, rows, {unpacked.data(), unpacked.data() + size / 2, 1});
}

void Unpacker::spread(int x, int y, int columns, int rows, const ChunkBytes& bytes) const {
  const auto count = static_cast<size_t>(columns);
  for (int row = 0; row < rows; ++row)
    for (const UnpackedPlane& plane : planes_) {
      const size_t word = (static_cast<size_t>(row) * words_ + plane.first_word) * count * bytes.step;
      const uint8_t *low = bytes.low + word, *high = bytes.high + word;
      float* const values = plane.pixels + static_cast<size_t>(y + row) * static_cast<size_t>(width_) + x;
      if (plane.is_half && bytes.step == 1) {
        split_half_to_float(low, high, values, count);
      } else if (plane.is_half) {
        half_to_float(reinterpret_cast<const uint16_t*>(low), values, count);
      } else {
        for (size_t i = 0; i < count; ++i, low += 2 * bytes.step, high += 2 * bytes.step) {
          const uint32_t bits = low[0] | uint32_t{high[0]} << 8 | uint32_t{low[bytes.step]} << 16 |
                                uint32_t{high[bytes.step]} << 24;
          std::memcpy(values + i, &bits, sizeof bits);
        }
      }
    }
}

}  // namespace

ExrFile::ExrFile(const std::string& path) : file_(open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
  if (file_ < 0) fail("cannot open {}: {}; check that it is a file and readable", path, std::strerror(errno));
}

ExrFile::~ExrFile() {
  close(file_);
}

bool ExrFile::read(void* to, size_t bytes, uint64_t offset) const {
  return pread(file_, to, bytes, static_cast<off_t>(offset)) == static_cast<ssize_t>(bytes);
}

std::unique_ptr<const ExrUnpacker> ExrUnpacker::make(const ExrFile& file, const std::string& path,
                                                     const ExrChunks& chunks, size_t part,
                                                     const Imf::ChannelList& channels,
                                                     const std::vector<ExrPlane>& planes) {
  const ExrRawPart& header = chunks.parts[part];
  const bool ours = header.compression == kNone || header.compression == kZips || header.compression == kZip;
  if (!ours || header.subsampled || chunks.offsets[part].empty()) return nullptr;
  auto unpacker = std::make_unique<Unpacker>(file, path, chunks, part);
  size_t words = 0;
  for (auto it = channels.begin(); it != channels.end(); ++it) {
    const bool is_half = it.channel().type == Imf::HALF;
    for (const ExrPlane& plane : planes)
      if (plane.channel == it.name()) unpacker->add({words, is_half, plane.pixels});
    words += is_half ? 1 : 2;
  }
  unpacker->set_words(words);
  return unpacker;
}

}  // namespace ld
