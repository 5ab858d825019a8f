// Layouts that no fixture has: several samples in a file, windows, pbrt-v4's channels, shared guides.

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMatrixAttribute.h>
#include <ImfOutputFile.h>
#include <gtest/gtest.h>

#include "core/file_io.h"
#include "frame/frame_file.h"
#include "import/frame_import.h"
#include "tests/support/expect_error.h"
#include "tests/support/random_frame.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 4, kHeight = 3;

/// A channel with one value everywhere.
using Channels = std::vector<std::pair<std::string, float>>;

Imf::Header header_of_size(int width = kWidth, int height = kHeight) {
  return {width, height};
}

void write_channels(const fs::path& path, const Channels& channels, Imf::Header header = header_of_size()) {
  std::vector<std::vector<float>> planes;
  Imf::FrameBuffer buffer;
  const Imath::Box2i window = header.dataWindow();
  const auto width = static_cast<size_t>(window.max.x - window.min.x + 1);
  const auto height = static_cast<size_t>(window.max.y - window.min.y + 1);
  planes.reserve(channels.size());
  for (const auto& [name, value] : channels) {
    planes.emplace_back(width * height, value);
    header.channels().insert(name, Imf::Channel(Imf::FLOAT));
    buffer.insert(name, Imf::Slice::Make(Imf::FLOAT, planes.back().data(), window));
  }
  Imf::OutputFile file(path.c_str(), header);
  file.setFrameBuffer(buffer);
  file.writePixels(static_cast<int>(height));
}

ImportMapping mapping_from(const std::string& yaml) {
  const TemporaryFolder folder;
  write_file_atomically(folder / "mapping.yaml", yaml);
  return read_mapping("", folder / "mapping.yaml", {});
}

Frame import_files(const std::vector<fs::path>& files, const ImportMapping& mapping) {
  return import_frame(files, mapping, std::nullopt, false).frame;
}

float value(const Frame& frame, int sample, const std::string& feature, int component = 0) {
  return frame.plane(sample, find_feature(feature).offset + component)[0];
}

// No file that pbrt-v4 wrote was at hand: this is the layout that its documentation and source describe.
Channels pbrt_channels(float red) {
  return {{"R", red},         {"G", 0.5F},         {"B", 0.25F},
          {"Albedo.R", 0.8F}, {"Albedo.G", 1.25F}, {"Albedo.B", 0.4F},
          {"P.X", 1},         {"P.Y", 2},          {"P.Z", 5},
          {"u", 0.5F},        {"v", 0.5F},         {"N.X", 0},
          {"N.Y", 1},         {"N.Z", 0},          {"Ns.X", 0.6F},
          {"Ns.Y", 0},        {"Ns.Z", -0.8F},     {"dzdx", 0},
          {"dzdy", 0},        {"Variance.R", 0},   {"RelativeVariance.R", 0}};
}

TEST(PbrtPreset, CameraSpaceLooksAlongPlusZ) {
  const TemporaryFolder folder;
  write_channels(folder / "a.exr", pbrt_channels(1));
  write_channels(folder / "b.exr", pbrt_channels(2));
  const Frame frame = import_files({folder / "a.exr", folder / "b.exr"}, read_mapping("pbrt", "", {}));
  EXPECT_EQ(frame.features, (std::vector<std::string>{"radiance", "normal", "depth", "albedo"}));
  EXPECT_EQ(value(frame, 1, "radiance"), 2);
  EXPECT_NEAR(value(frame, 0, "normal", 0), 0.6F, 1e-6F);
  EXPECT_NEAR(value(frame, 0, "normal", 2), 0.8F, 1e-6F);
  EXPECT_EQ(value(frame, 0, "depth"), 5);
  EXPECT_EQ(value(frame, 0, "albedo", 1), 1);
  EXPECT_TRUE(frame.alpha.empty());
}

