#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <thread>

#include "core/file_io.h"
#include "frame/frame_file.h"
#include "frame/frame_pair.h"
#include "import/frame_import.h"
#include "import/hdf5_file.h"
#include "import/hdf5_handle.h"
#include "import/hdf5_layout.h"
#include "tests/support/expect_error.h"
#include "tests/support/exr_parts.h"
#include "tests/support/filter_guides.h"
#include "tests/support/random_frame.h"
#include "tests/support/run_program.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

ImportedPicture grey_reference(int width, int height) {
  ImportedPicture reference{Image(width, height, 3), {}};
  std::fill(reference.image.pixels.begin(), reference.image.pixels.end(), 0.5F);
  return reference;
}

Frame sample_frame(uint32_t seed) {
  Frame frame = random_frame(8, 6, 2, seed);
  frame.plane(0, kDepthOffset)[3] = kEscapedDepth;
  for (int c = 0; c < 3; ++c) frame.plane(0, kNormalOffset + c)[3] = 0;
  frame.info.depth_scale = 4;
  return frame;
}

/// Writes a data set of two frames as HDF5.
void write_pair(const TemporaryFolder& folder,
                const std::vector<std::string>& features = mh20_feature_names()) {
  for (uint32_t i = 0; i < 2; ++i) {
    Frame frame = sample_frame(i + 1);
    frame.features = features;
    if (i == 1) frame.valid_plane(1)[5] = 0;
    add_to_data_set({folder / "data", "frame_" + std::to_string(i), "train"}, frame, grey_reference(8, 6));
  }
  const Hdf5Report report =
      data_set_to_hdf5(folder / "data", "train", folder / "samples.h5", folder / "references.h5");
  EXPECT_EQ(report.frames, 2);
}

Hdf5Report read_pair(const TemporaryFolder& folder, const std::string& into,
                     Hdf5Depth depth = Hdf5Depth::linear) {
  return data_set_from_hdf5(folder / "samples.h5", folder / "references.h5", folder / into, "f", "test",
                            depth);
}

FramePair read_back(const fs::path& data, size_t index) {
  return read_frame_pair(data, read_manifest(data).frames[index], {"radiance"});
}

TEST(Hdf5, ADataSetSurvives) {
  const TemporaryFolder folder;
  write_pair(folder);
  EXPECT_TRUE(read_pair(folder, "back").left_out.empty());
  ASSERT_EQ(frames_of_split(folder / "back", "test").size(), 2u);
  for (size_t i = 0; i < 2; ++i) {
    const FramePair before = read_back(folder / "data", i), after = read_back(folder / "back", i);
    EXPECT_EQ(after.frame.features, before.frame.features);
    EXPECT_EQ(after.frame.valid, before.frame.valid);
    EXPECT_EQ(after.frame.info.depth_scale, 4);
    EXPECT_EQ(after.reference.image.pixels, before.reference.image.pixels);
    for (int s = 0; s < 2; ++s)
      for (int c = 0; c < kSampleChannels; ++c)
        for (size_t p = 0; p < 48; ++p) {
          const float expected = before.frame.plane(s, c)[p];
          if (c == kDepthOffset)
            EXPECT_EQ(after.frame.plane(s, c)[p], expected) << "pixel " << p;
          else  // motion goes through another unit in half floats
            EXPECT_NEAR(after.frame.plane(s, c)[p], expected, 1e-3F) << "channel " << c << " pixel " << p;
        }
  }
  data_set_to_hdf5(folder / "data", "train", folder / "again.h5", folder / "references.h5");
  EXPECT_EQ(read_file(folder / "again.h5"), read_file(folder / "samples.h5"));
}

