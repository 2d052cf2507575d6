// A drawing of lines, dots and words that can be written as SVG (for pages) and as PDF (for papers).
#pragma once

#include <string>
#include <vector>

namespace plumbline::bench {

/// Lengths in points, y downwards. Colours are "#rrggbb"; empty: that of the text around it.
struct Drawing {
  struct Line {
    double x1, y1, x2, y2, width;
    std::string colour;
  };
  struct Dot {
    double x, y, radius;
    std::string colour;
    std::string title;  ///< told where the pointer rests
  };
  enum class Anchor { start, middle, end };
  struct Word {
    double x, y, size;
    std::string text;  ///< UTF-8
    Anchor anchor = Anchor::start;
    bool strong = false;
  };
  double width = 0, height = 0;
  std::vector<Line> lines;
  std::vector<Dot> dots;
  std::vector<Word> words;

  /// Puts another one below.
  void append(const Drawing& other);
};

/// As a file, or as a part of a page, which needs no name space.
enum class Svg { file, inlined };
std::string to_svg(const Drawing& drawing, Svg form);

/// One page of the drawing's size, PDF 1.4 with Helvetica. Characters that Windows-1252 lacks become '?'.
std::string to_pdf(const Drawing& drawing);

}  // namespace plumbline::bench
