#include "plot/svg_scatter.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "plot/svg_parts.h"

namespace ld {

using namespace svg;

namespace {

constexpr double kPanel = 330, kGap = 34, kLegend = 250, kPlotHeight = 360;

void check(const ScatterPlot& plot) {
  if (plot.marks.empty() || plot.x_labels.empty()) fail("figure '{}' has no marks", plot.title);
  for (const ScatterMark& mark : plot.marks) {
    bool fits = mark.x.size() == plot.x_labels.size() && std::isfinite(mark.y);
    for (const double x : mark.x) fits = fits && std::isfinite(x) && x > 0;
    if (!fits) fail("figure '{}': mark '{}' has a number that its axes cannot show", plot.title, mark.name);
  }
}

/// The axis of y: a little room below and above the marks.
Axis vertical(const std::vector<ScatterMark>& marks, double bottom) {
  const auto [low, high] = std::minmax_element(
      marks.begin(), marks.end(), [](const ScatterMark& a, const ScatterMark& b) { return a.y < b.y; });
  const double span = std::max(high->y - low->y, 0.02 * std::abs(high->y) + 1e-9);
  return Axis(false, low->y, high->y + 0.08 * span, bottom, kTop, low->y - 0.08 * span);
}

std::string shape(const ScatterMark& mark, double x, double y, const std::string& number) {
  const char* stroke = mark.diamond ? colour(1) : colour(0);
  const char* fill = mark.filled ? stroke : "#ffffff";
  std::string svg;
  if (mark.diamond)
    svg = fmt::format(
        "<path d=\"M{0:.1f} {1:.1f} l11 11 l-11 11 l-11 -11 z\" fill=\"{2}\" stroke=\"{3}\" "
        "stroke-width=\"2\"/>\n",
        x, y - 11, fill, stroke);
  else
    svg = fmt::format(
        "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"9\" fill=\"{}\" stroke=\"{}\" stroke-width=\"2\"/>\n", x, y,
        fill, stroke);
  return svg + text(x, y + 4, "middle", number,
                    fmt::format(" font-size=\"11\" fill=\"{}\"", mark.filled ? "#ffffff" : "#000000"));
}

std::string panel(const ScatterPlot& plot, size_t index, const Axis& y, double left, double bottom) {
  double low = plot.marks[0].x[index], high = low;
  for (const ScatterMark& mark : plot.marks) {
    low = std::min(low, mark.x[index]);
    high = std::max(high, mark.x[index]);
  }
  const double right = left + kPanel;
  const Axis x(true, low / 1.15, high * 1.15, left, right);
  std::string svg;
  for (const double tick : x.ticks())
    svg += line(x.place(tick), kTop, x.place(tick), bottom, "#e0e0e0") +
           text(x.place(tick), bottom + 18, "middle", fmt::format("{:g}", tick));
  for (const double tick : y.ticks()) svg += line(left, y.place(tick), right, y.place(tick), "#e0e0e0");
  svg += line(left, bottom, right, bottom, "#000000") + line(left, kTop, left, bottom, "#000000");
  svg += text((left + right) / 2, bottom + 42, "middle", plot.x_labels[index]);
  for (const ScatterLevel& level : plot.levels) {
    const double place = y.place(level.y);
    if (place >= kTop && place <= bottom)
      svg += line(left, place, right, place, "#707070", " stroke-dasharray=\"5 4\"");
  }
  // Those that nothing beats on top.
  for (const bool filled : {false, true})
    for (size_t i = 0; i < plot.marks.size(); ++i)
      if (plot.marks[i].filled == filled)
        svg += shape(plot.marks[i], x.place(plot.marks[i].x[index]), y.place(plot.marks[i].y),
                     fmt::format("{}", i + 1));
  return svg;
}

}  // namespace

std::string to_svg(const ScatterPlot& plot) {
  check(plot);
  const size_t rows = plot.marks.size() + plot.levels.size() + 2;
  const double bottom = kTop + std::max(kPlotHeight, 22.0 * double(rows) + 30);
  const auto panels = double(plot.x_labels.size());
  const double legend_left = kLeft + panels * (kPanel + kGap);
  const Axis y = vertical(plot.marks, bottom);

  std::string svg = begin(legend_left + kLegend, bottom + kBottom, plot.title);
  for (const double tick : y.ticks())
    svg += text(kLeft - 8, y.place(tick) + 4, "end", fmt::format("{:g}", tick));
  svg += text(20, (kTop + bottom) / 2, "middle", plot.y_label,
              fmt::format(" transform=\"rotate(-90 20 {:.1f})\"", (kTop + bottom) / 2));
  for (size_t i = 0; i < plot.x_labels.size(); ++i)
    svg += panel(plot, i, y, kLeft + double(i) * (kPanel + kGap), bottom);

  double row = kTop + 12;
  for (size_t i = 0; i < plot.marks.size(); ++i, row += 22)
    svg += shape(plot.marks[i], legend_left, row, fmt::format("{}", i + 1)) +
           text(legend_left + 18, row + 4, "start", plot.marks[i].name);
  for (const ScatterLevel& level : plot.levels) {
    svg += line(legend_left - 10, row, legend_left + 10, row, "#707070", " stroke-dasharray=\"5 4\"") +
           text(legend_left + 18, row + 4, "start", fmt::format("{}: {:.4g}", level.name, level.y));
    row += 22;
  }
  for (const bool filled : {true, false}) {
    svg += shape({"", {}, 0, filled, false}, legend_left, row, "") +
           text(legend_left + 18, row + 4, "start", filled ? plot.filled_label : plot.hollow_label);
    row += 22;
  }
  return svg + "</svg>\n";
}

}  // namespace ld