TEST(Hdf5, WhatFiltersReadSurvives) {
  const TemporaryFolder folder;
  for (uint32_t i = 0; i < 2; ++i) {
    Frame frame = frame_with_filter_guides(8, 6, 2, i + 1);
    frame.plane(0, kIdOffset)[7] = kMostId - 1;
    frame.info.cut = i == 1;
    add_to_data_set({folder / "data", "frame_" + std::to_string(i), "train"}, frame, grey_reference(8, 6));
  }
  const Hdf5Report report =
      data_set_to_hdf5(folder / "data", "train", folder / "samples.h5", folder / "references.h5");
  EXPECT_TRUE(report.left_out.empty());
  EXPECT_TRUE(read_pair(folder, "back").left_out.empty());
  for (size_t i = 0; i < 2; ++i) {
    const Frame before = read_back(folder / "data", i).frame, after = read_back(folder / "back", i).frame;
    // What follows from what lies beside a frame is no part of it.
    for (const std::string& name : before.features)
      EXPECT_EQ(after.holds(name), name != "half_radiance" && name != "position") << name;
    for (int c = kFlowOffset; c < kAllChannels; ++c)
      for (size_t p = 0; p < before.plane_size(); ++p)
        EXPECT_EQ(after.plane(1, c)[p], before.plane(1, c)[p]) << "channel " << c;
    EXPECT_EQ(after.plane(0, kIdOffset)[7], kMostId - 1);
    EXPECT_EQ(after.info.world_to_camera, before.info.world_to_camera);
    EXPECT_EQ(after.info.world_to_ndc, before.info.world_to_ndc);
    EXPECT_EQ(after.info.cut, i == 1);
  }
}

TEST(Hdf5, WhatSomeFramesLackIsLeftOut) {
  const TemporaryFolder folder;
  for (uint32_t i = 0; i < 2; ++i) {
    Frame frame = frame_with_filter_guides(8, 6, 2, i + 1);
    if (i == 1) frame.features.erase(std::find(frame.features.begin(), frame.features.end(), "id"));
    add_to_data_set({folder / "data", "frame_" + std::to_string(i), "train"}, frame, grey_reference(8, 6));
  }
  const Hdf5Report report =
      data_set_to_hdf5(folder / "data", "train", folder / "samples.h5", folder / "references.h5");
  EXPECT_EQ(report.left_out, std::vector<std::string>{"id"});
  read_pair(folder, "back");
  EXPECT_FALSE(read_back(folder / "back", 0).frame.holds("id"));
  EXPECT_TRUE(read_back(folder / "back", 0).frame.holds("direct"));
}

