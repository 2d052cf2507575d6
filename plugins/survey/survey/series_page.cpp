// The page of a series: a table of what is to be said, and a chart of each point over time. In English; what is a name
// says translate="no", so that report.words leaves it as it is.
#include <algorithm>
#include <cmath>

#include "base/text/xml_text.hpp"
#include "series_files.hpp"
#include "survey/words/network_words.hpp"

namespace plumbline::survey {

namespace {

using text::xml_escaped;

constexpr const char* kStyle =
    "body{font:15px/1.45 system-ui,sans-serif;max-width:70rem;margin:2rem auto;padding:0 1rem;color:#1a1a1a}"
    ".wide{overflow-x:auto}table{border-collapse:collapse;margin:1rem 0}td,th{padding:.2rem "
    ".7rem;text-align:right;border-bottom:1px solid "
    "#ddd}td:first-child,th:first-child,.l{text-align:left}.box{border-left:6px solid #2a7d3f;padding:.6rem 1rem;"
    "background:#f2f7f3}.box.bad{border-color:#b3261e;background:#fbf1f0}section{margin:2rem 0;break-inside:avoid}"
    "svg{max-width:100%;height:auto}.n{color:#555}@media print{section{break-before:page}}";
constexpr const char* kColours[] = {"#1f5fa8", "#2a7d3f", "#b3261e"};
/// Of an element that holds a name: report.words leaves it.
constexpr const char* kAsItIs = " translate=\"no\"";

std::string place_in_chart(double value) { return fixed_digits(value, 1); }

/// Movement in E, N, H over time with bars of two standard deviations, the line that was fitted, and the levels.
class Chart {
 public:
  Chart(const SeriesPoint& p, const SeriesText& text) : p_(p), text_(text) {
    for (const auto& at : p.at)
      for (int k = 0; k < 3; ++k)
        if (std::isfinite(at.movement[k]))
          reach_ = std::max(reach_, 1000 * (std::abs(at.movement[k]) + 2 * at.sigma[k]));
    // A level that is far beyond what moved would flatten the chart: it is drawn where it is within three times that.
    for (const double level : {text.options.warning_level, text.options.alarm_level})
      if (1000 * level < 3 * reach_) reach_ = std::max(reach_, 1000 * level);
    reach_ *= 1.1;
  }

  std::string svg() const {
    std::string out = "<svg viewBox=\"0 0 760 240\" role=\"img\" aria-label=\"movement of " + xml_escaped(p_.id) +
                      " over time\"><rect x=\"60\" y=\"10\" width=\"640\" height=\"200\" fill=\"none\" "
                      "stroke=\"#bbb\"/>";
    for (const double v : {-reach_ / 1.1, 0.0, reach_ / 1.1})
      out += line(60, y(v), 700, y(v), "#ddd", "") + label(54, y(v) + 5, fixed_digits(v, 1), "end");
    out += label(8, 60, "mm", "start") + level(text_.options.warning_level, "warning level", "#b26a00") +
           level(text_.options.alarm_level, "alarm level", "#b3261e");
    for (size_t k = p_.first; k < text_.times.size(); ++k)
      out += line(x(text_.times[k]), 210, x(text_.times[k]), 215, "#888", "");
    // Names of epochs that would overlap are left out; the first and the last are there.
    constexpr double kWidth = 90;
    double free_from = 0;
    const double last = x(text_.times.back());
    for (size_t k = p_.first; k < text_.times.size(); ++k) {
      const double at = x(text_.times[k]);
      const bool is_first = k == p_.first, is_last = k + 1 == text_.times.size();
      if (!is_first && !is_last && (at - kWidth / 2 < free_from || at + kWidth / 2 > last - kWidth)) continue;
      out += label(at, 230, text_.labels[k], is_first ? "start" : is_last ? "end" : "middle", kAsItIs);
      free_from = at + (is_first ? kWidth : kWidth / 2);
    }
    for (int k = 0; k < 3; ++k) out += component(k);
    return out + "</svg>";
  }

