// Parts of the light as sums of products of passes.
#include "import/light_parts.h"

#include <gtest/gtest.h>

#include <cmath>

#include "import/frame_import.h"
#include "tests/support/cycles_passes.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

ImportMapping cycles_with(const std::vector<std::string>& assignments = {}) {
  return read_mapping("cycles", "", assignments);
}

TEST(LightPartFormulas, AreSumsOfProductsOfLayers) {
  const LightPartFormula formula = parse_light_part("a b = *.X | Y Z * C + D");
  EXPECT_EQ(formula.name, "a b");
  EXPECT_EQ(formula.terms, (std::vector<std::vector<std::string>>{{"*.X | Y Z", "C"}, {"D"}}));
  for (const char* text :
       {"", "a", "a = ", " = a", "a = b + ", "a = b *  * c", "a = b = c", "a_{group} = b", "a = b_{group}"})
    EXPECT_ERROR(parse_light_part(text), "expected 'NAME = LAYER * LAYER + LAYER'");
  EXPECT_ERROR(cycles_with({"parts=[\"a=b\"]"}), "mapping: parts: 'a=b'");
}

/// The largest difference between the radiance and the sum of the parts that `also` names.
double largest_rest(const Frame& frame) {
  double most = 0;
  for (int s = 0; s < frame.spp; ++s)
    for (int c = 0; c < 3; ++c)
      for (size_t p = 0; p < frame.plane_size(); ++p) {
        double sum = 0;
        for (size_t part = 0; part < frame.parts.size(); ++part)
          sum += double(frame.part_plane(part, s, c)[p]);
        most = std::max(most, std::fabs(sum - double(frame.plane(s, c)[p])));
      }
  return most;
}

class CyclesParts : public ::testing::TestWithParam<bool> {
 protected:
  void SetUp() override {
    for (uint32_t s = 0; s < 3; ++s) {
      files_.push_back(folder_ / ("sample_" + std::to_string(s) + ".exr"));
      write_cycles_passes(files_.back(), 9, 7, 10 + s, GetParam());
    }
  }
  ImportedFrame import(const std::vector<std::string>& also) {
    return import_frame(files_, cycles_with(), std::nullopt, false, also);
  }
  TemporaryFolder folder_;
  std::vector<std::filesystem::path> files_;
};

TEST_P(CyclesParts, PassesAndGroupsSumToCombinedInEverySample) {
  EXPECT_TRUE(import({}).frame.parts.empty());
  for (const std::vector<std::string>& also :
       {std::vector<std::string>{"diffuse", "glossy", "transmission", "emitted", "environment"},
        {"light_*"},
        {"*_direct", "*_indirect", "em*", "env*"}}) {
    const Frame frame = import(also).frame;
    EXPECT_GE(frame.parts.size(), 2u);
    EXPECT_LE(largest_rest(frame), 1e-5);
  }
  const Frame one = import({"light_rim light"}).frame;
  ASSERT_EQ(one.parts.size(), 1u);
  EXPECT_EQ(one.parts[0].name, "light_rim light");
}

