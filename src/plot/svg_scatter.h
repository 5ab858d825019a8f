// A figure of marks: the same error over two costs, side by side.
#pragma once

#include <string>
#include <vector>

namespace ld {

struct ScatterMark {
  std::string name;       // in the legend, beside the mark's number
  std::vector<double> x;  // one for each panel, > 0
  double y = 0;
  bool filled = false;   // else a ring
  bool diamond = false;  // else a disk
};

/// A level that no cost belongs to, drawn across all panels.
struct ScatterLevel {
  std::string name;
  double y = 0;
};

struct ScatterPlot {
  std::string title, y_label, filled_label, hollow_label;  // the last two explain the marks
  std::vector<std::string> x_labels;                       // one for each panel; logarithmic axes
  std::vector<ScatterMark> marks;
  std::vector<ScatterLevel> levels;
};

/// Panels from left to right, the numbered marks in each, the legend at the right. The vertical axis is
/// linear and spans the marks; levels outside it are named in the legend alone. Throws Error where there is
/// nothing to draw or a number does not fit its axis.
std::string to_svg(const ScatterPlot& plot);

}  // namespace ld
