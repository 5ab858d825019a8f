#include "frame/exr_reader.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfInputPart.h>
#include <ImfPartType.h>
#include <ImfTiledInputPart.h>

#include <utility>

#include "core/error.h"
#include "core/threads.h"
#include "frame/exr_unpack.h"
#include "frame/schema.h"

namespace ld {

ExrReader::ExrReader(const std::filesystem::path& path) : path_(path.string()) {
  chunks_ = check_exr_file(path);
  try {
    // No rebuilding of chunk tables: an incomplete file is an error here, not something to make the best of.
    file_ = std::make_unique<Imf::MultiPartInputFile>(path_.c_str(), 0, false);
    for (int part = 0; part < parts(); ++part)
      if (!file_->partComplete(part))
        fail("{}: incomplete; the renderer was stopped; render it again", where(part));
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    fail("{}: OpenEXR cannot open it: {}; copy or render it again", path_, error.what());
  }
  check_pixels();
}

void ExrReader::check_pixels() const {
  // Of the memory that a frame takes: less is no harm, and rendered pictures never shrink a hundred times.
  constexpr uint64_t kHarmless = uint64_t{32} << 20, kBestRatio = 100;
  uint64_t memory = 0;
  for (int part = 0; part < parts(); ++part)
    memory += uint64_t{kSampleChannels} * sizeof(float) * static_cast<uint64_t>(width(part)) *
              static_cast<uint64_t>(height(part));
  if (memory <= kHarmless || memory / kBestRatio < std::filesystem::file_size(path_)) return;
  for (int part = 0; part < parts(); ++part) {
    std::vector<float> row(static_cast<size_t>(width(part)));
    const Imf::ChannelList& channels = header(part).channels();
    std::vector<ExrTypedPlane> planes;
    for (auto it = channels.begin(); it != channels.end(); ++it)
      if (it.channel().type != Imf::UINT && it.channel().xSampling == 1 && it.channel().ySampling == 1)
        planes.push_back({it.name(), Imf::FLOAT, reinterpret_cast<char*>(row.data()), row.size()});
    if (!planes.empty()) read_rows(part, planes, Rows::same);
  }
}

std::string ExrReader::part_name(int part) const {
  return header(part).hasName() ? header(part).name() : "";
}

std::string ExrReader::where(int part) const {
  const std::string name = part_name(part);
  return name.empty() ? path_ : fmt::format("{}: part '{}'", path_, name);
}

int ExrReader::width(int part) const {
  const Imath::Box2i& window = header(part).dataWindow();
  return window.max.x - window.min.x + 1;
}

int ExrReader::height(int part) const {
  const Imath::Box2i& window = header(part).dataWindow();
  return window.max.y - window.min.y + 1;
}

bool ExrReader::has_channel(int part, const std::string& channel) const {
  return header(part).channels().findChannel(channel) != nullptr;
}

std::string ExrReader::channel_list(int part) const {
  std::string list;
  const Imf::ChannelList& channels = header(part).channels();
  for (auto it = channels.begin(); it != channels.end(); ++it)
    list += (list.empty() ? "" : ", ") + std::string(it.name());
  return list.empty() ? "none" : list;
}

void ExrReader::require_channel(int part, const std::string& channel, const std::string& advice) const {
  const Imf::Channel* found = header(part).channels().findChannel(channel);
  if (found == nullptr)
    fail("{}: no channel '{}'; found {}; {}", where(part), channel, channel_list(part), advice);
  if (found->type != Imf::HALF && found->type != Imf::FLOAT)
    fail("{}: channel '{}' holds integers; expected half or float; write it as half", where(part), channel);
  if (found->xSampling != 1 || found->ySampling != 1)
    fail("{}: channel '{}' is subsampled by {} x {}; expected every pixel; write it without subsampling",
         where(part), channel, found->xSampling, found->ySampling);
}

void ExrReader::read(int part, const std::vector<ExrPlane>& planes) const {
  read_parts({{part, planes}}, 1);
}

void ExrReader::read_parts(const std::vector<ExrPartPlanes>& parts, int threads, const RowsDone& done) const {
  const ExrFile file(path_);
  std::vector<std::unique_ptr<const ExrUnpacker>> unpackers;
  std::vector<std::pair<size_t, int>> bands;  // index of `parts`, band
  std::vector<size_t> others;
  for (size_t i = 0; i < parts.size(); ++i) {
    const auto& [part, planes] = parts[i];
    const size_t pixels = static_cast<size_t>(width(part)) * static_cast<size_t>(height(part));
    for (const ExrPlane& plane : planes) require_room(part, plane.channel, plane.count, pixels);
    unpackers.push_back(
        ExrUnpacker::make(file, path_, chunks_, static_cast<size_t>(part), header(part).channels(), planes));
    if (!unpackers[i]) others.push_back(i);
    for (int band = 0; unpackers[i] && band < unpackers[i]->bands(); ++band) bands.emplace_back(i, band);
  }
  parallel_for(static_cast<int64_t>(bands.size()), threads, [&](int64_t job) {
    const auto [i, band] = bands[static_cast<size_t>(job)];
    const auto [first_row, rows] = unpackers[i]->read(band);
    if (done) done(i, first_row, rows);
  });
  for (const size_t i : others) {
    read_with_openexr(parts[i].part, parts[i].planes);
    if (done) done(i, 0, height(parts[i].part));
  }
}

void ExrReader::read_with_openexr(int part, const std::vector<ExrPlane>& planes) const {
  std::vector<ExrTypedPlane> typed;
  for (const ExrPlane& plane : planes)
    typed.push_back({plane.channel, Imf::FLOAT, reinterpret_cast<char*>(plane.pixels), plane.count});
  read_rows(part, typed, Rows::follow);
}

void ExrReader::read_typed(int part, const std::vector<ExrTypedPlane>& planes) const {
  read_rows(part, planes, Rows::follow);
}

void ExrReader::require_room(int part, const std::string& channel, size_t count, size_t needed) const {
  if (count != needed)
    fail(
        "{}: channel '{}' has {} x {} pixels, but there is room for {}; expected the same data window in "
        "all parts",
        where(part), channel, width(part), height(part), count);
}

void ExrReader::read_rows(int part, const std::vector<ExrTypedPlane>& planes, Rows rows) const {
  const Imath::Box2i& window = header(part).dataWindow();
  const size_t needed =
      static_cast<size_t>(width(part)) * (rows == Rows::same ? 1 : static_cast<size_t>(height(part)));
  for (const ExrTypedPlane& plane : planes) require_room(part, plane.channel, plane.count, needed);
  try {
    Imf::FrameBuffer buffer;
    for (const ExrTypedPlane& plane : planes) {
      const size_t pixel_bytes = plane.type == Imf::HALF ? 2 : 4;
      const size_t row_bytes = rows == Rows::same ? 0 : pixel_bytes * static_cast<size_t>(width(part));
      // Not Slice::Make(), which takes a stride of 0 for one that it should compute.
      char* origin = plane.pixels - static_cast<std::ptrdiff_t>(pixel_bytes) * window.min.x -
                     static_cast<std::ptrdiff_t>(row_bytes) * window.min.y;
      buffer.insert(plane.channel, Imf::Slice(plane.type, origin, pixel_bytes, row_bytes));
    }
    if (header(part).type() == Imf::TILEDIMAGE) {
      Imf::TiledInputPart input(*file_, part);
      input.setFrameBuffer(buffer);
      input.readTiles(0, input.numXTiles() - 1, 0, input.numYTiles() - 1);
    } else {
      Imf::InputPart input(*file_, part);
      input.setFrameBuffer(buffer);
      input.readPixels(window.min.y, window.max.y);
    }
  } catch (const std::exception& error) {
    fail("{}: OpenEXR cannot read its pixels: {}; the file is damaged; copy or render it again", where(part),
         error.what());
  }
}

}  // namespace ld
