// What figures are made of: SVG elements as text, numbered axes, a legend.
#pragma once

#include <string>
#include <vector>

namespace ld::svg {

constexpr double kWidth = 720, kHeight = 420, kLeft = 84, kRight = 170, kTop = 44, kBottom = 56;

/// Colour i of Okabe and Ito's, told apart by readers with any colour vision.
const char* colour(size_t i);

std::string escaped(const std::string& text);

/// `anchor`: start, middle or end; `more`: further attributes, each with a space before it.
std::string text(double x, double y, const std::string& anchor, const std::string& words,
                 const std::string& more = "");
std::string line(double x1, double y1, double x2, double y2, const std::string& stroke,
                 const std::string& more = "");
std::string rectangle(double x, double y, double width, double height, const std::string& fill);

/// The opening tag, a white ground and the title; "</svg>" ends it.
std::string begin(double width, double height, const std::string& title);

/// Entry i of a legend at the right of a figure of kWidth.
std::string legend(size_t i, const std::string& name);

/// Numbers of one axis to places on the picture, and where its ticks are.
class Axis {
 public:
  /// Places `low` at or after `from` and `high` at or before `to`, between round numbers; a linear axis
  /// starts at 0 unless `floor` says where.
  Axis(bool logarithmic, double low, double high, double from, double to, double floor = 0);

  double place(double value) const;
  /// Ticks at the values themselves, which are sorted.
  void keep_values(const std::vector<double>& values);
  const std::vector<double>& ticks() const { return ticks_; }

 private:
  bool logarithmic_;
  double from_, to_, low_ = 0, high_ = 1;
  std::vector<double> ticks_;
};

}  // namespace ld::svg
