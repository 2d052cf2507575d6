#include "verdict_text.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <sstream>
#include <vector>

#include "geometry/statistics.hpp"

namespace plumbline::survey {

namespace {

constexpr size_t kWorst = 5, kFindings = 4, kAgain = 8;

std::string digits(double value, int n, bool sign = false) {
  std::ostringstream text;
  text.precision(n);
  text << std::fixed << (sign ? std::showpos : std::noshowpos) << value;
  return text.str();
}

bool is_angular(const NetworkObservationT& o) {
  return o.kind == "direction" || o.kind == "zenith_angle" || o.kind == "angle" || o.kind == "azimuth";
}

std::string amount(const NetworkObservationT& o, double value) {
  if (!std::isfinite(value)) return "unknown";
  return is_angular(o) ? digits(value * 200e3 / std::numbers::pi, 1, true) + " mgon"
                       : digits(1e3 * value, 1, true) + " mm";
}

std::string name_of(const NetworkObservationT& o) {
  std::string kind = o.kind;
  std::replace(kind.begin(), kind.end(), '_', ' ');
  std::string name = kind + " " + (o.from.empty() ? "" : o.from + " -> ") + o.to;
  if (!o.file.empty()) name += " (" + o.file + (o.line > 0 ? ":" + std::to_string(o.line) : "") + ")";
  return name;
}

void write_worst(const std::vector<const NetworkObservationT*>& worst, std::ostringstream& text) {
  if (worst.empty()) return;
  text << "Worst readings (w beyond 3.3 is suspect):\n";
  for (size_t i = 0; i < worst.size() && i < kWorst; ++i) {
    const NetworkObservationT& o = *worst[i];
    text << "  " << i + 1 << ". " << name_of(o) << ": w " << digits(o.w, 1, true) << ", off by "
         << amount(o, o.estimated_blunder)
         << (o.removed   ? ", taken out"
             : o.flagged ? ", suspect"
                         : "")
         << "\n";
  }
}

/// Suspect sights, and points that nothing controls. Of many readings some are flagged by chance: who has to go back is
/// told of what the largest of them all would hardly reach (1 %), as in the findings.
void write_again(const SurveyNetworkT& n, const std::vector<const NetworkObservationT*>& worst,
                 std::ostringstream& text) {
  std::vector<std::string> again;
  const auto say = [&](const std::string& what) {
    if (std::find(again.begin(), again.end(), what) == again.end()) again.push_back(what);
  };
  // All that took part were tested, of which a brief result (survey.brief) holds some.
  const auto tested = std::max<long>(
      {1, static_cast<long>(n.observations.size()), n.statistics ? static_cast<long>(n.statistics->observations) : 0});
  const double by_chance = normal_quantile(1 - 0.5 * 0.01 / static_cast<double>(tested));
  for (const NetworkObservationT* o : worst)
    if (o->removed || (o->flagged && std::abs(o->w) > by_chance))
      say("sight " + o->to + (o->set_up.empty() ? "" : " from set-up " + o->set_up));
  std::map<std::string, bool> controlled;  // by target
  std::set<std::string> stations;
  for (const auto& s : n.set_ups) stations.insert(s->station);
  std::set<std::string> sighted;
  for (const auto& o : n.observations) {
    if (o->removed || o->to.empty()) continue;
    controlled[o->to] |= o->control != "uncontrolled";
    if (o->kind != "height_difference") sighted.insert(o->to);
  }
  for (const auto& [id, yes] : controlled)
    if (!yes && !stations.contains(id))
      say(!sighted.contains(id) ? "level to " + id + " a second time: nothing controls it"
                                : "sight " + id + " from another set-up: nothing controls it");
  for (const std::string& id : n.left_out)
    say("sight " + id + " with a distance, or from another set-up: not determined");
  if (again.empty()) {
    text << "Nothing has to be measured again.\n";
    return;
  }
  text << "Measure again before the instrument is packed:\n";
  for (size_t i = 0; i < again.size() && i < kAgain; ++i) text << "  - " << again[i] << "\n";
  if (again.size() > kAgain) text << "  and " << again.size() - kAgain << " more, see network.html\n";
}

struct Weakest {
  const NetworkEllipsoidT *plan = nullptr, *height = nullptr;
};

Weakest weakest_of(const SurveyNetworkT& n, const std::set<std::string>& left_out) {
  Weakest weakest;
  auto& [plan, height] = weakest;
  std::set<std::string> in_plan, in_height;  // points that have such coordinates
  for (const auto& p : n.points) {
    if (p->position.head<2>().allFinite()) in_plan.insert(p->id);
    if (std::isfinite(p->position.z())) in_height.insert(p->id);
  }
  for (const auto& e : n.ellipsoids) {
    if (left_out.contains(e->id)) continue;
    // What no reading determines is held at what was given, and its 0.0 mm would be no precision.
    if (in_plan.contains(e->id) && std::isfinite(e->plan_semi_axis_95) && e->plan_semi_axis_95 > 0 &&
        (!plan || e->plan_semi_axis_95 > plan->plan_semi_axis_95))
      plan = e.get();
    if (in_height.contains(e->id) && std::isfinite(e->height_half_length_95) && e->height_half_length_95 > 0 &&
        (!height || e->height_half_length_95 > height->height_half_length_95))
      height = e.get();
  }
  return weakest;
}

void write_precision(const SurveyNetworkT& n, std::ostringstream& text) {
  std::set<std::string> stations;
  for (const auto& s : n.set_ups) stations.insert(s->station);
  Weakest weakest = weakest_of(n, stations);
  // A station among known points is all that a resection determines.
  if (!weakest.plan && !weakest.height) weakest = weakest_of(n, {});
  const auto& [plan, height] = weakest;
  if (!plan && !height) return;
  text << "Weakest at 95 %: ";
  if (plan) text << "in plan " << plan->id << " " << digits(1e3 * plan->plan_semi_axis_95, 1) << " mm";
  if (height)
    text << (plan ? ", in height " : "in height ") << height->id << " "
         << digits(1e3 * height->height_half_length_95, 1) << " mm";
  text << ".\n";
}

/// How much was measured, and what holds it.
std::string extent(const SurveyNetworkT& n) {
  const std::string points = std::to_string(n.points.size()) + " points, ";
  if (n.without_readings) return points + "no readings.\n";
  std::string text = points + std::to_string(n.set_ups.size()) + (n.set_ups.size() == 1 ? " set-up, " : " set-ups, ") +
                     std::to_string(n.observations.size()) + " readings";
  if (n.statistics) text += ", " + std::to_string(n.statistics->degrees_of_freedom) + " more than needed";
  return text + "; datum: " + n.datum + ".\n";
}

}  // namespace

std::string verdict_text(const SurveyNetworkT& n) {
  std::ostringstream text;
  std::string verdict = n.verdict;
  if (n.validity == "invalid")
    std::transform(verdict.begin(), verdict.begin() + 12, verdict.begin(), ::toupper);
  else if (!verdict.empty())
    verdict[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(verdict[0])));
  text << verdict << ".\n";
  const bool first_is_known =
      std::any_of(n.known_points.begin(), n.known_points.end(), [](const auto& k) { return k->rank > 0; }) &&
      !n.findings.empty();
  if (first_is_known) text << (n.findings.front()->severity == "note" ? "" : "! ") << n.findings.front()->text << ".\n";
  text << extent(n);
  if (!n.frame.empty()) text << "Map " << n.frame << ".\n";
  size_t said = 0;
  for (const auto& f : n.findings) {
    if (first_is_known && f == n.findings.front()) continue;
    // What holds nothing is said even where it is right that nobody sighted it.
    const bool told = f->subject == "exclusion" || f->subject == "unread";
    if (f->severity == "note" ? !told : f->subject == "reading") continue;
    if (++said > kFindings) continue;
    text << (f->severity == "note" ? "" : "! ") << f->text << ".\n";
  }
  if (said > kFindings)
    text << "  and " << said - kFindings << (said - kFindings == 1 ? " finding" : " findings")
         << " more, see network.html\n";
  std::vector<const NetworkObservationT*> worst;
  for (const auto& o : n.observations)
    if (std::isfinite(o->w) && o->w != 0) worst.push_back(o.get());
  std::stable_sort(worst.begin(), worst.end(), [](const auto* a, const auto* b) {
    return a->removed != b->removed ? a->removed : std::abs(a->w) > std::abs(b->w);
  });
  write_worst(worst, text);
  if (!n.without_readings) write_again(n, worst, text);
  write_precision(n, text);
  return text.str();
}

}  // namespace plumbline::survey
