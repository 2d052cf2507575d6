#include "show/report/plot.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "show/report/format.hpp"

namespace plumbline::report {

double round_up(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double factor : {1.0, 2.0, 5.0, 10.0})
    if (factor * power >= value * (1 - 1e-12)) return factor * power;
  return 10 * power;
}

double round_down(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double factor : {10.0, 5.0, 2.0})
    if (factor * power <= value * (1 + 1e-12)) return factor * power;
  return power;
}

std::vector<double> ticks(double low, double high, int wanted) {
  const double step = round_up((high - low) / wanted);
  std::vector<double> values;
  const auto first = static_cast<long>(std::ceil(low / step - 1e-9));
  const auto last = static_cast<long>(std::floor(high / step + 1e-9));
  for (long i = first; i <= last; ++i) values.push_back(static_cast<double>(i) * step);
  return values;
}

double round_length_down(double metres) { return round_down(in_units(metres)) / in_units(1); }

int decimals_of(const std::vector<double>& ticks) {
  if (ticks.size() < 2) return 0;
  return std::max(0, static_cast<int>(-std::floor(std::log10(ticks[1] - ticks[0]) + 1e-9)));
}

namespace {

/// Characters, not bytes.
double character_count(const std::string& text) {
  return static_cast<double>(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

struct Candidate {
  double x, y;         // direction from the point
  const char* anchor;  // text-anchor
};
constexpr std::array<Candidate, 8> candidates = {{{1, 0, "start"},
                                                  {-1, 0, "end"},
                                                  {0.7, -0.9, "start"},
                                                  {-0.7, -0.9, "end"},
                                                  {0.7, 0.9, "start"},
                                                  {-0.7, 0.9, "end"},
                                                  {0, -1.4, "middle"},
                                                  {0, 1.4, "middle"}}};

}  // namespace

void LabelPlacer::block_segment(double x0, double y0, double x1, double y1) {
  const double length = std::hypot(x1 - x0, y1 - y0);
  const int pieces = std::max(1, static_cast<int>(length / 4));
  for (int i = 0; i < pieces; ++i) {
    const double a = i / static_cast<double>(pieces), b = (i + 1) / static_cast<double>(pieces);
    const double xa = x0 + a * (x1 - x0), xb = x0 + b * (x1 - x0), ya = y0 + a * (y1 - y0), yb = y0 + b * (y1 - y0);
    block({std::min(xa, xb) - 1, std::min(ya, yb) - 1, std::max(xa, xb) + 1, std::max(ya, yb) + 1});
  }
}

bool LabelPlacer::place_at(Markup& svg, double x, double y, const char* anchor_name, const std::string& text,
                           const std::string& css_class) {
  // 0.62 em is the widest average of the fonts the style names.
  const double width = 0.62 * font_size_ * character_count(text), height = 1.1 * font_size_;
  const std::string anchor = anchor_name;
  const double left = anchor == "start" ? x : anchor == "end" ? x - width : x - 0.5 * width;
  const Box box{left, y - 0.5 * height, left + width, y + 0.5 * height};
  if (box.left < area_.left || box.right > area_.right || box.top < area_.top || box.bottom > area_.bottom)
    return false;
  if (std::any_of(taken_.begin(), taken_.end(), [&](const Box& other) { return other.overlaps(box); })) return false;
  taken_.push_back(box);
  label(svg, x, y + 0.35 * font_size_, text, css_class, anchor);
  return true;
}

bool LabelPlacer::place(Markup& svg, double x, double y, double gap, const std::string& text,
                        const std::string& css_class) {
  return std::any_of(candidates.begin(), candidates.end(), [&](const Candidate& c) {
    return place_at(svg, x + c.x * gap, y + c.y * gap, c.anchor, text, css_class);
  });
}

Scope drawing(Markup& markup, double width, double height, const std::string& description) {
  return Scope(markup, "svg",
               {{"viewBox", "0 0 " + px(width) + " " + px(height)},
                {"width", px(width)},
                {"height", px(height)},
                {"role", "img"},
                {"aria-label", description}});
}

void line(Markup& svg, double x0, double y0, double x1, double y1, const std::string& css_class) {
  svg.empty("line", {{"class", css_class}, {"x1", px(x0)}, {"y1", px(y0)}, {"x2", px(x1)}, {"y2", px(y1)}});
}

void label(Markup& svg, double x, double y, const std::string& text, const std::string& css_class,
           const std::string& anchor) {
  svg.element("text", {{"class", css_class}, {"x", px(x)}, {"y", px(y)}, {"text-anchor", anchor}}, text);
}

void arrow(Markup& svg, double x0, double y0, double x1, double y1, const std::string& css_class) {
  const double length = std::hypot(x1 - x0, y1 - y0);
  if (!(length >= 1.5)) return;
  const double ux = (x1 - x0) / length, uy = (y1 - y0) / length;
  const double head = std::min(7.0, 0.6 * length);
  const double bx = x1 - head * ux, by = y1 - head * uy;  // base of the head
  line(svg, x0, y0, bx, by, css_class + " shaft");
  svg.empty("polygon",
            {{"class", css_class + " head"},
             {"points", px(x1) + "," + px(y1) + " " + px(bx - 0.45 * head * uy) + "," + px(by + 0.45 * head * ux) +
                            " " + px(bx + 0.45 * head * uy) + "," + px(by - 0.45 * head * ux)}});
}

void verdict_symbol(Markup& svg, double x, double y, double radius, ToleranceVerdict verdict, bool hollow) {
  const std::string css = std::string("symbol ") + verdict_class(verdict) + (hollow ? " hollow" : "");
  const double r = radius;
  switch (verdict) {
    case ToleranceVerdict::pass:
      svg.empty("circle", {{"class", css}, {"cx", px(x)}, {"cy", px(y)}, {"r", px(r)}});
      return;
    case ToleranceVerdict::fail:
      svg.empty("rect",
                {{"class", css}, {"x", px(x - r)}, {"y", px(y - r)}, {"width", px(2 * r)}, {"height", px(2 * r)}});
      return;
    case ToleranceVerdict::undecided:
      svg.empty("polygon", {{"class", css},
                            {"points", px(x) + "," + px(y - 1.25 * r) + " " + px(x + 1.15 * r) + "," + px(y + 0.8 * r) +
                                           " " + px(x - 1.15 * r) + "," + px(y + 0.8 * r)}});
      return;
    case ToleranceVerdict::not_measured:
      svg.empty("path", {{"class", css + " open"},
                         {"d", "M" + px(x - r) + " " + px(y - r) + "L" + px(x + r) + " " + px(y + r) + "M" + px(x - r) +
                                   " " + px(y + r) + "L" + px(x + r) + " " + px(y - r)}});
      return;
  }
}

void draw_axes(Markup& svg, const Axes& axes) {
  const double left = axes.x.pixel0, right = axes.x.pixel1, bottom = axes.y.pixel0, top = axes.y.pixel1;
  for (std::size_t i = 0; i < axes.y_ticks.size(); ++i) {
    const double y = axes.y(axes.y_ticks[i]);
    line(svg, left, y, right, y, "grid");
    label(svg, left - 8, y + 4, axes.y_labels[i], "tick", "end");
  }
  for (std::size_t i = 0; i < axes.x_ticks.size(); ++i) {
    const double x = axes.x(axes.x_ticks[i]);
    line(svg, x, bottom, x, bottom + 5, "axis");
    label(svg, x, bottom + 19, axes.x_labels[i], "tick", "middle");
  }
  line(svg, left, bottom, right, bottom, "axis");
  if (!axes.x_title.empty()) label(svg, 0.5 * (left + right), bottom + 39, axes.x_title, "axis-title", "middle");
  label(svg, left - 44, top - 14, axes.y_title, "axis-title", "start");
}

const char* verdict_word(ToleranceVerdict verdict) {
  switch (verdict) {
    case ToleranceVerdict::pass:
      return "pass";
    case ToleranceVerdict::fail:
      return "fail";
    case ToleranceVerdict::undecided:
      return "undecided";
    case ToleranceVerdict::not_measured:
      break;
  }
  return "not measured";
}

const char* verdict_class(ToleranceVerdict verdict) {
  switch (verdict) {
    case ToleranceVerdict::pass:
      return "pass";
    case ToleranceVerdict::fail:
      return "fail";
    case ToleranceVerdict::undecided:
      return "undecided";
    case ToleranceVerdict::not_measured:
      break;
  }
  return "unmeasured";
}

void verdict_badge(Markup& html, ToleranceVerdict verdict) {
  Scope badge(html, "span", {{"class", std::string("badge ") + verdict_class(verdict)}});
  {
    Scope svg(html, "svg", {{"viewBox", "0 0 12 12"}, {"width", "12"}, {"height", "12"}, {"aria-hidden", "true"}});
    verdict_symbol(html, 6, 6.4, 4.8, verdict, false);
  }
  html.text(verdict_word(verdict));
}

}  // namespace plumbline::report
