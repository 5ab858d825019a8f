// The doctor finds each of its faults in a data set made to have it, and none in a good one.
#include "doctor/doctor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "core/file_io.h"
#include "tests/doctor/pictures.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

struct Fault {
  const char* name;
  const char* check;
  const char* says;  // part of the finding's text
  std::function<void(Picture&)> put_in;
  std::vector<std::string> also;  // checks that the fault may trouble besides
};

const int kAlbedo = find_feature("albedo").offset;

const std::vector<Fault>& faults() {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(),
                  kInfinity = std::numeric_limits<float>::infinity();
  static const std::vector<Fault> all = {
      {"NaN radiance",
       "values",
       "NaN or infinity in the feature 'radiance'",
       [](Picture& p) { sprinkle(p, 0, 100, kNan); },
       {}},
      {"infinite depth of escaped rays",
       "values",
       "write 65504 where the ray escaped",
       [](Picture& p) { sprinkle(p, kDepthOffset, 50, kInfinity); },
       {"depth"}},
      {"negative radiance",
       "values",
       "radiance channels are negative",
       [](Picture& p) { sprinkle(p, 1, 100, -0.5F); },
       {}},
      {"references through a view transform",
       "values",
       "brighter or darker than their reference",
       [](Picture& p) {
         for (float& value : p.reference.pixels) value = std::sqrt(value / (1 + value)) * 2;
       },
       {"fireflies", "seeds"}},
      {"fireflies",
       "fireflies",
       "carry more than 10 % of the radiance",
       [](Picture& p) { sprinkle(p, 0, 300, 20000); },
       {"values"}},
      {"fireflies in the references",
       "fireflies",
       "reference pixels",
       [](Picture& p) {
         for (size_t i = 7; i < p.reference.pixels.size(); i += 150) p.reference.pixels[i] = 3000;
       },
       {"values"}},
      {"albedo above one",
       "ranges",
       "'albedo' of",
       [](Picture& p) {
         change_samples(p.frame, kAlbedo, 3, [](const Frame&, int, int, float* a) {
           for (int c = 0; c < 3; ++c) a[c] *= 1.5F;
         });
       },
       {}},
      {"time in frames",
       "ranges",
       "'time' of",
       [](Picture& p) {
         change_samples(p.frame, find_feature("time").offset, 1,
                        [](const Frame&, int, int, float* time) { *time = 24 * *time + 3; });
       },
       {}},
      {"world-space normals", "normals", "not in view space", to_world_space, {}},
      {"normals with z flipped",
       "normals",
       "negate z",
       [](Picture& p) {
         change_samples(p.frame, kNormalOffset, 3, [](const Frame&, int, int, float* n) { n[2] = -n[2]; });
       },
       {}},
      {"normals with y down",
       "normals",
       "negate y",
       [](Picture& p) {
         change_samples(p.frame, kNormalOffset, 3, [](const Frame&, int, int, float* n) { n[1] = -n[1]; });
       },
       {}},
      {"normals as colours",
       "normals",
       "write 2 c - 1",
       [](Picture& p) {
         change_samples(p.frame, kNormalOffset, 3, [](const Frame&, int, int, float* n) {
           if (n[0] != 0 || n[1] != 0 || n[2] != 0)
             for (int c = 0; c < 3; ++c) n[c] = 0.5F * (n[c] + 1);
         });
       },
       {}},
      {"distance along the ray", "depth", "along the ray", to_ray_distance, {}},
      {"millimetres",
       "depth",
       "write metres",
       [](Picture& p) {
         change_samples(p.frame, kDepthOffset, 1, [](const Frame&, int, int, float* depth) {
           *depth = std::min(*depth * 5000, kEscapedDepth);
         });
       },
       {}},
      {"tiny depths",
       "depth",
       "smaller unit",
       [](Picture& p) {
         change_samples(p.frame, kDepthOffset, 1, [](const Frame&, int, int, float* depth) {
           if (*depth < kEscapedDepth) *depth *= 1e-5F;
         });
       },
       {}},
      {"negative depth",
       "depth",
       "negate it",
       [](Picture& p) {
         change_samples(p.frame, kDepthOffset, 1, [](const Frame&, int, int, float* depth) {
           if (*depth < kEscapedDepth) *depth = -*depth;
         });
       },
       {}},
      {"escaped rays at depth 0",
       "depth",
       "a depth other than 65504",
       [](Picture& p) {
         change_samples(p.frame, kDepthOffset, 1, [](const Frame&, int, int, float* depth) {
           if (*depth >= kEscapedDepth) *depth = 0;
         });
       },
       {}},
      {"the mean as reference",
       "seeds",
       "hold the samples themselves",
       [](Picture& p) { p.reference = mean_radiance(p.frame); },
       {}},
      {"references that hold the samples among twice as many",
       "seeds",
       "hold the samples themselves",
       [](Picture& p) {
         const Image mean = mean_radiance(p.frame);
         for (size_t i = 0; i < mean.pixels.size(); ++i)
           p.reference.pixels[i] = 0.6F * mean.pixels[i] + 0.4F * p.reference.pixels[i];
       },
       {}},
      {"one sample in the reference",
       "seeds",
       "sample s003 is in the references",
       [](Picture& p) {
         for (int c = 0; c < 3; ++c)
           for (size_t i = 0; i < p.frame.plane_size(); ++i)
             p.reference.plane(c)[i] = (15 * p.reference.plane(c)[i] + p.frame.plane(3, c)[i]) / 16;
       },
       {}},
      {"the same sample twice",
       "seeds",
       "repeat each other",
       [](Picture& p) { std::copy_n(p.frame.plane(2, 0), 3 * p.frame.plane_size(), p.frame.plane(5, 0)); },
       {}},
      {"a filter wider than a pixel", "filter", "wider than a pixel", blur_samples, {}},
  };
  return all;
}

