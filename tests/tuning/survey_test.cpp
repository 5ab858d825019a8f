#include "tuning/survey.h"

#include <gtest/gtest.h>

#include <functional>

#include "frame/frame_file.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_dataset.h"

namespace ld {
namespace {

void change_frames(const std::filesystem::path& folder, const std::function<void(Frame&)>& change) {
  Manifest manifest = read_manifest(folder);
  for (const ManifestFrame& entry : manifest.frames) {
    Faults faults;
    Frame frame = read_frame(frame_path(folder, entry.name), {"radiance"}, faults);
    change(frame);
    write_frame(frame_path(folder, entry.name), frame);
  }
}

const SurveyedFeature& of(const DataSurvey& survey, const std::string& name) {
  return *std::find_if(survey.features.begin(), survey.features.end(),
                       [&](const SurveyedFeature& feature) { return feature.name == name; });
}

TEST(TuningSurvey, ConstantFeaturesAreDroppedAndSaid) {
  const TemporaryFolder folder;
  write_tiny_dataset(folder.path(), 3, 16, 2);
  change_frames(folder.path(), [](Frame& frame) {
    for (int s = 0; s < frame.spp; ++s) {
      for (const char* name : {"coc", "roughness"}) {
        float* plane = frame.plane(s, find_feature(name).offset);
        std::fill_n(plane, frame.plane_size(), name == std::string("coc") ? 0.0F : 0.25F);
      }
      std::copy_n(frame.plane(0, kDepthOffset), frame.plane_size(), frame.plane(s, kDepthOffset));
    }
  });
  const DataSurvey survey = survey_data(folder.path(), 0, 1);
  EXPECT_EQ(survey.samples, 2);
  EXPECT_EQ(survey.frames, 3);
  EXPECT_EQ(survey.looked_at, 3);
  EXPECT_EQ(of(survey, "coc").reason, "it is 0 everywhere");
  EXPECT_EQ(of(survey, "lens").reason, "coc is 0 everywhere");
  EXPECT_EQ(of(survey, "roughness").reason, "it is 0.25 everywhere");
  EXPECT_EQ(of(survey, "flow").reason, "no frame holds it");
  EXPECT_TRUE(survey.uses("motion") && survey.uses("time") && survey.uses("depth"));
  EXPECT_FALSE(survey.uses("lens"));
  EXPECT_EQ(of(survey, "depth").within, 0);
  EXPECT_GT(of(survey, "normal").within, 0.9);
  std::string all;
  for (const std::string& sentence : sentences(survey)) all += sentence + "\n";
  EXPECT_NE(all.find("roughness: dropped, it is 0.25 everywhere."), std::string::npos) << all;
  EXPECT_NE(all.find("kept are radiance, normal, depth, albedo, specular, motion, time."), std::string::npos)
      << all;
}

TEST(TuningSurvey, OneFrameThatLacksAFeatureIsEnough) {
  const TemporaryFolder folder;
  write_tiny_dataset(folder.path(), 3, 16, 2);
  bool first = true;
  change_frames(folder.path(), [&](Frame& frame) {
    if (std::exchange(first, false))
      frame.features.erase(std::find(frame.features.begin(), frame.features.end(), "albedo"));
  });
  EXPECT_EQ(of(survey_data(folder.path(), 0, 1), "albedo").reason, "only 2 of 3 frames hold it");
}

TEST(TuningSurvey, DataThatWillNotDoAreRefused) {
  const TemporaryFolder folder;
  EXPECT_ERROR(survey_data(folder / "nowhere", 0, 1), "nowhere");
  write_tiny_dataset(folder.path(), 2, 16, 2);
  EXPECT_ERROR(survey_data(folder.path(), 3, 1), "has 2 samples a pixel, expected at least 3");
  Manifest manifest = read_manifest(folder.path());
  const TemporaryFolder other;
  for (ManifestFrame& frame : manifest.frames) {
    frame.split = "train";
    std::filesystem::copy(frame_path(folder.path(), frame.name), frame_path(other.path(), frame.name));
  }
  add_to_manifest(other.path(), manifest);
  EXPECT_ERROR(survey_data(other.path(), 0, 1), "validation");
}

}  // namespace
}  // namespace ld
