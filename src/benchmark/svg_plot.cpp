#include "benchmark/svg_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.h"

namespace ld {
namespace {

constexpr double kWidth = 720, kHeight = 420, kLeft = 84, kRight = 170, kTop = 44, kBottom = 56;
constexpr double kBarHeight = 34, kBarGap = 16;

// Okabe and Ito's colours, told apart by readers with any colour vision.
constexpr std::array<const char*, 7> kColours = {"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                                 "#E69F00", "#56B4E9", "#000000"};

const char* colour(size_t i) {
  return kColours[i % kColours.size()];
}

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '>')
      result += "&gt;";
    else
      result += c;
  }
  return result;
}

std::string text(double x, double y, const std::string& anchor, const std::string& words,
                 const std::string& more = "") {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\"{}>{}</text>\n", x, y, anchor, more,
                     escaped(words));
}

std::string line(double x1, double y1, double x2, double y2, const std::string& stroke) {
  return fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\"/>\n", x1,
                     y1, x2, y2, stroke);
}

std::string rectangle(double x, double y, double width, double height, const std::string& fill) {
  return fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"{}\"/>\n", x,
                     y, width, height, fill);
}

std::string begin_svg(double height, const std::string& title) {
  return fmt::format(
             "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
             "font-family=\"sans-serif\" font-size=\"13\">\n",
             kWidth, height) +
         rectangle(0, 0, kWidth, height, "#ffffff") +
         text(kLeft, 26, "start", title, " font-size=\"16\" font-weight=\"bold\"");
}

/// Entry i of the legend at the right.
std::string legend(size_t i, const std::string& name) {
  const double y = kTop + 14 + 22 * double(i);
  return rectangle(kWidth - kRight + 16, y - 9, 14, 10, colour(i)) +
         text(kWidth - kRight + 36, y, "start", name);
}

/// Numbers of one axis to places on the picture, and where its ticks are.
class Axis {
 public:
  Axis(bool logarithmic, double low, double high, double from, double to)
      : logarithmic_(logarithmic), from_(from), to_(to) {
    if (logarithmic) {
      // 1, 2, 5, 10, 20, ...: from the last that is not above `low` to the first that is not below `high`.
      std::vector<double> all;
      for (double power = std::pow(10, std::floor(std::log10(low) + 1e-9)); power <= 10 * high; power *= 10)
        for (const double digit : {1., 2., 5.}) all.push_back(digit * power);
      size_t first = 0;
      while (all[first + 1] <= low * (1 + 1e-9)) ++first;
      size_t last = first + 1;
      while (all[last] < high * (1 - 1e-9)) ++last;
      for (size_t i = first; i <= last; ++i) ticks_.push_back(all[i]);
      low_ = std::log10(ticks_.front());
      high_ = std::log10(ticks_.back());
    } else {
      low_ = 0;
      const double raw = high / 5, power = std::pow(10, std::floor(std::log10(raw)));
      const double step = power * (raw / power <= 1 ? 1 : raw / power <= 2 ? 2 : raw / power <= 5 ? 5 : 10);
      high_ = step * std::ceil(high / step - 1e-9);
      for (int i = 0; step * i <= high_ * (1 + 1e-9); ++i) ticks_.push_back(step * i);
    }
  }
  double place(double value) const {
    const double v = logarithmic_ ? std::log10(value) : value;
    return from_ + (to_ - from_) * (v - low_) / (high_ - low_);
  }
  void keep_values(const std::vector<double>& values) {  // ticks at the values themselves
    ticks_ = values;
    low_ = logarithmic_ ? std::log10(values.front()) : values.front();
    high_ = logarithmic_ ? std::log10(values.back()) : values.back();
  }
  const std::vector<double>& ticks() const { return ticks_; }

 private:
  bool logarithmic_;
  double from_, to_, low_ = 0, high_ = 1;
  std::vector<double> ticks_;
};

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

  std::string svg = begin_svg(kHeight, plot.title);
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

  std::string svg = begin_svg(bottom + kBottom, plot.title);
  for (const double tick : x.ticks()) {
    svg += line(x.place(tick), kTop, x.place(tick), bottom, "#e0e0e0");
    svg += text(x.place(tick), bottom + 18, "middle", fmt::format("{:g}", tick));
  }
  svg += text((left + right) / 2, bottom + 42, "middle", plot.x_label);
  for (size_t b = 0; b < plot.bars.size(); ++b) {
    const double top = kTop + kBarGap + double(b) * (kBarHeight + kBarGap);
    svg += text(left - 8, top + kBarHeight / 2 + 4, "end", plot.bars[b].name);
    double begin = 0;
    for (size_t p = 0; p < plot.parts.size(); ++p) {
      const double end = begin + plot.bars[b].parts[p];
      svg += rectangle(x.place(begin), top, x.place(end) - x.place(begin), kBarHeight, colour(p));
      begin = end;
    }
  }
  svg += line(left, kTop, left, bottom, "#000000");
  for (size_t p = 0; p < plot.parts.size(); ++p) svg += legend(p, plot.parts[p]);
  return svg + "</svg>\n";
}

}  // namespace ld
