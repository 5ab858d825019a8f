#include "plot/svg_parts.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

namespace ld::svg {

const char* colour(size_t i) {
  constexpr std::array<const char*, 7> colours = {"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                                  "#E69F00", "#56B4E9", "#000000"};
  return colours[i % colours.size()];
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
                 const std::string& more) {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\"{}>{}</text>\n", x, y, anchor, more,
                     escaped(words));
}

std::string line(double x1, double y1, double x2, double y2, const std::string& stroke,
                 const std::string& more) {
  return fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\"{}/>\n", x1,
                     y1, x2, y2, stroke, more);
}

std::string rectangle(double x, double y, double width, double height, const std::string& fill) {
  return fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"{}\"/>\n", x,
                     y, width, height, fill);
}

std::string begin(double width, double height, const std::string& title) {
  return fmt::format(
             "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
             "font-family=\"sans-serif\" font-size=\"13\">\n",
             width, height) +
         rectangle(0, 0, width, height, "#ffffff") +
         text(kLeft, 26, "start", title, " font-size=\"16\" font-weight=\"bold\"");
}

std::string legend(size_t i, const std::string& name) {
  const double y = kTop + 14 + 22 * double(i);
  return rectangle(kWidth - kRight + 16, y - 9, 14, 10, colour(i)) +
         text(kWidth - kRight + 36, y, "start", name);
}

Axis::Axis(bool logarithmic, double low, double high, double from, double to, double floor)
    : logarithmic_(logarithmic), from_(from), to_(to) {
  if (logarithmic) {
    // 1, 2, 5, 10, 20, ...: from the last that is not above `low` to the first that is not below `high`.
    std::vector<double> all;
    for (int exponent = int(std::floor(std::log10(low) + 1e-9)); std::pow(10, exponent) <= 10 * high;
         ++exponent)
      for (const double digit : {1., 2., 5.}) all.push_back(digit * std::pow(10, exponent));
    size_t first = 0;
    while (all[first + 1] <= low * (1 + 1e-9)) ++first;
    size_t last = first + 1;
    while (all[last] < high * (1 - 1e-9)) ++last;
    for (size_t i = first; i <= last; ++i) ticks_.push_back(all[i]);
    low_ = std::log10(ticks_.front());
    high_ = std::log10(ticks_.back());
  } else {
    const double raw = (high - floor) / 5, power = std::pow(10, std::floor(std::log10(raw)));
    const double step = power * (raw / power <= 1 ? 1 : raw / power <= 2 ? 2 : raw / power <= 5 ? 5 : 10);
    const double first = std::floor(floor / step + 1e-9), last = std::ceil(high / step - 1e-9);
    low_ = step * first;
    high_ = step * last;
    for (int i = 0; first + i <= last; ++i) ticks_.push_back(step * (first + i));
  }
}

double Axis::place(double value) const {
  const double v = logarithmic_ ? std::log10(value) : value;
  return from_ + (to_ - from_) * (v - low_) / (high_ - low_);
}

void Axis::keep_values(const std::vector<double>& values) {
  ticks_ = values;
  low_ = logarithmic_ ? std::log10(values.front()) : values.front();
  high_ = logarithmic_ ? std::log10(values.back()) : values.back();
}

}  // namespace ld::svg
