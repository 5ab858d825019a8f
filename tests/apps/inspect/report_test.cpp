// What ld_inspect's report says of warnings, and of parts whose names are wrong.
#include <gtest/gtest.h>

#include "apps/inspect/inspect.h"
#include "tests/apps/inspect/problems.h"
#include "tests/support/expect_error.h"
#include "tests/support/exr_parts.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_dataset.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

TEST(Inspect, WarningsAreCountedInPlaceOfNothing) {
  Report good, several;
  EXPECT_NE(report_text(good).find("  nothing is wrong with it\n"), std::string::npos);
  good.warnings = {"a"};
  EXPECT_NE(report_text(good).find("  warning: a\n  no problem, 1 warning\n"), std::string::npos);
  EXPECT_EQ(report_text(good).find("nothing is wrong"), std::string::npos);
  several.warnings = {"a", "b"};
  EXPECT_NE(report_text(several).find("  no problem, 2 warnings\n"), std::string::npos);
  several.problems = {"c"};
  EXPECT_EQ(report_text(several).find("no problem"), std::string::npos);
}

TEST(Inspect, PartsThatAreNamedAlmostAsSamples) {
  const TemporaryFolder folder;
  const auto write = [&](const fs::path& path, const std::vector<std::string>& names) {
    std::vector<TestPart> parts;
    for (const std::string& name : names)
      parts.push_back({name,
                       {{0, 0}, {3, 2}},
                       {{"R", everywhere(0.5F)}, {"G", everywhere(0.5F)}, {"B", everywhere(0.5F)}}});
    write_exr_parts(path, {{0, 0}, {3, 2}}, parts);
  };
  for (const char* name : {"s0", "s01", "S000", "s_000", "sample0", "Sample.0001", "s000000"}) {
    write(folder / "frame.exr", {"mean", name});
    expect_problem(folder / "frame.exr", fmt::format("part '{}' looks like a sample", name));
    expect_problem(folder / "frame.exr", "named s000, s001, ..., with three digits or more");
  }
  for (const char* name : {"s", "shadow0", "specular1", "N0", "0"}) {
    write(folder / "frame.exr", {"mean", name});
    EXPECT_EQ(problems(folder / "frame.exr"), "") << name;
  }
  // In a data set, and for whoever trains on it.
  write_tiny_dataset(folder / "data", 2, 8, 2);
  write(frame_path(folder / "data", "frame_1"), {"mean", "s0", "s1"});
  expect_problem(folder / "data", "frame_1.exr: no samples: part 's0' looks like a sample");
  Faults faults;
  EXPECT_ERROR(read_frame(frame_path(folder / "data", "frame_1"), {}, faults),
               "frame_1.exr: no samples: part 's0' looks like a sample");
}

}  // namespace
}  // namespace ld