class Doctor : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    const TemporaryFolder folder;
    good_ = new Pictures(render_pictures(folder.path()));
  }
  static void TearDownTestSuite() { delete good_; }
  static Pictures* good_;
};
Pictures* Doctor::good_ = nullptr;

TEST_F(Doctor, FindsNothingInAGoodDataSet) {
  const Diagnosis diagnosis = examine(*good_);
  EXPECT_TRUE(diagnosis.findings.empty()) << text_of(diagnosis);
  EXPECT_EQ(diagnosis.facts["examined_frames"], 8);
  EXPECT_EQ(diagnosis.facts["features_auto"].size(), 10u);
  EXPECT_EQ(diagnosis.facts["normals"]["facing_away"], 0);
  EXPECT_GT(diagnosis.facts["depth_axis"]["flat_surfaces"], 30) << "enough to judge by";
  EXPECT_LT(std::abs(diagnosis.facts["depth_axis"]["exponent"].get<double>()), 0.2);
  EXPECT_NEAR(diagnosis.facts["neighbour_correlation"].get<double>(), 0, 0.01);
  EXPECT_GT(diagnosis.facts["reference_distance"]["over_sample_variance"].get<double>(), 0.9);
  EXPECT_NEAR(diagnosis.facts["ranges"]["lens"]["mean"].get<double>(), 0, 0.05);
}

TEST_F(Doctor, FindsEachFault) {
  for (const Fault& fault : faults()) {
    SCOPED_TRACE(fault.name);
    Pictures pictures = *good_;
    for (Picture& picture : pictures) fault.put_in(picture);
    const Diagnosis diagnosis = examine(pictures);
    bool found = false;
    for (const Finding& finding : diagnosis.findings) {
      const bool own = finding.check == fault.check;
      found = found || (own && finding.severity == Severity::problem &&
                        finding.text.find(fault.says) != std::string::npos);
      const bool other = own || std::count(fault.also.begin(), fault.also.end(), finding.check) > 0;
      EXPECT_TRUE(other) << "takes it for something else: " << finding.text;
      EXPECT_EQ(finding.text.find('\n'), std::string::npos);
    }
    EXPECT_TRUE(found) << text_of(diagnosis);
  }
}

TEST_F(Doctor, FindsAveragedGuides) {
  Pictures pictures = *good_;
  for (Picture& picture : pictures) average_guides(picture);
  EXPECT_NE(text_of(examine(pictures)).find("guides are averaged over the pixel"), std::string::npos);
}

