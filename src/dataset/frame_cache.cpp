#include "dataset/frame_cache.h"

#include <fcntl.h>
#include <fmt/ranges.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>

#include "core/checksum.h"
#include "core/error.h"
#include "core/file_io.h"
#include "core/log.h"
#include "frame/derived_features.h"
#include "weights/safetensors.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

constexpr const char* kFormat = "ld-cache 2";

std::string file_state(const fs::path& path, const std::string& checksum) {
  struct stat status = {};
  if (stat(path.c_str(), &status) != 0) fail("cannot read {}: {}", path.string(), std::strerror(errno));
  return fmt::format("{} bytes, changed {}.{:09}, checksum {}", status.st_size, status.st_mtim.tv_sec,
                     status.st_mtim.tv_nsec, checksum.empty() ? "unknown" : checksum);
}

/// Frames without a companion are what they were before there were any.
std::string half_state(const fs::path& companion) {
  std::error_code ignored;  // what cannot be looked at is not read either
  return fs::exists(companion, ignored) ? "; half " + file_state(companion, "") : "";
}

/// Of all that is not covered by the tiles' checksums.
std::string index_checksum(const PackedFrame& frame) {
  const std::string index = fmt::format(
      "{} x {}, {} spp, depth scale {}, {} {}", frame.width, frame.height, frame.spp, frame.depth_scale,
      checksum(frame.checksums, frame.tiles() * frame.tile_checksums() * sizeof(int64_t)),
      checksum(frame.difficulty, frame.tiles() * sizeof(float)));
  return checksum_text(index.data(), index.size());
}

std::vector<TensorView> tensors_of(const PackedFrame& frame) {
  const auto tiles = static_cast<int64_t>(frame.tiles());
  const int64_t spp = frame.spp, side = kTileSide;
  const auto view = [](const char* name, DType type, std::vector<int64_t> shape, const void* data) {
    size_t bytes = dtype_bytes(type);
    for (const int64_t size : shape) bytes *= static_cast<size_t>(size);
    return TensorView{name, type, std::move(shape), data, bytes};
  };
  return {view("checksums", DType::i64, {tiles, 2 * spp + 1}, frame.checksums),
          view("difficulty", DType::f32, {tiles}, frame.difficulty),
          view("reference", DType::f32, {tiles, 3, side, side}, frame.reference),
          view("samples", DType::f16, {tiles, spp, frame.channels(), side, side}, frame.samples),
          view("valid", DType::u8, {tiles, spp, side, side}, frame.valid)};
}

int whole_number(const SafetensorsFile& file, const std::string& key, int high) {
  const std::string& text = file.metadata_value(key);
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < 1 || value > high)
    fail("{}: \"{}\" is \"{}\"; expected a number from 1 to {}", file.path().string(), key, text, high);
  return value;
}

/// The frame that the file holds; its header is checked before anything is used.
PackedFrame view_of(const std::shared_ptr<const SafetensorsFile>& file,
                    const std::vector<std::string>& features) {
  PackedFrame frame;
  frame.width = whole_number(*file, "width", 1 << 14);
  frame.height = whole_number(*file, "height", 1 << 14);
  frame.spp = whole_number(*file, "spp", 1 << 12);
  frame.features = features;
  const std::string& scale = file->metadata_value("depth_scale");
  const auto [end, error] = std::from_chars(scale.data(), scale.data() + scale.size(), frame.depth_scale);
  if (error != std::errc() || end != scale.data() + scale.size() || !(frame.depth_scale > 0))
    fail("{}: \"depth_scale\" is \"{}\"; expected a number above 0", file->path().string(), scale);
  for (const TensorView& expected : tensors_of(frame)) {
    const TensorView& found = file->tensor(expected.name);
    if (found.type != expected.type || found.shape != expected.shape)
      fail("{}: tensor \"{}\" has the shape [{}]; expected [{}]", file->path().string(), found.name,
           fmt::join(found.shape, ", "), fmt::join(expected.shape, ", "));
  }
  const auto data = [&](const char* name) { return file->tensor(name).data; };
  frame.samples = static_cast<const uint16_t*>(data("samples"));
  frame.valid = static_cast<const uint8_t*>(data("valid"));
  frame.reference = static_cast<const float*>(data("reference"));
  frame.difficulty = static_cast<const float*>(data("difficulty"));
  frame.checksums = static_cast<const int64_t*>(data("checksums"));
  if (index_checksum(frame) != file->metadata_value("index_checksum"))
    fail("{}: the index does not match its checksum", file->path().string());
  frame.memory = file;
  return frame;
}

/// madvise() on the pages that [data, data + bytes) lies in. It is advice: when the system does not take it,
/// reading is slower and nothing else.
void advise(const void* data, size_t bytes, int advice) {
  const auto page = static_cast<uintptr_t>(sysconf(_SC_PAGESIZE));
  const size_t offset = reinterpret_cast<uintptr_t>(data) % page;  // of the data in its first page
  madvise(const_cast<char*>(static_cast<const char*>(data)) - offset, offset + bytes, advice);
}