 private:
  std::string level(double metres, const char* name, const char* colour) const {
    const double v = 1000 * metres;
    if (!(v > 0) || v > reach_) return "";
    return line(60, y(v), 700, y(v), colour, "2 3") + line(60, y(-v), 700, y(-v), colour, "2 3") +
           label(696, y(v) - 3, name, "end");
  }
  double x(double time) const {
    const double first = text_.times.front(), last = text_.times.back();
    return 70 + 620 * (time - first) / std::max(1e-12, last - first);
  }
  double y(double millimetres) const { return 110 - 100 * millimetres / reach_; }
  static std::string line(double x1, double y1, double x2, double y2, const char* colour, const char* dash) {
    return "<line x1=\"" + place_in_chart(x1) + "\" y1=\"" + place_in_chart(y1) + "\" x2=\"" + place_in_chart(x2) +
           "\" y2=\"" + place_in_chart(y2) + "\" stroke=\"" + colour + "\"" +
           (*dash ? " stroke-dasharray=\"" + std::string(dash) + "\"" : "") + "/>";
  }
  static std::string label(double at_x, double at_y, const std::string& text, const char* anchor,
                           const char* more = "") {
    return "<text x=\"" + place_in_chart(at_x) + "\" y=\"" + place_in_chart(at_y) +
           "\" font-size=\"12\" text-anchor=\"" + anchor + "\"" + more + ">" + xml_escaped(text) + "</text>";
  }
  std::string component(int k) const {
    const double from = text_.times[p_.reference[k]];
    const char* colour = kColours[k];
    std::string path = "M" + place_in_chart(x(from)) + " " + place_in_chart(y(0)), marks;
    for (const auto& at : p_.at) {
      if (!std::isfinite(at.movement[k])) continue;
      const double shift = 3 * (k - 1), t = x(text_.times[at.epoch]) + shift, v = 1000 * at.movement[k],
                   s = 2000 * at.sigma[k];
      path += " L" + place_in_chart(t) + " " + place_in_chart(y(v));
      marks += line(t, y(v - s), t, y(v + s), colour, "") + "<circle cx=\"" + place_in_chart(t) + "\" cy=\"" +
               place_in_chart(y(v)) + "\" r=\"3\" fill=\"" + colour + "\"/>";
    }
    if (marks.empty()) return "";
    std::string out = "<path d=\"" + path + "\" fill=\"none\" stroke=\"" + colour + "\"/>" + marks;
    if (p_.moves && std::isfinite(p_.velocity[k])) {
      const double to = text_.times.back();
      out += line(x(from), y(0), x(to), y(1000 * p_.velocity[k] * (to - from)), colour, "5 4");
    }
    return out + "<text x=\"" + std::to_string(710) + "\" y=\"" + std::to_string(40 + 20 * k) +
           "\" font-size=\"13\" fill=\"" + colour + "\"" + kAsItIs + ">" + std::string(1, "ENH"[k]) + "</text>";
  }