TEST_F(Doctor, FindsLeaksBetweenSplits) {
  Pictures pictures = *good_;
  Picture copy = pictures[0];
  copy.entry.name = "copy";
  copy.entry.split = "train";
  pictures.push_back(copy);
  EXPECT_EQ(text_of(examine(pictures)), "") << "twice in one split is no leak";
  pictures.back().entry.split = "test";
  EXPECT_NE(text_of(examine(pictures))
                .find("problem: splits: 1 pair of frames in different splits have the same "
                      "reference: frame_000000 and copy (train, test)"),
            std::string::npos);
  // The same view, brighter and a little to the side: other bytes.
  for (float& value : pictures.back().reference.pixels) value *= 1.5F;
  for (int s = 0; s < copy.frame.spp; ++s)
    for (int c = 0; c < kSampleChannels; ++c) {
      float* plane = pictures.back().frame.plane(s, c);
      std::rotate(plane, plane + 1, plane + copy.frame.plane_size());
      if (c < 3)
        for (size_t p = 0; p < copy.frame.plane_size(); ++p) plane[p] *= 1.5F;
    }
  const std::string text = text_of(examine(pictures));
  EXPECT_NE(text.find("problem: splits: 1 pair of frames in different splits show the same scene"),
            std::string::npos)
      << text;
}

TEST_F(Doctor, NamesWhatDoesNotVary) {
  Pictures pictures = *good_;
  for (Picture& picture : pictures)
    for (const char* feature : {"motion", "coc"})
      change_samples(picture.frame, find_feature(feature).offset, find_feature(feature).channels,
                     [](const Frame&, int, int, float* values) { std::fill_n(values, 3, 0.0F); });
  const Diagnosis diagnosis = examine(pictures);
  EXPECT_EQ(diagnosis.facts["features_auto"],
            (nlohmann::ordered_json{"radiance", "normal", "depth", "albedo", "specular", "roughness"}));
  ASSERT_EQ(diagnosis.findings.size(), 1u) << text_of(diagnosis);
  EXPECT_EQ(diagnosis.findings[0].severity, Severity::warning);
  EXPECT_NE(diagnosis.findings[0].text.find("features: auto"), std::string::npos);
}

TEST_F(Doctor, ReadsOnIfAFrameIsDamagedAndOnlySomeIfAsked) {
  const TemporaryFolder folder;
  const Manifest manifest = write_pictures(folder.path(), *good_);
  const fs::path damaged = frame_path(folder.path(), manifest.frames[2].name);
  const std::string bytes = read_file(damaged);
  write_file_atomically(damaged, bytes.substr(0, bytes.size() - 100));
  Diagnosis diagnosis = examine_dataset(folder.path(), manifest, {2, 0});
  ASSERT_EQ(diagnosis.findings.size(), 1u) << text_of(diagnosis);
  EXPECT_EQ(diagnosis.findings[0].check, "files");
  EXPECT_NE(diagnosis.findings[0].text.find("cut short"), std::string::npos);
  EXPECT_EQ(diagnosis.findings[0].frames, std::vector<std::string>{"frame_000002"});
  diagnosis = examine_dataset(folder.path(), manifest, {1, 3});  // frames 0, 2 and 5
  EXPECT_EQ(diagnosis.facts["examined_frames"], 3);
  ASSERT_EQ(diagnosis.findings.size(), 1u) << "frame 2 again" << text_of(diagnosis);
  EXPECT_EQ(diagnosis.findings[0].check, "files");
}

TEST_F(Doctor, ThreadsDoNotMatter) {
  const TemporaryFolder folder;
  Pictures pictures = *good_;
  to_world_space(pictures[3]);
  sprinkle(pictures[4], 0, 100, -1);
  const Manifest manifest = write_pictures(folder.path(), pictures);
  const Diagnosis one = examine_dataset(folder.path(), manifest, {1, 0}),
                  three = examine_dataset(folder.path(), manifest, {3, 0});
  EXPECT_EQ(one.facts, three.facts);
  EXPECT_EQ(text_of(one), text_of(three));
}

}  // namespace
}  // namespace ld