TEST(Hdf5, HoldsThePublishedLayoutAndUnits) {
  const TemporaryFolder folder;
  write_pair(folder);
  const std::unique_ptr<Hdf5File> file = Hdf5File::open(folder / "samples.h5");
  const Frame frame = read_back(folder / "data", 0).frame;
  std::vector<float> values;
  const std::unique_ptr<Hdf5Data> motion = file->data("motionvecs", 5);
  EXPECT_EQ(motion->dimensions, (std::vector<uint64_t>{2, 2, 3, 6, 8}));
  motion->read_frame(0, values);
  const int offset = find_feature("motion").offset;
  // NDC: the picture is 2 wide and 2 high, y up.
  EXPECT_NEAR(values[7], frame.plane(0, offset)[7] / 4, 1e-3F);
  EXPECT_NEAR(values[48 + 7], -frame.plane(0, offset + 1)[7] / 3, 1e-3F);
  EXPECT_NEAR(values[96 + 7], frame.plane(0, offset + 2)[7], 1e-3F);  // the circle of confusion
  const std::unique_ptr<Hdf5Data> depths = file->data("normals_depth", 5);
  EXPECT_EQ(depths->dimensions[2], 4u);
  depths->read_frame(0, values);
  const float depth = frame.plane(0, kDepthOffset)[7];
  EXPECT_NEAR(values[3 * 48 + 7], depth / (depth + 4), 1e-3F);
  EXPECT_EQ(values[3 * 48 + 3], 1);  // escaped
  EXPECT_EQ(file->data("color", 5)->dimensions[2], 3u);
  EXPECT_EQ(file->data("albedo", 5)->dimensions[2], 3u);
  EXPECT_EQ(file->data("specular", 5)->dimensions[2], 4u);
  EXPECT_EQ(file->data("uvt", 5)->dimensions[2], 3u);
  const Hdf5Handle same(H5Fopen((folder / "samples.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose),
      color(H5Dopen2(same.get(), "color", H5P_DEFAULT), H5Dclose), type(H5Dget_type(color.get()), H5Tclose);
  EXPECT_EQ(H5Tget_size(type.get()), 2u);
  EXPECT_EQ(Hdf5File::open(folder / "references.h5")->data("color", 4)->dimensions,
            (std::vector<uint64_t>{2, 3, 6, 8}));
}

/// A pair of files as another program would write them: no depth_scale.
void write_foreign(const TemporaryFolder& folder) {
  const std::unique_ptr<Hdf5File> samples = Hdf5File::create(folder / "samples.h5");
  std::vector<float> color(3 * 4), normals(4 * 4);
  for (size_t i = 0; i < color.size(); ++i) color[i] = static_cast<float>(i);
  for (size_t p = 0; p < 4; ++p) {
    normals[8 + p] = p == 3 ? 0.0F : 1.0F;
    normals[12 + p] = p == 3 ? 1.0F : 0.25F;
  }
  samples->make("color", {1, 1, 3, 2, 2})->write_frame(0, color);
  samples->make("normals_depth", {1, 1, 4, 2, 2})->write_frame(0, normals);
  Hdf5File::create(folder / "references.h5")
      ->make("color", {1, 3, 2, 2})
      ->write_frame(0, std::vector<float>(12, 1));
}

// d / (d + s) in half floats would lose a tenth at d = 400 s, and everything beyond 2047 s.
TEST(Hdf5, DepthsSurviveHoweverFar) {
  const TemporaryFolder folder;
  Frame frame = sample_frame(1);
  frame.info.depth_scale = 5.0760F;
  const std::vector<float> depths = {5.0742F, 5.0760F, 0.001F, 500, 2000, 5000, 30000, 65472, kEscapedDepth};
  for (size_t p = 0; p < depths.size(); ++p) frame.plane(1, kDepthOffset)[p] = depths[p];
  add_to_data_set({folder / "data", "frame_0", "train"}, frame, grey_reference(8, 6));
  data_set_to_hdf5(folder / "data", "train", folder / "samples.h5", folder / "references.h5");
  read_pair(folder, "back");
  const Frame before = read_back(folder / "data", 0).frame, after = read_back(folder / "back", 0).frame;
  for (int s = 0; s < 2; ++s)
    for (size_t p = 0; p < 48; ++p)
      EXPECT_EQ(after.plane(s, kDepthOffset)[p], before.plane(s, kDepthOffset)[p]) << "pixel " << p;
  // What readers of the published layout find.
  std::vector<float> values;
  Hdf5File::open(folder / "samples.h5")->data("normals_depth", 5)->read_frame(0, values);
  const float* ratio = values.data() + (4 + 3) * 48;
  EXPECT_NEAR(ratio[0], 5.0742 / (5.0742 + 5.0760), 3e-4);
  EXPECT_EQ(ratio[7], 1 - 1.0F / 2048) << "a hit, however far, is not escaped";
  EXPECT_EQ(ratio[8], 1);
  EXPECT_EQ(Hdf5File::open(folder / "samples.h5")->data("depth", 5)->dimensions,
            (std::vector<uint64_t>{1, 2, 1, 6, 8}));
}

TEST(Hdf5, DepthsInSceneUnitsAreNotTrusted) {
  const TemporaryFolder folder;
  write_foreign(folder);
  {
    const std::unique_ptr<Hdf5File> file = Hdf5File::create(folder / "samples.h5");
    file->make("color", {1, 1, 3, 2, 2})->write_frame(0, std::vector<float>(12, 2));
    file->make("normals_depth", {1, 1, 4, 2, 2})->write_frame(0, std::vector<float>(16, 0.5F));
    file->make("depth_scale", {1}, true)->write_frame(0, {2});
    file->make("depth", {1, 1, 1, 2, 2}, true)
        ->write_frame(0, {3, std::numeric_limits<float>::quiet_NaN(), 1e30F, 0.25F});
  }
  read_pair(folder, "back");
  const Frame frame = read_back(folder / "back", 0).frame;
  EXPECT_EQ(std::vector<float>(frame.plane(0, kDepthOffset), frame.plane(0, kDepthOffset) + 4),
            (std::vector<float>{3, kEscapedDepth, kEscapedDepth, 0.25F}));
  EXPECT_EQ(frame.info.depth_scale, 2);
  {
    const std::unique_ptr<Hdf5File> file = Hdf5File::create(folder / "samples.h5");
    file->make("color", {1, 1, 3, 2, 2})->write_frame(0, std::vector<float>(12, 2));
    file->make("depth_scale", {1}, true)->write_frame(0, {2});
    file->make("depth", {1, 1, 1, 2, 3})->write_frame(0, std::vector<float>(6, 1));
  }
  EXPECT_ERROR(read_pair(folder, "d"),
               "data set 'depth': of the shape [1, 1, 1, 2, 3]; expected [1, 1, 1, 2, 2]");
}

TEST(Hdf5, ColoursBeyondHalfFloatsKeepTheirHue) {
  const TemporaryFolder folder;
  write_image(reference_path(folder / "data", "a"), grey_reference(2, 1).image);
  write_exr_parts(frame_path(folder / "data", "a"), {{0, 0}, {1, 0}},
                  {{"s000",
                    {{0, 0}, {1, 0}},
                    {{"R", everywhere(1e6F)}, {"G", everywhere(5e5F)}, {"B", everywhere(2.5e5F)}}}});
  Manifest manifest;
  manifest.frames.emplace_back();
  manifest.frames[0].name = "a";
  manifest.frames[0].split = "train";
  add_to_manifest(folder / "data", manifest);
  const Hdf5Report report =
      data_set_to_hdf5(folder / "data", "train", folder / "samples.h5", folder / "references.h5");
  EXPECT_EQ(report.clamped, 6);
  read_pair(folder, "back");
  const Frame after = read_back(folder / "back", 0).frame;
  EXPECT_EQ(after.valid_plane(0)[0], 1);
  for (int c = 0; c < 3; ++c) EXPECT_EQ(after.plane(0, c)[0], 65504.0F / static_cast<float>(1 << c));
}

TEST(Hdf5, StoppedItLeavesNeitherFile) {
  const TemporaryFolder folder;
  write_pair(folder);
  Manifest many;
  for (int i = 0; i < 400; ++i) {
    ManifestFrame& entry = many.frames.emplace_back();
    entry.name = fmt::format("many_{}", i);
    entry.split = "validation";
    fs::create_hard_link(frame_path(folder / "data", "frame_0"), frame_path(folder / "data", entry.name));
    fs::create_hard_link(reference_path(folder / "data", "frame_0"),
                         reference_path(folder / "data", entry.name));
  }
  add_to_manifest(folder / "data", many);
  fs::create_directory(folder / "out");
  const std::string samples = (folder / "out/samples.h5").string(),
                    references = (folder / "out/references.h5").string();
  RunningProgram program("ld_import", {"--to-hdf5", samples, "--reference", references, "--out",
                                       (folder / "data").string(), "--split", "validation"});
  for (int waited = 0; waited < 60000 && fs::is_empty(folder / "out"); ++waited)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  program.signal(SIGINT);
  EXPECT_EQ(program.wait(), 130) << program.output();
  const std::string left = samples + " and " + references + " are not written";
  EXPECT_NE(program.output().find(left), std::string::npos) << program.output();
  EXPECT_TRUE(fs::is_empty(folder / "out"));
}

TEST(Hdf5, WhatIsMissingIsLeftOut) {
  const TemporaryFolder folder;
  write_pair(folder, {"radiance", "normal", "depth", "albedo", "specular"});
  const Hdf5Report report = read_pair(folder, "back");
  EXPECT_EQ(report.left_out, (std::vector<std::string>{"specular", "motionvecs", "uvt"}));
  EXPECT_EQ(read_back(folder / "back", 0).frame.features,
            (std::vector<std::string>{"radiance", "normal", "depth", "albedo"}));
}

TEST(Hdf5, DepthsOfOtherPrograms) {
  const TemporaryFolder folder;
  write_foreign(folder);
  read_pair(folder, "linear");
  const Frame linear = read_back(folder / "linear", 0).frame;
  EXPECT_EQ(linear.plane(0, kDepthOffset)[0], 0.25F);
  EXPECT_EQ(linear.plane(0, kDepthOffset)[3], kEscapedDepth);
  EXPECT_EQ(linear.plane(0, 2)[3], 11);
  read_pair(folder, "ratio", Hdf5Depth::ratio);
  const Frame ratio = read_back(folder / "ratio", 0).frame;
  EXPECT_NEAR(ratio.plane(0, kDepthOffset)[0], 1 / 3.0F, 1e-3F);  // d / (d + 1) = 0.25
  EXPECT_EQ(ratio.plane(0, kDepthOffset)[3], kEscapedDepth);
}

TEST(Hdf5, HostileFilesGiveOneError) {
  const TemporaryFolder folder;
  EXPECT_ERROR(read_pair(folder, "d"), "samples.h5: no such file");
  write_foreign(folder);
  const std::string good = read_file(folder / "samples.h5");
  write_file_atomically(folder / "samples.h5", good.substr(0, good.size() / 3));
  EXPECT_ERROR(read_pair(folder, "d"), "no HDF5 file, or a damaged one");
  write_file_atomically(folder / "samples.h5", "Dear reader");
  EXPECT_ERROR(read_pair(folder, "d"), "no HDF5 file");

  const auto with_color = [&](const std::vector<uint64_t>& dimensions) {
    Hdf5File::create(folder / "samples.h5")->make("color", dimensions);
    return error_text([&] { read_pair(folder, "d"); });
  };
  EXPECT_NE(
      with_color({1'000'000, 64, 3, 64, 64}).find("declares [1000000, 64, 3, 64, 64] numbers, but the file"),
      std::string::npos);
  EXPECT_NE(with_color({1, 3, 2, 2}).find("4 dimensions; expected 5"), std::string::npos);
  {
    const std::unique_ptr<Hdf5File> file = Hdf5File::create(folder / "samples.h5");
    file->make("albedo", {1, 1, 3, 2, 2});
  }
  EXPECT_ERROR(read_pair(folder, "d"), "data set 'color' is missing");
  {
    const std::unique_ptr<Hdf5File> file = Hdf5File::create(folder / "samples.h5");
    file->make("color", {1, 1, 3, 2, 2})->write_frame(0, std::vector<float>(12, 1));
    file->make("uvt", {1, 1, 3, 2, 3})->write_frame(0, std::vector<float>(18, 1));
  }
  EXPECT_ERROR(read_pair(folder, "d"),
               "data set 'uvt': of the shape [1, 1, 3, 2, 3]; expected [1, 1, 3, 2, 2]");
  {
    const Hdf5Handle file(H5Fcreate((folder / "samples.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT),
                          H5Fclose);
    const hsize_t dimensions[] = {1, 1, 3, 2, 2};
    const Hdf5Handle space(H5Screate_simple(5, dimensions, nullptr), H5Sclose);
    const Hdf5Handle data(
        H5Dcreate2(file.get(), "color", H5T_STD_I32LE, space.get(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
        H5Dclose);
    ASSERT_TRUE(data.ok());
  }
  EXPECT_ERROR(read_pair(folder, "d"), "holds no floats");
  EXPECT_FALSE(fs::exists(folder / "d"));
}

/// HDF5 1.10 reads from a null pointer on this file (found by a fuzzer); 1.14 finds no data set in it.
TEST(Hdf5, AFaultOfTheLibraryIsAnErrorOfOurs) {
  const TemporaryFolder folder;
  const std::string file = std::string(LD_SOURCE_DIR) + "/tests/fixtures/hdf5/fault.h5";
  const ProgramResult result =
      run_program("ld_import", {"--from-hdf5", file, "--reference", file, "--out", (folder / "data").string(),
                                "--split", "test", "--name", "f"});
  const bool faults = H5_VERS_MAJOR == 1 && H5_VERS_MINOR == 10;
  expect_failure(result, 1, {file, faults ? "copy it again" : "data set 'color' is missing"});
  EXPECT_FALSE(fs::exists(folder / "data"));
}

TEST(Hdf5, AGoodPairComesToNoFault) {
  const TemporaryFolder folder;
  write_pair(folder);
  require_no_fault_in_hdf5(folder / "samples.h5", folder / "references.h5");
  EXPECT_EQ(read_pair(folder, "back").frames, 2);
}

}  // namespace
}  // namespace ld
