#include "show/bench/figures.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "show/bench/sentences.hpp"
#include "show/bench/tables.hpp"

namespace plumbline::bench {

namespace {

constexpr double kWidth = 720, kLeft = 262, kRight = 20, kTop = 54, kLine = 11, kGap = 9, kBottom = 38;

/// The first ones are told apart by people who see red and green alike (Okabe and Ito 2008).
const char* const palette[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9",
                               "#7a6a10", "#6b6b6b", "#000000", "#6a3d9a", "#b15928", "#17d4c8"};

std::string colour(std::size_t k) { return palette[k % (sizeof palette / sizeof *palette)]; }

/// Millimetres to places, logarithmic where values differ by more than a factor of 12.
class Axis {
 public:
  Axis(double low, double high) : logarithmic_(low > 0 && high > 12 * low) {
    low_ = logarithmic_ ? low / 1.15 : 0;
    high_ = logarithmic_ ? high * 1.15 : high * 1.05;
    if (!(high_ > low_)) high_ = low_ + 1;
  }
  double operator()(double value) const {
    const double v = std::clamp(value, low_, high_);
    const double share = logarithmic_ ? std::log(v / low_) / std::log(high_ / low_) : (v - low_) / (high_ - low_);
    return kLeft + share * (kWidth - kLeft - kRight);
  }
  bool logarithmic() const { return logarithmic_; }
  std::vector<double> ticks() const {
    std::vector<double> list;
    if (logarithmic_) {
      const bool wide = high_ / low_ > 300;
      for (int p = static_cast<int>(std::floor(std::log10(low_))); p <= static_cast<int>(std::ceil(std::log10(high_)));
           ++p)
        for (const double k : {1.0, 2.0, 5.0})
          if ((k < 2 || !wide) && k * std::pow(10, p) >= low_ && k * std::pow(10, p) <= high_)
            list.push_back(k * std::pow(10, p));
      return list;
    }
    const double raw = (high_ - low_) / 6, power = std::pow(10, std::floor(std::log10(raw)));
    double step = 10 * power;
    for (const double k : {5.0, 2.0, 1.0})
      if (k * power >= raw) step = k * power;
    for (int i = 0; i * step <= high_; ++i) list.push_back(i * step);
    return list;
  }