/// Reads the first page of a file, which holds the header, alone: a mapping's first page fault would start a
/// read-ahead, of 8 MB on some systems.
void read_head(const fs::path& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return;  // opening it again says why
  posix_fadvise(descriptor, 0, 0, POSIX_FADV_RANDOM);
  std::array<char, 4096> head;
  [[maybe_unused]] const ssize_t bytes = read(descriptor, head.data(), head.size());
  close(descriptor);
}

}  // namespace

std::string source_state(const fs::path& data_set, const ManifestFrame& frame) {
  return file_state(frame_path(data_set, frame.name), frame.checksum) + "; reference " +
         (frame.has_reference ? file_state(reference_path(data_set, frame.name), frame.reference_checksum)
                              : "none") +
         half_state(half_companion(frame_path(data_set, frame.name)));
}

FrameCache::FrameCache(const fs::path& folder, const std::vector<std::string>& features, uint64_t reserve)
    : features_(packed_features(features)), reserve_(reserve) {
  const std::string key =
      fmt::format("{}; schema {}; {}", kFormat, kSchemaVersion, fmt::join(features_, " "));
  folder_ = folder / checksum_text(key.data(), key.size());
}

fs::path FrameCache::path(const std::string& name) const {
  return folder_ / (name + ".safetensors");
}

std::optional<PackedFrame> FrameCache::open(const std::string& name, const std::string& source) const {
  const fs::path file_path = path(name);
  std::error_code ignored;  // what cannot be looked at counts as missing
  if (!fs::is_regular_file(file_path, ignored)) return std::nullopt;
  try {
    read_head(file_path);
    const auto file = std::make_shared<const SafetensorsFile>(file_path);
    for (const TensorView& tensor : file->tensors()) advise(tensor.data, tensor.bytes, MADV_RANDOM);
    if (file->metadata_value("source") != source) {
      spdlog::info("{} has changed since it was cached; it is read again", name);
      return std::nullopt;
    }
    return view_of(file, features_);
  } catch (const Error& error) {
    spdlog::warn("damaged cache file, made again: {}", error.what());
    return std::nullopt;
  }
}

bool FrameCache::write(const std::string& name, const std::string& source, const PackedFrame& frame) {
  if (!writable_) return false;
  try {
    make_folder(path(name).parent_path());
    const uint64_t available = fs::space(folder_).available;
    if (available < reserve_ + frame.bytes())
      fail("{} MB are free below {}, too few for {} MB more and a reserve of {} MB", available >> 20,
           folder_.string(), frame.bytes() >> 20, reserve_ >> 20);
    write_safetensors(path(name), tensors_of(frame),
                      {{"format", kFormat},
                       {"features", fmt::format("{}", fmt::join(frame.features, " "))},
                       {"source", source},
                       {"width", std::to_string(frame.width)},
                       {"height", std::to_string(frame.height)},
                       {"spp", std::to_string(frame.spp)},
                       {"depth_scale", fmt::format("{}", frame.depth_scale)},
                       {"index_checksum", index_checksum(frame)}});
    return true;
  } catch (const std::exception& error) {
    if (writable_.exchange(false))
      spdlog::warn(
          "frames are not cached from here on, which makes training slower: {}; free some space or set "
          "data.cache to a folder that can be written",
          error.what());
    return false;
  }
}

void read_ahead(const PackedFrame& frame, const TileRange& range, const SampleList& samples) {
  constexpr size_t kChunk = size_t{128}
                            << 10;  // Linux ignores what goes beyond a disk's read-ahead in one call
  const auto read_tiles = [&](const void* tensor, size_t first, size_t tiles, size_t tile_bytes) {
    const char* data = static_cast<const char*>(tensor) + first * tile_bytes;
    for (size_t at = 0; at < tiles * tile_bytes; at += kChunk)
      advise(data + at, std::min(kChunk, tiles * tile_bytes - at), MADV_WILLNEED);
  };
  const auto columns = static_cast<size_t>(range.x1 - range.x0), spp = static_cast<size_t>(frame.spp);
  const SampleList list = frame.chosen(samples);
  const size_t sample_bytes = sizeof(uint16_t) * frame.tile_samples() / spp;
  for (int y = range.y0; y < range.y1; ++y) {
    const auto first =
        static_cast<size_t>(y) * static_cast<size_t>(frame.tiles_x()) + static_cast<size_t>(range.x0);
    if (list.size() == spp)
      read_tiles(frame.samples, first, columns, spp * sample_bytes);
    else
      for (size_t tile = first; tile < first + columns; ++tile)
        for (const int s : list)
          read_tiles(frame.samples, tile * spp + static_cast<size_t>(s), 1, sample_bytes);
    // The masks of a tile lie on the same page or two.
    read_tiles(frame.valid, first, columns, frame.tile_valid());
    read_tiles(frame.reference, first, columns, sizeof(float) * PackedFrame::kTileReference);
  }
}

}  // namespace ld
