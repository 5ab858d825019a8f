// Files that are damaged, hostile or from elsewhere: each is read right or gives one clear Error.
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIntAttribute.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfStringAttribute.h>
#include <ImfStringVectorAttribute.h>
#include <ImfTiledOutputFile.h>
#include <gtest/gtest.h>
#include <half.h>

#include <cstring>
#include <fstream>

#include "core/file_io.h"
#include "frame/frame_file.h"
#include "tests/support/expect_error.h"
#include "tests/support/random_frame.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

Frame read_required(const fs::path& path, const std::vector<std::string>& required = {}) {
  Faults faults;
  return read_frame(path, required, faults);
}

/// A file as another renderer might write it: scan lines, float.
struct ForeignPart {
  std::string name;
  std::vector<std::string> channels;
  int width = 3, height = 2;
  Imf::PixelType type = Imf::FLOAT;
  int left = 0;
};

void write_foreign(const fs::path& path, const std::vector<ForeignPart>& parts, int said_spp = -1) {
  std::vector<Imf::Header> headers;
  for (const ForeignPart& part : parts) {
    const Imath::Box2i window({part.left, 5}, {part.left + part.width - 1, 5 + part.height - 1});
    Imf::Header header(Imath::Box2i({0, 0}, {99, 99}), window);
    header.setName(part.name);
    header.setType(Imf::SCANLINEIMAGE);
    header.compression() = Imf::PIZ_COMPRESSION;
    for (const std::string& channel : part.channels)
      header.channels().insert(channel, Imf::Channel(part.type));
    headers.push_back(header);
  }
  if (said_spp >= 0) headers[0].insert("ldSpp", Imf::IntAttribute(said_spp));
  Imf::MultiPartOutputFile file(path.c_str(), headers.data(), static_cast<int>(headers.size()));
  for (size_t i = 0; i < parts.size(); ++i) {
    const auto pixels = static_cast<size_t>(parts[i].width * parts[i].height);
    std::vector<std::vector<float>> planes;
    Imf::FrameBuffer buffer;
    for (size_t c = 0; c < parts[i].channels.size(); ++c) {
      planes.emplace_back(pixels);
      for (size_t p = 0; p < pixels; ++p)
        planes.back()[p] = static_cast<float>(100 * i + 10 * c) + static_cast<float>(p) + 1.0F;
    }
    for (size_t c = 0; c < parts[i].channels.size(); ++c)
      buffer.insert(parts[i].channels[c],
                    Imf::Slice::Make(parts[i].type, planes[c].data(), headers[i].dataWindow()));
    Imf::OutputPart part(file, static_cast<int>(i));
    part.setFrameBuffer(buffer);
    part.writePixels(parts[i].height);
  }
}

TEST(ForeignExr, ScanLinesFloatsAnyOrderAndExtraParts) {
  const TemporaryFolder folder;
  const fs::path path = folder / "foreign.exr";
  // Parts out of order, channels out of order, an unrelated part, a data window that starts elsewhere.
  write_foreign(path, {{"beauty", {"R", "G", "B"}},
                       {"s001", {"Z", "B", "G", "R"}, 3, 2, Imf::FLOAT, 7},
                       {"s000", {"R", "G", "B", "Z", "id"}, 3, 2, Imf::FLOAT, 7}});
  const FrameHeader header = read_frame_header(path);
  EXPECT_EQ(header.spp, 2);
  EXPECT_EQ(header.features, (std::vector<std::string>{"radiance", "depth"}));
  const Frame frame = read_required(path, {"depth"});
  ASSERT_EQ(frame.width, 3);
  ASSERT_EQ(frame.height, 2);
  EXPECT_EQ(frame.plane(0, 0)[0], 201.0F);  // part 2, channel 0
  EXPECT_EQ(frame.plane(0, kDepthOffset)[5], 236.0F);
  EXPECT_EQ(frame.plane(1, 0)[0], 131.0F);  // part 1, channel 3
  EXPECT_EQ(frame.plane(1, kDepthOffset)[5], 106.0F);
  EXPECT_EQ(frame.plane(1, kNormalOffset)[5], 0.0F);
  EXPECT_EQ(frame.info.depth_scale, median_depth(frame));
  EXPECT_GT(frame.info.depth_scale, 100.0F);
}

class Compressions : public testing::TestWithParam<int> {};