 private:
  bool logarithmic_;
  double low_ = 0, high_ = 1;
};

std::string short_number(double value) { return fmt::format("{:.4g}", value); }

/// Rows of the group's alternatives with everything beside it held; by place, then alternative.
struct Held {
  std::string beside;  ///< the choices that are held, in words
  std::map<std::pair<std::string, std::string>, const Row*> rows;
  std::size_t alternatives = 0;
};

Held held_rows(const Analysis& analysis, const Group& group) {
  std::vector<Held> all;
  for (const Row& row : analysis.rows) {
    const auto choice = row.choices.find(group.name);
    if (choice == row.choices.end()) continue;
    const std::string beside = choices_text(row.choices, group.name);
    auto found = std::find_if(all.begin(), all.end(), [&](const Held& held) { return held.beside == beside; });
    if (found == all.end()) found = all.insert(all.end(), Held{beside, {}, 0});
    found->rows[{row.place, choice->second}] = &row;
  }
  for (Held& held : all)
    for (const std::string& name : group.alternatives)
      held.alternatives += std::any_of(held.rows.begin(), held.rows.end(), [&, &name = name](const auto& item) {
        return item.first.second == name && std::isfinite(item.second->summary.rmse.value);
      });
  const auto best = std::max_element(all.begin(), all.end(),
                                     [](const Held& a, const Held& b) { return a.alternatives < b.alternatives; });
  return best == all.end() ? Held{} : *best;
}

/// Names of places are cut so that they do not run into the picture.
std::string cut(const std::string& text, std::size_t most) {
  return text.size() > most ? text.substr(0, most - 3) + "..." : text;
}

void draw_axis(Drawing& d, const Axis& axis, double bottom, const std::string& label) {
  for (const double tick : axis.ticks()) {
    d.lines.push_back({axis(tick), kTop - 4, axis(tick), bottom, 0.5, "#c3cad0"});
    d.words.push_back({axis(tick), bottom + 12, 9, short_number(tick), Drawing::Anchor::middle});
  }
  d.words.push_back({0.5 * (kLeft + kWidth - kRight), bottom + 26, 9, label, Drawing::Anchor::middle});
}

void draw_row(Drawing& d, const Axis& axis, double y, const Row& row, const std::string& name,
              const std::string& paint) {
  const auto& rmse = row.summary.rmse;
  const std::string failed = row.summary.failures > 0 ? std::to_string(row.summary.failures) + " of " +
                                                            std::to_string(row.summary.trials) + " failed"
                                                      : "";
  if (!std::isfinite(rmse.value)) {
    d.words.push_back({kLeft + 4, y + 3, 8, name + ": " + (failed.empty() ? "no result" : failed)});
    return;
  }
  if (std::isfinite(rmse.interval.lower))
    d.lines.push_back({axis(1e3 * rmse.interval.lower), y, axis(1e3 * rmse.interval.upper), y, 2, paint});
  d.dots.push_back({axis(1e3 * rmse.value), y, 3.2, paint,
                    name + ", " + (row.place.empty() ? "" : row.place + ": ") + interval_text(rmse, 1e3) + " mm" +
                        (failed.empty() ? "" : ", " + failed)});
  if (failed.empty()) return;
  const double end = axis(1e3 * (std::isfinite(rmse.interval.upper) ? rmse.interval.upper : rmse.value)),
               begin = axis(1e3 * (std::isfinite(rmse.interval.lower) ? rmse.interval.lower : rmse.value));
  if (end < kWidth - 110)
    d.words.push_back({end + 6, y + 3, 8, failed});
  else if (begin > kLeft + 100)
    d.words.push_back({begin - 6, y + 3, 8, failed, Drawing::Anchor::end});
}

/// A picture goes its way without the page: what the command line set for all cells is below it.
Drawing with_overrides(const Bench& bench, Drawing drawing) {
  const std::string given = overrides_text(bench);
  if (given.empty()) return drawing;
  drawing.words.push_back({8, drawing.height + 8, 8.5, given});
  drawing.height += 16;
  return drawing;
}

}  // namespace

Drawing panel(const Bench& bench, const Analysis& analysis, const Group& group) {
  const Held held = held_rows(analysis, group);
  std::vector<std::string> names, missing;
  for (const std::string& name : group.alternatives) {
    const bool there =
        std::any_of(held.rows.begin(), held.rows.end(), [&](const auto& item) { return item.first.second == name; });
    (there ? names : missing).push_back(name);
  }
  double low = std::numeric_limits<double>::infinity(), high = 0;
  for (const auto& [key, row] : held.rows) {
    const auto& rmse = row->summary.rmse;
    if (!std::isfinite(rmse.value)) continue;
    low = std::min(low, 1e3 * (std::isfinite(rmse.interval.lower) ? rmse.interval.lower : rmse.value));
    high = std::max(high, 1e3 * (std::isfinite(rmse.interval.upper) ? rmse.interval.upper : rmse.value));
  }
  Drawing d;
  d.width = kWidth;
  d.words.push_back(
      {8, 16, 12, group.name + (held.beside.empty() ? "" : ", with " + held.beside), Drawing::Anchor::start, true});
  if (!(high > 0)) {
    d.words.push_back({8, 34, 10, "no finished trials"});
    d.height = 44;
    return d;
  }
  constexpr double kLegendLine = 13;
  double x = 8, below = 0;  // of the first line of names
  for (std::size_t k = 0; k < names.size(); ++k) {
    const double wide = 30 + 5.2 * static_cast<double>(names[k].size());
    if (x > 8 && x + wide > kWidth) x = 8, below += kLegendLine;
    d.dots.push_back({x + 4, 30 + below, 3.2, colour(k), names[k]});
    d.words.push_back({x + 12, 33 + below, 9.5, names[k]});
    x += wide;
  }
  std::string absent;
  for (const std::string& name : missing) absent += (absent.empty() ? "not with these: " : ", ") + name;
  if (!absent.empty()) d.words.push_back({8, 46 + below, 8.5, absent});
  const Axis axis(low, high);
  double y = kTop + 6 + below;
  for (const std::string& place : bench.places()) {
    const double middle = y + 0.5 * kLine * static_cast<double>(names.size() - 1);
    d.words.push_back(
        {kLeft - 10, middle + 3, 9.5, cut(place.empty() ? "all trials" : place, 54), Drawing::Anchor::end});
    for (std::size_t k = 0; k < names.size(); ++k, y += kLine)
      if (const auto row = held.rows.find({place, names[k]}); row != held.rows.end())
        draw_row(d, axis, y, *row->second, names[k], colour(k));
    y += kGap;
  }
  draw_axis(d, axis, y,
            "RMSE [mm] with its " + confidence_text(bench, analysis) + " interval" +
                (axis.logarithmic() ? ", logarithmic" : ""));
  d.height = y + kBottom;
  return d;
}

Drawing figure(const Bench& bench, const Analysis& analysis) {
  Drawing all;
  for (const Group& group : bench.groups) all.append(panel(bench, analysis, group));
  if (!bench.groups.empty()) return with_overrides(bench, std::move(all));
  // Rows of a bench without groups have one choice, of no name.
  Analysis named = analysis;
  for (Row& row : named.rows) row.choices["error"] = bench.error_metric;
  return with_overrides(bench, panel(bench, named, Group{"error", {bench.error_metric}, {}, false}));
}

}  // namespace plumbline::bench
