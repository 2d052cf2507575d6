// The headline of the first screen: ready or not, in a sentence.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "show/report/format.hpp"
#include "show/report/sections.hpp"

namespace plumbline::report {

namespace {

/// "2 anchors, 1 panel and 1 surface or joint"; those of which there are none are left out.
std::string counted_words(int anchors, int panels, int surfaces) {
  std::vector<std::string> parts;
  if (anchors > 0) parts.push_back(count(anchors, "anchor", "anchors"));
  if (panels > 0) parts.push_back(count(panels, "panel", "panels"));
  if (surfaces > 0) parts.push_back(count(surfaces, "surface or joint", "surfaces and joints"));
  std::string text;
  for (std::size_t i = 0; i < parts.size(); ++i)
    text += (i == 0 ? "" : i + 1 == parts.size() ? " and " : ", ") + parts[i];
  return text;
}

}  // namespace

std::string installation_heading(const DeviationT& d, int panels_failed, int panels_open) {
  const auto anchors = [](int n) { return count(n, "anchor", "anchors"); };
  const auto surfaces = [&](ToleranceVerdict v) { return d.surfaces ? surfaces_with(*d.surfaces, v) : 0; };
  if (d.verdict == ToleranceVerdict::pass)
    return "Ready to install: all " +
           counted_words(d.passed, static_cast<int>(d.panels.size()), surfaces(ToleranceVerdict::pass)) +
           " are within tolerance.";
  if (d.verdict == ToleranceVerdict::fail) {
    const int surfaces_failed = surfaces(ToleranceVerdict::fail);
    return "Not ready: " + counted_words(d.failed, panels_failed, surfaces_failed) +
           (d.failed + panels_failed + surfaces_failed == 1 ? " is" : " are") + " out of tolerance.";
  }
  if (d.verdict == ToleranceVerdict::undecided) {
    if (d.not_judged > 0)
      return "Not decided: " + count(d.not_judged, "thing that was asked for was", "things that were asked for were") +
             " not judged.";
    if (!d.doubts.empty())
      return d.doubts.front()->part == MeasurementPart::datum
                 ? "Not decided: nothing shows where the whole stands."
                 : "Not decided: the measurement contradicts itself and shows no anchor to be in order.";
    std::string text = "Not decided: ";
    // Without a probability nothing is close: what could not be judged of it is along the facade or out of it.
    const auto unconfirmed = static_cast<int>(std::count_if(d.anchors.begin(), d.anchors.end(), [](const auto& anchor) {
      return anchor->verdict == ToleranceVerdict::undecided && std::isnan(anchor->pass_probability) && anchor->facade &&
             !anchor->facade->confirmed;
    }));
    const int close = d.undecided - unconfirmed;
    if (unconfirmed > 0) text += anchors(unconfirmed) + " whose facade is not confirmed";
    if (close > 0) text += (unconfirmed > 0 ? ", " : "") + anchors(close) + " too close to call";
    if (d.not_measured > 0) text += (d.undecided > 0 ? ", " : "") + anchors(d.not_measured) + " without verdict";
    if (d.undecided + d.not_measured == 0)
      text += counted_words(0, panels_open, surfaces(ToleranceVerdict::undecided)) + " too close to call";
    return text + ".";
  }
  return "No verdict: no anchor of the design was measured.";
}

}  // namespace plumbline::report
