// Pixels that are unpacked here are those that OpenEXR reads.
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfTiledOutputPart.h>
#include <gtest/gtest.h>
#include <half.h>

#include <cmath>
#include <cstring>
#include <mutex>
#include <set>

#include "core/file_io.h"
#include "core/random.h"
#include "frame/exr_reader.h"
#include "frame/frame_file.h"
#include "tests/support/expect_error.h"
#include "tests/support/random_frame.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

constexpr int kLeft = -5, kTop = 11, kPartWidth = 83, kPartHeight = 150;
constexpr size_t kPartPixels = size_t{kPartWidth} * kPartHeight;

/// Half floats of all kinds, in stretches of which some shrink and some do not; no NaN that signals.
std::vector<half> random_halves(uint32_t seed) {
  RandomStream random(seed, RandomPurpose::scene, 0, 0, 0);
  std::vector<half> values(kPartPixels);
  for (size_t i = 0; i < values.size(); ++i) {
    const bool noise = i / (values.size() / 3) == 1;
    auto bits = static_cast<uint16_t>(noise ? random.below(65536) : i / 7 % 40 * 1000);
    if ((bits & 0x7c00) == 0x7c00) bits &= 0xfe00;  // infinity, or NaN
    values[i].setBits(bits);
  }
  return values;
}

struct UnpackCase {
  Imf::Compression compression;
  int tile_width, tile_height;  // 0: lines
  int parts;
};

std::string write_unpack_case(const TemporaryFolder& folder, const UnpackCase& shape) {
  const Imath::Box2i window({kLeft, kTop}, {kLeft + kPartWidth - 1, kTop + kPartHeight - 1});
  std::vector<Imf::Header> headers;
  for (int part = 0; part < shape.parts; ++part) {
    Imf::Header header(window, window);
    header.setName("part" + std::to_string(part));
    header.compression() = shape.compression;
    header.setType(shape.tile_width > 0 ? Imf::TILEDIMAGE : Imf::SCANLINEIMAGE);
    if (shape.tile_width > 0)
      header.setTileDescription(Imf::TileDescription(
          static_cast<unsigned>(shape.tile_width), static_cast<unsigned>(shape.tile_height), Imf::ONE_LEVEL));
    header.channels().insert("A", Imf::Channel(Imf::HALF));
    header.channels().insert("G", Imf::Channel(Imf::FLOAT));
    header.channels().insert("id", Imf::Channel(Imf::UINT));
    header.channels().insert("z", Imf::Channel(Imf::HALF));
    headers.push_back(header);
  }
  std::string path = (folder / "unpack.exr").string();
  Imf::MultiPartOutputFile file(path.c_str(), headers.data(), shape.parts);
  for (int part = 0; part < shape.parts; ++part) {
    const auto seed = static_cast<uint32_t>(part);
    const std::vector<half> a = random_halves(3 * seed), z = random_halves(3 * seed + 1);
    std::vector<float> g(kPartPixels);
    for (size_t i = 0; i < g.size(); ++i)
      g[i] = std::sin(static_cast<float>(i) * 0.7F + static_cast<float>(part));
    std::vector<uint32_t> id(kPartPixels, 77);
    Imf::FrameBuffer buffer;
    buffer.insert("A", Imf::Slice::Make(Imf::HALF, a.data(), window));
    buffer.insert("G", Imf::Slice::Make(Imf::FLOAT, g.data(), window));
    buffer.insert("id", Imf::Slice::Make(Imf::UINT, id.data(), window));
    buffer.insert("z", Imf::Slice::Make(Imf::HALF, z.data(), window));
    if (shape.tile_width > 0) {
      Imf::TiledOutputPart output(file, part);
      output.setFrameBuffer(buffer);
      output.writeTiles(0, output.numXTiles() - 1, 0, output.numYTiles() - 1);
    } else {
      Imf::OutputPart output(file, part);
      output.setFrameBuffer(buffer);
      output.writePixels(kPartHeight);
    }
  }
  return path;
}

bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  for (size_t i = 0; i < a.size(); ++i)
    if (std::memcmp(&a[i], &b[i], sizeof(float)) != 0 && !(std::isnan(a[i]) && std::isnan(b[i])))
      return false;
  return a.size() == b.size();
}

class Unpack : public testing::TestWithParam<UnpackCase> {};