  const SeriesPoint& p_;
  const SeriesText& text_;
  double reach_ = 0.1;  ///< [mm]
};

/// Of the part of the page that a point has for itself; printed, it is a sheet.
std::string anchor_of(const SeriesPoint& p) {
  std::string id = "point-" + xml_escaped(p.id);
  std::replace(id.begin(), id.end(), ' ', '_');
  return id;
}

/// `first`: of the first cell, which holds a name.
std::string html_row(const std::vector<std::string>& cells, const char* tag, const char* first = "") {
  std::string out = "<tr>";
  for (size_t i = 0; i < cells.size(); ++i)
    out += "<" + std::string(tag) + (i == 0 ? first : "") + ">" + xml_escaped(cells[i]) + "</" + std::string(tag) + ">";
  return out + "</tr>";
}

std::string movements_of(const SeriesPoint& p, const SeriesText& text) {
  std::string out =
      "<div class=\"wide\"><table>" +
      html_row({"Epoch", "dE [mm]", "dN [mm]", "dH [mm]", "\u03c3E", "\u03c3N", "\u03c3H", "Test", "Critical"}, "th");
  const auto cell = [](double v) { return std::isfinite(v) ? fixed_digits(1000 * v, 2) : std::string("\u2013"); };
  for (const auto& at : p.at)
    out += html_row(
        {text.labels[at.epoch], cell(at.movement.x()), cell(at.movement.y()), cell(at.movement.z()), cell(at.sigma.x()),
         cell(at.sigma.y()), cell(at.sigma.z()), fixed_digits(at.statistic, 1), fixed_digits(at.critical, 1)},
        "td", kAsItIs);
  return out + "</table></div>";
}

}  // namespace

std::string series_as_html(const EpochSeries& s, const SeriesText& text) {
  constexpr size_t kAllShown = 60;  // of points nothing is to be said of
  std::vector<const SeriesPoint*> quiet;
  const std::vector<const SeriesPoint*> told = points_told(s, text, quiet);
  std::string out =
      "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width\"><title>Series of epochs</title><style>" +
      std::string(kStyle) + "</style></head><body><h1>Series of " + std::to_string(text.labels.size()) + " epochs</h1>";
  out += "<div class=\"box" + std::string(told.empty() ? "" : " bad") + "\"><strong>" +
         how_many_move(told.size(), text) + "</strong>";
  if (!told.empty()) {
    out += "<ul>";
    for (const SeriesPoint* p : told)
      out += "<li><a href=\"#" + anchor_of(*p) + "\"" + kAsItIs + ">" + xml_escaped(p->id) + "</a>: <span>" +
             xml_escaped(told_of(*p, text)) + "</span></li>";
    out += "</ul>";
  }
  out += "</div>";
  if (!s.not_followed.empty()) {
    out += "<div class=\"box bad\"><ul>";
    for (const std::string& words : s.not_followed) out += "<li>" + xml_escaped(words) + "</li>";
    out += "</ul></div>";
  }
  out += "<p>" + xml_escaped(order_words(text)) + "</p><p>Of the epochs: " + xml_escaped(s.variances) + ".</p><p>" +
         xml_escaped(datum_words(s, text)) + "</p>";
  if (!s.contradicted.empty())
    out += "<div class=\"box bad\"><strong>Of them moved, against most other points: " +
           xml_escaped(join(s.contradicted, 20)) +
           "</strong><p>All movements below are against these points as if they had not.</p></div>";
  if (!s.not_compared.empty()) {
    out += "<div class=\"box bad\"><strong>Held or missing in an epoch:</strong><ul>";
    for (const std::string& words : s.not_compared) out += "<li>" + xml_escaped(words) + "</li>";
    out += "</ul></div>";
  }
  for (const std::string& words : text.notes) out += "<p>Note: " + xml_escaped(words) + ".</p>";
  if (!s.seen_once.empty())
    out += "<p class=\"n\">Not compared (seen in one epoch only, or held without error): " +
           xml_escaped(join(s.seen_once, 20)) + ".</p>";
  out +=
      "<p class=\"n\">Movements are against the first epoch that measured the coordinate, bars are two standard "
      "deviations; a broken line is the velocity where it is significant (error of the first kind " +
      fixed_digits(100 * text.options.alpha0, 1) + " %).</p>";
  const auto section = [&](const SeriesPoint& p) {
    out += "<section id=\"" + anchor_of(p) + "\"><h2" + kAsItIs + ">" + xml_escaped(p.id) + "</h2>";
    if (!in_words(p, text).empty()) out += "<p>" + xml_escaped(told_of(p, text)) + ".</p>";
    out += Chart(p, text).svg() + movements_of(p, text) + "</section>";
  };
  for (const SeriesPoint* p : told) section(*p);
  if (quiet.size() <= kAllShown)
    for (const SeriesPoint* p : quiet) section(*p);
  else
    out += "<p>" + std::to_string(quiet.size()) + " points do neither: their movements are in series.csv.</p>";
  return out + "</body></html>\n";
}

}  // namespace plumbline::survey