TEST(PbrtPreset, WorldSpaceWithTheFilesOwnCamera) {
  const TemporaryFolder folder;
  const ImportMapping mapping = read_mapping("pbrt", "", {"normal.space=world", "depth.kind=world_position"});
  // The camera stands at (0, 0, 10) and looks along the world's -z: left-handed with +z forward, for row
  // vectors.
  const Imath::M44f rows(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, 10, 1);
  for (const Imath::M44f& matrix : {rows, rows.transposed()}) {
    Imf::Header header = header_of_size();
    header.insert("worldToCamera", Imf::M44fAttribute(matrix));
    write_channels(folder / "a.exr", pbrt_channels(1), header);
    const Frame frame = import_files({folder / "a.exr"}, mapping);
    EXPECT_EQ(value(frame, 0, "depth"), 5);
    EXPECT_NEAR(value(frame, 0, "normal", 0), 0.6F, 1e-6F);
    EXPECT_NEAR(value(frame, 0, "normal", 2), -0.8F, 1e-6F);
  }
}

TEST(ImportFiles, SamplesAsPrefixesOfChannels) {
  const TemporaryFolder folder;
  Channels channels = {{"albedo.R", 0.5F}, {"albedo.G", 0.25F}, {"albedo.B", 0}};
  for (const int sample : {10, 2, 1})
    for (const char* colour : {"R", "G", "B"})
      channels.emplace_back("s" + std::to_string(sample) + "." + colour, static_cast<float>(sample));
  write_channels(folder / "all.exr", channels);
  const std::string radiance = "radiance:\n  channels: [\"s{sample}.R\", \"s{sample}.G\", \"s{sample}.B\"]\n";
  const std::string albedo = "albedo:\n  channels: [albedo.R, albedo.G, albedo.B]\n";
  const ImportedFrame imported = import_frame(
      {folder / "all.exr"}, mapping_from(radiance + albedo + "  per_sample: false\n"), std::nullopt, false);
  ASSERT_EQ(imported.frame.spp, 3);
  EXPECT_EQ(imported.repeated, std::vector<std::string>{"albedo"});
  const float order[] = {1, 2, 10};
  for (int s = 0; s < 3; ++s) {
    EXPECT_EQ(value(imported.frame, s, "radiance"), order[s]);
    EXPECT_EQ(value(imported.frame, s, "albedo"), 0.5F);
  }
  EXPECT_ERROR(import_files({folder / "all.exr"}, mapping_from(radiance + albedo)), "say per_sample: false");
  channels.pop_back();
  write_channels(folder / "all.exr", channels);
  EXPECT_ERROR(import_files({folder / "all.exr"}, mapping_from(radiance)), "no channel");
}

TEST(ImportFiles, SamplesAsPartsAndSharedGuides) {
  const TemporaryFolder folder;
  const Frame frame = random_frame(5, 4, 3);
  write_frame(folder / "ours.exr", frame);  // parts mean, s000, s001, s002
  const ImportMapping mapping = mapping_from(
      "part: \"s{sample}\"\nradiance:\n  channels: [R, G, B]\nroughness:\n  channels: [roughness]\n"
      "lens:\n  channels: [lens.X, lens.Y]\n");
  const Frame read = import_files({folder / "ours.exr"}, mapping);
  ASSERT_EQ(read.spp, 3);
  EXPECT_EQ(read.features, (std::vector<std::string>{"radiance", "roughness", "lens"}));
  for (int s = 0; s < 3; ++s) {
    EXPECT_EQ(value(read, s, "radiance", 2), value(frame, s, "radiance", 2));
    EXPECT_EQ(value(read, s, "lens", 1), value(frame, s, "lens", 1));
  }
  EXPECT_ERROR(import_files({folder / "ours.exr"}, mapping_from("radiance:\n  channels: [R, G, B]\n")),
               "fits the channels 'R' of part 'mean' and 'R' of part 's000'");

  // One file a sample, the guides in the first only.
  write_channels(folder / "a.exr", {{"R", 1}, {"G", 1}, {"B", 1}, {"Z", 7}});
  write_channels(folder / "b.exr", {{"R", 2}, {"G", 1}, {"B", 1}});
  const Frame shared = import_files(
      {folder / "a.exr", folder / "b.exr"},
      mapping_from("radiance:\n  channels: [R, G, B]\ndepth:\n  channels: [Z]\n  per_sample: false\n"));
  EXPECT_EQ(shared.features, (std::vector<std::string>{"radiance", "depth"}));
  EXPECT_EQ(value(shared, 1, "depth"), 7);
  EXPECT_EQ(value(shared, 1, "radiance"), 2);
}

