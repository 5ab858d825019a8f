// What classical filters read: none of it is wrong in rendered frames, and each fault is found.
#include <gtest/gtest.h>

#include "tests/doctor/pictures.h"

namespace ld {
namespace {

struct FilterGuideFault {
  const char* says;
  Severity severity;
  std::function<void(Frame&)> put_in;
};

const std::vector<FilterGuideFault>& filter_guide_faults() {
  static const std::vector<FilterGuideFault> all = {
      {"do not add up to radiance", Severity::problem,
       [](Frame& f) {
         change_samples(f, kIndirectOffset, 3,
                        [](const Frame&, int, int, float* v) { std::fill_n(v, 3, 0.0F); });
       }},
      {"do not add up to radiance", Severity::problem,
       [](Frame& f) {
         change_samples(f, kDirectOffset, 3, [](const Frame&, int, int, float* v) {
           for (int c = 0; c < 3; ++c) v[c] *= 1.01F;
         });
       }},
      {"no whole number", Severity::problem,
       [](Frame& f) {
         change_samples(f, kIdOffset, 1, [](const Frame&, int x, int, float* id) {
           if (x % 3 == 0) *id *= 0.7F;
         });
       }},
      {"no longer tell neighbours apart", Severity::problem,
       [](Frame& f) {
         change_samples(f, kIdOffset, 1, [](const Frame&, int, int, float* id) { *id *= 1e9F; });
       }},
      {"id is 0, which is no object", Severity::warning,
       [](Frame& f) { change_samples(f, kIdOffset, 1, [](const Frame&, int, int, float* id) { *id = 0; }); }},
      {"id is not 0 in", Severity::warning,
       [](Frame& f) {
         change_samples(f, kIdOffset, 1, [](const Frame&, int, int, float* id) { *id += 1; });
       }},
      {"scales unevenly or shears", Severity::problem,
       [](Frame& f) { (*f.info.world_to_camera)[4] += 0.1F; }},
  };
  return all;
}

TEST(DoctorOfFilterGuides, FindsNothingInRenderedFramesAndEachFault) {
  const TemporaryFolder folder;
  const Pictures good = render_pictures(folder.path(), true);
  EXPECT_TRUE(good[0].frame.holds("id"));
  const Diagnosis healthy = examine(good);
  EXPECT_TRUE(healthy.findings.empty()) << text_of(healthy);
  for (const FilterGuideFault& fault : filter_guide_faults()) {
    SCOPED_TRACE(fault.says);
    Pictures pictures = good;
    for (Picture& picture : pictures) fault.put_in(picture.frame);
    const Diagnosis diagnosis = examine(pictures);
    bool found = false;
    for (const Finding& finding : diagnosis.findings) {
      EXPECT_EQ(finding.check, "filter guides") << finding.text;
      found =
          found || (finding.severity == fault.severity && finding.text.find(fault.says) != std::string::npos);
    }
    EXPECT_TRUE(found) << text_of(diagnosis);
  }
}

}  // namespace
}  // namespace ld