/// Black is what compresses best: the limits on how small a file may be must let it pass, in one tile, many
/// or none.
TEST_P(Compressions, ABlackPictureIsNotTakenForALie) {
  const TemporaryFolder folder;
  constexpr int kWidth = 700, kHeight = 300;
  const std::vector<half> zeros(size_t{kWidth} * kHeight);
  for (const unsigned tile : {0U, 64U, 1024U}) {
    for (const Imf::LevelMode mode : {Imf::ONE_LEVEL, Imf::MIPMAP_LEVELS}) {
      if (tile == 0 && mode != Imf::ONE_LEVEL) continue;
      Imf::Header header(kWidth, kHeight);
      header.compression() = static_cast<Imf::Compression>(GetParam());
      Imf::FrameBuffer buffer;
      for (const char* channel : {"R", "G", "B"}) {
        header.channels().insert(channel, Imf::Channel(Imf::HALF));
        buffer.insert(channel, Imf::Slice::Make(Imf::HALF, zeros.data(), header.dataWindow()));
      }
      const std::string path = (folder / "black.exr").string();
      if (tile == 0) {
        Imf::OutputFile file(path.c_str(), header);
        file.setFrameBuffer(buffer);
        file.writePixels(kHeight);
      } else {
        header.setTileDescription(Imf::TileDescription(tile, tile, mode));
        Imf::TiledOutputFile file(path.c_str(), header);
        file.setFrameBuffer(buffer);
        for (int level = 0; level < file.numLevels(); ++level)
          file.writeTiles(0, file.numXTiles(level) - 1, 0, file.numYTiles(level) - 1, level);
      }
      SCOPED_TRACE(fmt::format("tile {}, level mode {}", tile, static_cast<int>(mode)));
      const Image image = read_image(path);
      EXPECT_EQ(image.width, kWidth);
      EXPECT_EQ(image.height, kHeight);
      EXPECT_EQ(image.at(2, kWidth - 1, kHeight - 1), 0.0F);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, Compressions,
                         testing::Range(0, static_cast<int>(Imf::NUM_COMPRESSION_METHODS)));

TEST(ForeignExr, ComplainsOfWhatIsMissingByName) {
  const TemporaryFolder folder;
  const fs::path path = folder / "foreign.exr";
  write_foreign(path, {{"s000", {"R", "G", "B", "Z"}}, {"s001", {"R", "G", "B"}}});
  EXPECT_ERROR(read_required(path, {"depth"}),
               "part 's001': no channel 'Z'; found B, G, R; the feature 'depth' is needed");
  EXPECT_EQ(read_required(path).spp, 2);
  EXPECT_ERROR(read_required(path, {"albdo"}), "did you mean 'albedo'?");
  write_foreign(path, {{"s000", {"R", "G"}}});
  EXPECT_ERROR(read_required(path), "part 's000': no channel 'B'");
  write_foreign(path, {{"mean", {"R", "G", "B"}}});
  EXPECT_EQ(read_frame_header(path).spp, 0);
  EXPECT_ERROR(read_required(path), "give them all with --preset or --mapping");
  write_foreign(path, {{"s000", {"R", "G", "B"}}, {"s002", {"R", "G", "B"}}});
  EXPECT_ERROR(read_required(path), "no part 's001', but 's002'");
  write_foreign(path, {{"s000", {"R", "G", "B"}}, {"s001", {"R", "G", "B"}, 4}});
  EXPECT_ERROR(read_required(path), "part 's001' is 4 x 2 and part 's000' 3 x 2");
  write_foreign(path, {{"s000", {"R", "G", "B"}, 3, 2, Imf::UINT}});
  EXPECT_ERROR(read_required(path), "channel 'R' holds integers");
  write_foreign(path, {{"s000", {"R", "G", "B"}}, {"s001", {"R", "G", "B"}}}, 8);
  EXPECT_ERROR(read_required(path), "ldSpp says 8 samples a pixel, but 2");
}

TEST(ForeignExr, RefusesNewerSchemasAndIllTypedAttributes) {
  const TemporaryFolder folder;
  const fs::path path = folder / "image.exr";
  const auto write = [&](const std::string& name, const Imf::Attribute& attribute) {
    Imf::Header header(1, 1);
    for (const char* channel : {"R", "G", "B"}) header.channels().insert(channel, Imf::Channel(Imf::HALF));
    header.insert(name, attribute);
    Imf::OutputFile file(path.c_str(), header);
    file.setFrameBuffer(Imf::FrameBuffer());
    file.writePixels(1);
  };
  write("ldSchemaVersion", Imf::IntAttribute(kSchemaVersion + 1));
  EXPECT_ERROR(read_frame_header(path), "use a newer version");
  write("ldSeed", Imf::StringAttribute("twelve"));
  EXPECT_ERROR(read_frame_header(path), "the attribute 'ldSeed' is 'twelve'");
  write("ldDepthScale", Imf::StringAttribute("far"));
  EXPECT_ERROR(read_frame_header(path), "'ldDepthScale'");
  write("ldSeed", Imf::IntAttribute(12));
  EXPECT_EQ(read_frame_header(path).info.seed, 12u);
}

TEST(DamagedExr, NoFileAFolderOrAnotherKindOfFile) {
  const TemporaryFolder folder;
  EXPECT_ERROR(read_required(folder / "none.exr"), "no such file");
  EXPECT_ERROR(read_required(folder.path()), "is a folder");
  write_file_atomically(folder / "text.exr", "This is not a picture but a letter.\n");
  EXPECT_ERROR(read_required(folder / "text.exr"), "not an OpenEXR file");
  write_file_atomically(folder / "empty.exr", "");
  EXPECT_ERROR(read_required(folder / "empty.exr"), "not an OpenEXR file");
}

TEST(DamagedExr, CutShortAtEveryPlaceIsAnError) {
  const TemporaryFolder folder;
  write_frame(folder / "frame.exr", random_frame(3, 2, 1));
  write_image(folder / "image.exr", Image(3, 2, 3));
  for (const char* name : {"frame.exr", "image.exr"}) {
    const std::string bytes = read_file(folder / name);
    for (size_t length = 0; length < bytes.size(); ++length) {
      // A plain write: flushing 2000 files to disk would take the test's time.
      std::ofstream(folder / "cut.exr", std::ios::binary) << bytes.substr(0, length);
      const std::string text = error_text([&] { read_frame_header(folder / "cut.exr"); });
      EXPECT_NE(text.find("cut.exr"), std::string::npos) << length << ": " << text;
      if (HasFailure()) return;
    }
  }
}

/// Puts `value` behind the header of the first attribute `name`, at `skip` bytes.
void overwrite(std::string& bytes, const std::string& name, const std::string& type, size_t skip,
               int32_t value) {
  const std::string key = name + '\0' + type + '\0';
  const size_t at = bytes.find(key);
  ASSERT_NE(at, std::string::npos);
  std::memcpy(bytes.data() + at + key.size() + 4 + skip, &value, 4);
}

TEST(DamagedExr, LyingHeadersAllocateNothing) {
  const TemporaryFolder folder;
  write_image(folder / "image.exr", Image(3, 2, 3));
  const std::string image = read_file(folder / "image.exr");
  ASSERT_LT(image.size(), 500u);
  const auto read_changed = [&](const std::string& name, const std::string& type, size_t skip,
                                int32_t value) {
    std::string bytes = image;
    overwrite(bytes, name, type, skip, value);
    write_file_atomically(folder / "lie.exr", bytes);
    read_image(folder / "lie.exr");
  };
  EXPECT_ERROR(read_changed("dataWindow", "box2i", 8, 1 << 30), "the data window is 1073741825 x 2");
  EXPECT_ERROR(read_changed("dataWindow", "box2i", 8, -5), "the data window is -4 x 2");
  EXPECT_ERROR(read_changed("dataWindow", "box2i", 0, INT32_MIN), "data window");
  EXPECT_ERROR(read_changed("dataWindow", "box2i", 8, 3), "chunk 0 does not hold the 48 bytes");
  EXPECT_ERROR(read_changed("dataWindow", "box2i", 8, 1), "chunk 0 does not hold the 24 bytes");
  EXPECT_ERROR(read_changed("dataWindow", "box2i", 12, 2), "chunk 0 does not hold the 54 bytes");
  EXPECT_ERROR(read_changed("dataWindow", "box2i", 8, 16000), "chunk 0 does not hold");
  EXPECT_ERROR(read_changed("dataWindow", "box2i", 12, 16000), "cannot be in a file of");
  EXPECT_ERROR(read_changed("channels", "chlist", 2, 7), "channel 'B' has pixel type 7");
  EXPECT_ERROR(read_changed("channels", "chlist", 10, 0), "sampling 0 x 1");
  EXPECT_ERROR(read_changed("compression", "compression", -4, INT32_MAX), "cut short");
}

TEST(DamagedExr, AStringOfAListThatClaimsTwoGigabytesAllocatesNothing) {
  const TemporaryFolder folder;
  Imf::Header header(1, 1);
  header.channels().insert("R", Imf::Channel(Imf::HALF));
  header.insert("views", Imf::StringVectorAttribute({"left", "right"}));
  { Imf::OutputFile file((folder / "image.exr").c_str(), header); }
  std::string bytes = read_file(folder / "image.exr");
  overwrite(bytes, "views", "stringvector", 0, INT32_MAX);
  write_file_atomically(folder / "lie.exr", bytes);
  EXPECT_ERROR(read_image(folder / "lie.exr"), "the attribute 'views' is of type 'stringvector'");
}

TEST(DamagedExr, DeepDataIsRefused) {
  const TemporaryFolder folder;
  write_image(folder / "image.exr", Image(3, 2, 3));
  std::string bytes = read_file(folder / "image.exr");
  bytes[5] = static_cast<char>(bytes[5] | 0x08);
  write_file_atomically(folder / "deep.exr", bytes);
  EXPECT_ERROR(read_image(folder / "deep.exr"), "holds deep data");
}

}  // namespace
}  // namespace ld
