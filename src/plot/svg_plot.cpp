#include "plot/svg_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "plot/svg_parts.h"

namespace ld {

using namespace svg;

namespace {

constexpr double kBarHeight = 34, kBarGap = 16;

/// All x and all y of the lines, sorted, without repeats.
std::pair<std::vector<double>, std::vector<double>> numbers(const LinePlot& plot) {
  std::pair<std::vector<double>, std::vector<double>> all;
  for (const PlotLine& series : plot.lines)
    for (const auto& [x, y] : series.points) {
      if (!std::isfinite(x) || !std::isfinite(y) || x < 0 || y < 0 || (plot.log_x && x == 0) ||
          (plot.log_y && y == 0))
        fail("figure '{}': {} has a point ({}, {}) that its axes cannot show", plot.title, series.name, x, y);
      all.first.push_back(x);
      all.second.push_back(y);
    }
  if (all.first.empty()) fail("figure '{}' has no points", plot.title);
  for (std::vector<double>* values : {&all.first, &all.second}) {
    std::sort(values->begin(), values->end());
    values->erase(std::unique(values->begin(), values->end()), values->end());
    if (values->back() == 0) fail("figure '{}' has nothing but zeros on an axis", plot.title);
  }
  return all;
}

}  // namespace

std::string to_svg(const LinePlot& plot) {
  const auto [xs, ys] = numbers(plot);
  const double right = kWidth - kRight, bottom = kHeight - kBottom;
  Axis x(plot.log_x, xs.front(), xs.back(), kLeft, right);
  const Axis y(plot.log_y, ys.front(), ys.back(), bottom, kTop);
  if (xs.size() > 1 && xs.size() <= 12) x.keep_values(xs);  // sample counts and the like

  std::string svg = begin(kWidth, kHeight, plot.title);
  for (const double tick : x.ticks()) {
    svg += line(x.place(tick), kTop, x.place(tick), bottom, "#e0e0e0");
    svg += text(x.place(tick), bottom + 18, "middle", fmt::format("{:g}", tick));
  }
  for (const double tick : y.ticks()) {
    svg += line(kLeft, y.place(tick), right, y.place(tick), "#e0e0e0");
    svg += text(kLeft - 8, y.place(tick) + 4, "end", fmt::format("{:g}", tick));
  }
  svg += line(kLeft, bottom, right, bottom, "#000000") + line(kLeft, kTop, kLeft, bottom, "#000000");
  svg += text((kLeft + right) / 2, kHeight - 14, "middle", plot.x_label);
  svg += text(20, (kTop + bottom) / 2, "middle", plot.y_label,
              fmt::format(" transform=\"rotate(-90 20 {:.1f})\"", (kTop + bottom) / 2));
  for (size_t i = 0; i < plot.lines.size(); ++i) {
    std::string path, dots;
    for (const auto& [px, py] : plot.lines[i].points) {
      path += fmt::format("{}{:.1f},{:.1f}", path.empty() ? "" : " ", x.place(px), y.place(py));
      dots += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3\" fill=\"{}\"/>\n", x.place(px),
                          y.place(py), colour(i));
    }
    svg += fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\"{}/>\n", path,
                       colour(i), i % 2 == 1 ? " stroke-dasharray=\"6 4\"" : "");  // one may cover another
    svg += dots + legend(i, plot.lines[i].name);
  }
  return svg + "</svg>\n";
}

std::string to_svg(const BarPlot& plot) {
  double longest = 0;
  for (const Bar& bar : plot.bars) {
    double length = 0;
    if (bar.parts.size() != plot.parts.size())
      fail("figure '{}': bar {} has {} parts, expected {}", plot.title, bar.name, bar.parts.size(),
           plot.parts.size());
    for (const double part : bar.parts) {
      if (!(part >= 0) || !std::isfinite(part))
        fail("figure '{}': bar {} has a part of {}, expected a length", plot.title, bar.name, part);
      length += part;
    }
    longest = std::max(longest, length);
  }
  if (longest == 0) fail("figure '{}' has no bars", plot.title);
  const double right = kWidth - kRight, left = kLeft + 40;
  const double bottom = kTop + std::max(double(plot.bars.size()) * (kBarHeight + kBarGap) + kBarGap,
                                        22 * double(plot.parts.size()) + 10);
  const Axis x(false, 0, longest, left, right);

  std::string svg = begin(kWidth, bottom + kBottom, plot.title);
  for (const double tick : x.ticks()) {
    svg += line(x.place(tick), kTop, x.place(tick), bottom, "#e0e0e0");
    svg += text(x.place(tick), bottom + 18, "middle", fmt::format("{:g}", tick));
  }
  svg += text((left + right) / 2, bottom + 42, "middle", plot.x_label);
  for (size_t b = 0; b < plot.bars.size(); ++b) {
    const double top = kTop + kBarGap + double(b) * (kBarHeight + kBarGap);
    svg += text(left - 8, top + kBarHeight / 2 + 4, "end", plot.bars[b].name);
    double from = 0;
    for (size_t p = 0; p < plot.parts.size(); ++p) {
      const double to = from + plot.bars[b].parts[p];
      svg += rectangle(x.place(from), top, x.place(to) - x.place(from), kBarHeight, colour(p));
      from = to;
    }
  }
  svg += line(left, kTop, left, bottom, "#000000");
  for (size_t p = 0; p < plot.parts.size(); ++p) svg += legend(p, plot.parts[p]);
  return svg + "</svg>\n";
}

}  // namespace ld