TEST(ImportFiles, WindowsSurviveAndDisplayWindowsMustAgree) {
  const TemporaryFolder folder;
  const Channels grey = {{"R", 1}, {"G", 1}, {"B", 1}, {"A", 0.5F}};
  const Imath::Box2i display({0, 0}, {19, 9});
  write_channels(folder / "a.exr", grey, Imf::Header(display, {{2, 3}, {5, 5}}));
  const ImportMapping mapping = mapping_from("radiance:\n  channels: [R, G, B]\nalpha:\n  channels: [A]\n");
  const Frame frame = import_files({folder / "a.exr"}, mapping);
  EXPECT_EQ(frame.width, 4);
  EXPECT_EQ(frame.alpha, std::vector<float>(12, 0.5F));
  write_frame(folder / "frame.exr", frame);
  const Windows windows = read_frame_header(folder / "frame.exr").info.windows;
  EXPECT_EQ(windows.x, 2);
  EXPECT_EQ(windows.y, 3);
  EXPECT_EQ(windows.display_right, 19);
  EXPECT_EQ(import_picture(folder / "a.exr", mapping).windows, windows);
  write_channels(folder / "b.exr", {{"R", 2}, {"G", 1}, {"B", 1}, {"A", 0.5F}},
                 Imf::Header(Imath::Box2i({0, 0}, {39, 19}), {{2, 3}, {5, 5}}));
  EXPECT_ERROR(import_files({folder / "a.exr", folder / "b.exr"}, mapping), "display window");
}

TEST(ImportFiles, AmbiguityAndHalfAFeature) {
  const TemporaryFolder folder;
  Channels layers;
  for (const char* layer : {"Front", "Back"})
    for (const char* colour : {"R", "G", "B"})
      layers.emplace_back(std::string(layer) + ".Combined." + colour, 1.0F);
  write_channels(folder / "a.exr", layers);
  EXPECT_ERROR(import_files({folder / "a.exr"}, read_mapping("cycles", "", {})), "--set layer=NAME");
  EXPECT_EQ(import_files({folder / "a.exr"}, read_mapping("cycles", "", {"layer=Back"})).spp, 1);
  write_channels(folder / "a.exr", {{"R", 1}, {"G", 1}, {"B", 1}, {"albedo.R", 1}});
  EXPECT_ERROR(import_files({folder / "a.exr"}, read_mapping("mitsuba", "", {})), "nothing fits 'albedo.G'");
}

TEST(ImportFiles, DepthThatNobodyWroteIsLeftOut) {
  const TemporaryFolder folder;
  write_channels(folder / "a.exr",
                 {{"R", 1}, {"G", 1}, {"B", 1}, {"N.X", 0}, {"N.Y", 0}, {"N.Z", 1}, {"Z", 1e10F}});
  const ImportedFrame imported =
      import_frame({folder / "a.exr"},
                   mapping_from("radiance:\n  channels: [R, G, B]\nnormal:\n  channels: [N.X, N.Y, "
                                "N.Z]\ndepth:\n  channels: [Z]\n"),
                   std::nullopt, false);
  EXPECT_EQ(imported.frame.features, (std::vector<std::string>{"radiance", "normal"}));
  ASSERT_EQ(imported.notes.size(), 1u);
  EXPECT_NE(imported.notes[0].find("depth left out"), std::string::npos);
}

}  // namespace
}  // namespace ld
