#include "plot/svg_plot.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/benchmark/xml_check.h"
#include "tests/support/expect_error.h"

namespace ld {
namespace {

size_t count(const std::string& text, const std::string& part) {
  size_t found = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

LinePlot two_lines() {
  return {"Cost & <time>", "samples", "ms", true, true, {{"a<b", {{1, 10}, {8, 100}}}, {"c", {{1, 20}}}}};
}

TEST(SvgPlot, LinesAreWellFormedXmlWithEveryPoint) {
  const std::string svg = to_svg(two_lines());
  EXPECT_EQ(xml_fault(svg), "");
  EXPECT_EQ(count(svg, "<polyline"), 2);
  EXPECT_EQ(count(svg, "<circle"), 3);
  EXPECT_EQ(count(svg, "Cost &amp; &lt;time&gt;"), 1);
  EXPECT_EQ(count(svg, "a&lt;b"), 1);
}

TEST(SvgPlot, ALogarithmicAxisPlacesDecadesEvenly) {
  LinePlot plot{"t", "x", "y", true, true, {{"a", {{1, 1}, {10, 10}, {100, 100}}}}};
  const std::string svg = to_svg(plot);
  // 84 to 550 in x, 364 to 44 in y: the middle point is the mean of the others.
  EXPECT_EQ(count(svg, "points=\"84.0,364.0 317.0,204.0 550.0,44.0\""), 1) << svg;
  plot.log_x = plot.log_y = false;
  EXPECT_EQ(count(to_svg(plot), "317.0,204.0"), 0);
}

TEST(SvgPlot, BarsAreWellFormedXmlWithLengthsInProportion) {
  const std::string svg = to_svg(BarPlot{"t", "ms", {"one", "two"}, {{"a", {1, 3}}, {"b", {0, 2}}}});
  EXPECT_EQ(xml_fault(svg), "");
  EXPECT_EQ(count(svg, "width=\"106.5\""), 1) << svg;  // 1 of 4 over 426 pixels
  EXPECT_EQ(count(svg, "width=\"319.5\""), 1);
  EXPECT_EQ(count(svg, "width=\"213.0\""), 1);
}

TEST(SvgPlot, WhatCannotBeDrawnIsAnError) {
  LinePlot plot = two_lines();
  plot.lines[0].points[0].second = 0;
  EXPECT_ERROR(to_svg(plot), "has a point (1, 0) that its axes cannot show");
  plot.lines.clear();
  EXPECT_ERROR(to_svg(plot), "has no points");
  EXPECT_ERROR(to_svg(BarPlot{"t", "ms", {"one"}, {}}), "has no bars");
  EXPECT_ERROR(to_svg(BarPlot{"t", "ms", {"one"}, {{"a", {1, 2}}}}), "has 2 parts, expected 1");
  EXPECT_ERROR(to_svg(BarPlot{"t", "ms", {"one"}, {{"a", {-1}}}}), "has a part of -1");
}

TEST(SvgPlot, TheCheckerSeesFaults) {
  EXPECT_EQ(xml_fault("<a><b x=\"1\"/>t &amp; u</a>\n"), "");
  for (const char* bad : {"<a>", "<a></b>", "<a>&</a>", "<a>< b</a>", "<a/><b/>", "<a b=1/>", "", "<a/>x"})
    EXPECT_NE(xml_fault(bad), "") << bad;
}

}  // namespace
}  // namespace ld
