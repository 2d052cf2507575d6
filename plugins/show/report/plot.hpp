// Parts of drawings: scales, axes, symbols of verdicts, arrows, and labels that never overlap.
#pragma once

#include <string>
#include <vector>

#include "artifacts/accuracy.hpp"
#include "show/report/markup.hpp"

namespace plumbline::report {

/// Maps values to pixels of a drawing.
struct Scale {
  double value0 = 0, value1 = 1;  ///< ends of the axis
  double pixel0 = 0, pixel1 = 1;  ///< where they stand
  double operator()(double value) const { return pixel0 + (value - value0) / (value1 - value0) * (pixel1 - pixel0); }
};

/// Multiples of 1, 2 or 5 times a power of ten within [low, high], about `wanted` of them.
std::vector<double> ticks(double low, double high, int wanted);
/// Smallest 1, 2 or 5 times a power of ten that is not below `value`.
double round_up(double value);
/// Largest one that is not above it.
double round_down(double value);
/// The same of a length [m], so that it is round in the units spoken.
double round_length_down(double metres);
/// Decimals that tell such ticks apart.
int decimals_of(const std::vector<double>& ticks);

/// Axis-parallel rectangle [px].
struct Box {
  double left = 0, top = 0, right = 0, bottom = 0;
  bool overlaps(const Box& other) const {
    return left < other.right && other.left < right && top < other.bottom && other.top < bottom;
  }
};

/// Places labels around points: the first free place of eight; a label that fits nowhere is left out.
class LabelPlacer {
 public:
  LabelPlacer(Box area, double font_size) : area_(area), font_size_(font_size) {}
  /// Ground that labels must not cover.
  void block(const Box& box) { taken_.push_back(box); }
  void block_segment(double x0, double y0, double x1, double y1);
  /// Writes the label; false if it was left out. `gap` is the distance from the point to the text.
  bool place(Markup& svg, double x, double y, double gap, const std::string& text, const std::string& css_class);
  /// Writes the label at (x, y), which is the `anchor` (start, middle, end) of its middle line, if that place is free.
  bool place_at(Markup& svg, double x, double y, const char* anchor, const std::string& text,
                const std::string& css_class);

 private:
  Box area_;
  double font_size_;
  std::vector<Box> taken_;
};

/// Opens <svg> with a view box and a description for readers that do not see it.
Scope drawing(Markup& markup, double width, double height, const std::string& description);

void line(Markup& svg, double x0, double y0, double x1, double y1, const std::string& css_class);
void label(Markup& svg, double x, double y, const std::string& text, const std::string& css_class,
           const std::string& anchor);
/// Arrow with a filled head; nothing when shorter than 1.5 px.
void arrow(Markup& svg, double x0, double y0, double x1, double y1, const std::string& css_class);
/// Circle: pass, triangle: undecided, square: fail, cross: not measured. Hollow for control anchors.
void verdict_symbol(Markup& svg, double x, double y, double radius, ToleranceVerdict verdict, bool hollow);

/// Frame, grid and numbers of a chart; `format` turns a tick into text.
struct Axes {
  Scale x, y;
  std::vector<double> x_ticks, y_ticks;
  std::vector<std::string> x_labels, y_labels;
  std::string x_title, y_title;
};
void draw_axes(Markup& svg, const Axes& axes);

/// Verdict as a symbol with its word, for tables and sentences.
void verdict_badge(Markup& html, ToleranceVerdict verdict);
const char* verdict_word(ToleranceVerdict verdict);
const char* verdict_class(ToleranceVerdict verdict);

}  // namespace plumbline::report
