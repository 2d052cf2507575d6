// What is said of a series of epochs.
#include <algorithm>
#include <cmath>

#include "series_files.hpp"
#include "survey/words/network_words.hpp"

namespace plumbline::survey {

namespace {

/// "E +1.2, H -3.4 mm/year (sigma 0.2, 0.3)" of the axes that are there. What the datum holds (a stable point alone
/// carries the height) has no uncertainty beside the others': it was not measured, and is no movement of 0.00.
std::string components(const Eigen::Vector3d& value, const Eigen::Vector3d& sigma, double factor,
                       const std::string& unit) {
  constexpr double kHeld = 1e-4;
  std::string text, sigmas;
  const double largest = sigma.array().isFinite().select(sigma.array(), 0.0).maxCoeff();
  for (int k = 0; k < 3; ++k) {
    if (!std::isfinite(value[k]) || !(sigma[k] > kHeld * largest)) continue;
    const double size = factor * value[k];
    text += (text.empty() ? "" : ", ") + std::string(1, "ENH"[k]) + (size < 0 ? " " : " +") + fixed_digits(size, 2);
    sigmas += (sigmas.empty() ? "" : ", ") + fixed_digits(factor * sigma[k], 2);
  }
  return text + " " + unit + " (sigma " + sigmas + ")";
}

/// ", H since 2025-03-14" of coordinates that another epoch than the point's first measured first.
std::string later_references(const SeriesPoint& p, const SeriesPoint::At& at, const SeriesText& text) {
  std::string words;
  for (size_t k = 0; k < 3; ++k)
    if (p.reference[k] != p.first && std::isfinite(at.movement[static_cast<Eigen::Index>(k)]))
      words += ", " + std::string(1, "ENH"[k]) + " since " + text.labels[p.reference[k]];
  return words;
}

}  // namespace

double velocity_factor(const SeriesText& text) { return 1000 * (text.unit == "day" ? 365.25 : 1); }
std::string velocity_unit(const SeriesText& text) { return text.unit == "day" ? "mm/year" : "mm/" + text.unit; }

std::string in_words(const SeriesPoint& p, const SeriesText& text) {
  std::string words;
  const auto add = [&](const std::string& what) { words += (words.empty() ? "" : "; ") + what; };
  const std::vector<const SeriesPoint::At*> latest = p.latest();
  const auto has_moved = [](const SeriesPoint::At* at) { return at->moved; };
  const bool moved = std::any_of(latest.begin(), latest.end(), has_moved);
  const std::string velocity =
      p.velocity.array().isFinite().any()
          ? ", " + components(p.velocity, p.velocity_sigma, velocity_factor(text), velocity_unit(text))
          : "";  // it is shown in a direction that is none of E, N and H
  if (p.moves) add("moves" + velocity);
  if (p.uneven() && (p.moves || moved)) add("not evenly");
  for (const SeriesPoint::At* at : latest)
    if (at->moved)
      add("moved since " + text.labels[p.first] + " by " + components(at->movement, at->sigma, 1000, "mm") +
          later_references(p, *at, text) + (at->epoch == p.at.back().epoch ? "" : ", as of " + text.labels[at->epoch]));
  if (!moved && std::any_of(p.at.begin(), p.at.end(), [](const auto& at) { return at.moved; }))
    add("was elsewhere in between");
  if (const Level alarm = p.latest_alarm(), warning = p.latest_warning(); alarm != Level::below)
    add(std::string("the alarm level ") + (alarm == Level::reached ? "is reached" : "may be reached"));
  else if (warning != Level::below)
    add(std::string("the warning level ") + (warning == Level::reached ? "is reached" : "may be reached"));
  if (!words.empty() && p.at.back().epoch + 1 < text.labels.size())
    add("not seen since " + text.labels[p.at.back().epoch]);
  return words.empty() ? "" : p.id + ": " + words;
}

std::vector<const SeriesPoint*> points_told(const EpochSeries& s, const SeriesText& text,
                                            std::vector<const SeriesPoint*>& quiet) {
  std::vector<const SeriesPoint*> told;
  for (const SeriesPoint& p : s.points) (in_words(p, text).empty() ? quiet : told).push_back(&p);
  std::stable_sort(told.begin(), told.end(), [](const SeriesPoint* a, const SeriesPoint* b) {
    const auto rank = [](const SeriesPoint* p) { return 2 * (p->latest_alarm() != Level::below) + p->moves; };
    return rank(a) != rank(b) ? rank(a) > rank(b) : a->velocity_statistic > b->velocity_statistic;
  });
  return told;
}

std::string how_many_move(size_t told, const SeriesText& text) {
  if (told > 0 && text.is_explained)
    return "A mistake in an epoch would explain movements (see the notes): mend it first. As it is " +
           std::to_string(told) +
           (told == 1 ? " point seems to move, to have moved or to reach a level."
                      : " points seem to move, to have moved or to reach a level.");
  return told == 0 ? "No point moves, and none has moved, beyond chance."
                   : std::to_string(told) + (told == 1 ? " point moves, moved or reaches a level."
                                                       : " points move, moved or reach a level.");
}

std::string order_words(const SeriesText& text) {
  const bool dated = text.unit == "day";
  std::vector<std::string> epochs;
  for (size_t k = 0; k < text.labels.size(); ++k)
    epochs.push_back(text.labels[k] + (dated ? " " + fixed_digits(text.times[k], 0) : ""));
  return std::string("In their order") + (dated ? ", with their days: " : ": ") + join(epochs, epochs.size()) + ".";
}

std::string datum_words(const EpochSeries& s, const SeriesText& text) {
  const bool one = s.stable.size() == 1, found = text.options.stable.empty();
  return "The datum is carried by " + std::to_string(s.stable.size()) +
         (found ? one ? " point that stays in all epochs: " : " points that stay in all epochs: "
          : one ? " point that was named for it: "
                : " points that were named for it: ") +
         join(s.stable, 20) + ".";
}

std::string told_of(const SeriesPoint& p, const SeriesText& text) { return in_words(p, text).substr(p.id.size() + 2); }

std::string series_verdict(const EpochSeries& s, const SeriesText& text) {
  std::vector<const SeriesPoint*> quiet;
  const std::vector<const SeriesPoint*> told = points_told(s, text, quiet);
  std::string out =
      "Series of " + std::to_string(text.labels.size()) + " epochs\n" + how_many_move(told.size(), text) + "\n";
  for (const std::string& words : s.not_followed) out += "Note: " + words + "\n";
  for (const SeriesPoint* p : told) out += "  " + in_words(*p, text) + "\n";
  out += order_words(text) + "\nOf the epochs: " + s.variances + ".\n" + datum_words(s, text) + "\n";
  if (!s.contradicted.empty()) out += "Of them moved, against most other points: " + join(s.contradicted, 20) + "\n";
  for (const std::string& words : s.not_compared) out += "Note: " + words + "\n";
  for (const std::string& words : text.notes) out += "Note: " + words + "\n";
  return out;
}

}  // namespace plumbline::survey