TEST_P(CyclesParts, DirectIndirectAndEmittedLightAreFeaturesThatSumToTheRadiance) {
  const ImportedFrame imported = import({});
  const Frame& frame = imported.frame;
  for (const char* name : {"direct", "indirect", "emission"}) EXPECT_TRUE(frame.holds(name)) << name;
  EXPECT_EQ(
      std::count(imported.taken.begin(), imported.taken.end(), "indirect: radiance - direct - emission"), 1);
  const Frame parts = import({"*_direct", "emitted", "environment"}).frame;
  ASSERT_EQ(parts.parts.size(), 5u);
  double indirect = 0;
  for (int s = 0; s < frame.spp; ++s)
    for (int c = 0; c < 3; ++c)
      for (size_t p = 0; p < frame.plane_size(); ++p) {
        const double d = frame.plane(s, kDirectOffset + c)[p], i = frame.plane(s, kIndirectOffset + c)[p],
                     e = frame.plane(s, kEmissionOffset + c)[p];
        ASSERT_NEAR(d + i + e, frame.plane(s, kRadianceOffset + c)[p], 1e-5);
        double direct = 0, emitted = 0;
        for (size_t part = 0; part < 5; ++part) {
          const bool is_direct = parts.parts[part].name.find("direct") != std::string::npos;
          (is_direct ? direct : emitted) += double(parts.part_plane(part, s, c)[p]);
        }
        ASSERT_NEAR(d, direct, 1e-5);
        ASSERT_NEAR(e, emitted, 1e-5);
        indirect += i;
      }
  EXPECT_GT(indirect, 0);
  // Without one of the two nothing is split.
  const Frame whole =
      import_frame(files_, cycles_with({"parts=[\"emission = *.Emit | *.Emission\"]"}), std::nullopt, false)
          .frame;
  EXPECT_FALSE(whole.holds("direct") || whole.holds("indirect") || whole.holds("emission"));
}

TEST_P(CyclesParts, SayWhatTheyAreMadeOf) {
  const std::vector<std::string> taken = import({"diffuse_direct"}).taken;
  const std::string expected = GetParam()
                                   ? "diffuse_direct: ViewLayer.Diffuse Direct * ViewLayer.Diffuse Color"
                                   : "diffuse_direct: ViewLayer.DiffDir * ViewLayer.DiffCol";
  EXPECT_EQ(std::count(taken.begin(), taken.end(), expected), 1);
}

TEST_P(CyclesParts, ThatAreNotThereAreAnErrorThatNamesThoseThatAre) {
  EXPECT_ERROR(import({"volume"}), "no part of the light is called 'volume'; there are diffuse, glossy");
}

TEST_P(CyclesParts, MustBeInAllFiles) {
  write_exr_parts(files_[1], Imath::Box2i({0, 0}, {8, 6}),
                  {{"", Imath::Box2i({0, 0}, {8, 6}), colour("ViewLayer.Combined.", 1)}});
  EXPECT_ERROR(import_frame(files_,
                            cycles_with({"depth.channels=[]", "alpha.channels=[]", "albedo.channels=[]",
                                         "specular.channels=[]"}),
                            std::nullopt, false, {"diffuse"}),
               "sample_1.exr: no part of the light is called 'diffuse'; there is none");
}

INSTANTIATE_TEST_SUITE_P(Blender, CyclesParts, ::testing::Values(false, true),
                         [](const auto& blender) { return blender.param ? "Five" : "Four"; });

TEST(LightPartsOfSamples, AreFoundByTheirNumbersInOneFile) {
  const TemporaryFolder folder;
  const Imath::Box2i window({0, 0}, {1, 0});
  TestPart part{"", window, {}};
  for (int s = 0; s < 3; ++s) {
    const std::string number = std::to_string(s);
    for (const auto& channel : colour("L" + number + ".", 2.0F + float(s))) part.channels.push_back(channel);
    for (const auto& channel : colour("lamp." + number + ".", 1.0F + float(s)))
      part.channels.push_back(channel);
  }
  for (const auto& channel : colour("tint.", 0.5F)) part.channels.push_back(channel);
  write_exr_parts(folder / "file.exr", window, {part});
  ImportMapping mapping;
  mapping.features[0].channels = {"L{sample}.R", "L{sample}.G", "L{sample}.B"};
  mapping.features[0].scale = {1, 1, 1};
  mapping.features[0].offset = {0, 0, 0};
  mapping.parts = {"tinted = lamp.{sample} * tint"};
  const Frame frame = import_frame({folder / "file.exr"}, mapping, std::nullopt, true, {"tinted"}).frame;
  ASSERT_EQ(frame.spp, 3);
  for (int s = 0; s < 3; ++s) EXPECT_EQ(frame.part_plane(0, s, 1)[1], 0.5F * (1.0F + float(s)));
}

}  // namespace
}  // namespace ld
