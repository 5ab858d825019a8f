// Figures as SVG text: lines over numbered axes, and stacked bars.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace ld {

struct PlotLine {
  std::string name;                               // in the legend
  std::vector<std::pair<double, double>> points;  // x, y; > 0 on a logarithmic axis
};

struct LinePlot {
  std::string title, x_label, y_label;
  bool log_x = false, log_y = false;  // linear axes start at 0
  std::vector<PlotLine> lines;
};

struct Bar {
  std::string name;
  std::vector<double> parts;  // one for each name of BarPlot::parts, >= 0
};

struct BarPlot {
  std::string title, x_label;
  std::vector<std::string> parts;  // in the legend
  std::vector<Bar> bars;           // lying, from top to bottom
};

/// Texts are escaped. Throws Error where there is nothing to draw or a number does not fit its axis.
std::string to_svg(const LinePlot& plot);
std::string to_svg(const BarPlot& plot);

}  // namespace ld