TEST_P(Unpack, GivesWhatOpenExrGives) {
  const TemporaryFolder folder;
  const ExrReader exr(write_unpack_case(folder, GetParam()));
  const std::vector<std::string> names = {"z", "A", "G"};
  std::vector<std::vector<float>> found, expected;
  for (size_t i = 0; i < names.size() * static_cast<size_t>(exr.parts()); ++i) {
    found.emplace_back(kPartPixels, -1.0F);
    expected.emplace_back(kPartPixels, -2.0F);
  }
  std::vector<ExrPartPlanes> wanted;
  for (int part = exr.parts() - 1; part >= 0; --part) {  // in any order
    wanted.push_back({part, {}});
    std::vector<ExrTypedPlane> typed;
    for (size_t c = 0; c < names.size(); ++c) {
      const size_t plane = static_cast<size_t>(part) * names.size() + c;
      wanted.back().planes.push_back({names[c], found[plane].data(), kPartPixels});
      typed.push_back({names[c], Imf::FLOAT, reinterpret_cast<char*>(expected[plane].data()), kPartPixels});
    }
    exr.read_typed(part, typed);
  }
  std::mutex mutex;
  std::set<std::pair<size_t, int>> rows_done;
  exr.read_parts(wanted, 3, [&](size_t index, int first_row, int rows) {
    const std::lock_guard<std::mutex> lock(mutex);
    for (int row = first_row; row < first_row + rows; ++row)
      EXPECT_TRUE(rows_done.insert({index, row}).second) << "row " << row << " twice";
  });
  EXPECT_EQ(rows_done.size(), wanted.size() * kPartHeight);
  for (size_t i = 0; i < found.size(); ++i) EXPECT_TRUE(same_bits(found[i], expected[i])) << "plane " << i;
}

INSTANTIATE_TEST_SUITE_P(
    Parts, Unpack,
    testing::Values(UnpackCase{Imf::NO_COMPRESSION, 0, 0, 1}, UnpackCase{Imf::NO_COMPRESSION, 64, 64, 2},
                    UnpackCase{Imf::ZIPS_COMPRESSION, 0, 0, 3}, UnpackCase{Imf::ZIPS_COMPRESSION, 16, 30, 1},
                    UnpackCase{Imf::ZIP_COMPRESSION, 0, 0, 1}, UnpackCase{Imf::ZIP_COMPRESSION, 0, 0, 2},
                    UnpackCase{Imf::ZIP_COMPRESSION, 64, 64, 3}, UnpackCase{Imf::ZIP_COMPRESSION, 7, 5, 1},
                    UnpackCase{Imf::ZIP_COMPRESSION, 200, 200, 1},
                    UnpackCase{Imf::PIZ_COMPRESSION, 0, 0, 2}));

TEST(FrameFile, NoNumberOfThreadsChangesAFrame) {
  const TemporaryFolder folder;
  Frame written = random_frame(150, 140, 3);
  written.plane(1, 0)[400] = -1;
  written.plane(2, 1)[20999] = std::nanf("");
  written.plane(0, kNormalOffset)[7] = std::nanf("");
  write_frame(folder / "frame.exr", written);
  Faults faults;
  const Frame once = read_frame(folder / "frame.exr", {}, faults);
  EXPECT_EQ(faults.negative, 1);
  EXPECT_EQ(faults.not_finite, 1);
  EXPECT_EQ(faults.guides, 1);
  for (const int threads : {2, 7}) {
    Faults others;
    const Frame frame = read_frame(folder / "frame.exr", {}, others, 0, threads);
    EXPECT_EQ(frame.samples, once.samples);
    EXPECT_EQ(frame.valid, once.valid);
    EXPECT_EQ(others.negative, 1);
    EXPECT_EQ(others.not_finite, 1);
    EXPECT_EQ(others.guides, 1);
  }
}

TEST(DamagedExr, AChunkThatDoesNotUnpackIsAnErrorOnAnyThreads) {
  const TemporaryFolder folder;
  write_frame(folder / "frame.exr", random_frame(150, 140, 3));
  std::string bytes = read_file(folder / "frame.exr");
  for (size_t i = bytes.size() / 2; i < bytes.size() / 2 + 64; ++i) bytes[i] = static_cast<char>(~bytes[i]);
  write_file_atomically(folder / "frame.exr", bytes);
  for (const int threads : {1, 4}) {
    Faults faults;
    EXPECT_ERROR(read_frame(folder / "frame.exr", {}, faults, 0, threads), "frame.exr: part 's001'");
  }
}

}  // namespace
}  // namespace ld
