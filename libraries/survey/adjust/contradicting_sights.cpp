// A point of which as many set-ups lost readings as kept them all: it was moved between them, or two marks share its
// name. Where it is follows from which of them were taken out, and that was chance: each reading went by its own test.
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "survey/adjust/adjuster.hpp"
#include "survey/words/network_words.hpp"

namespace plumbline::survey {

namespace {

std::string off_words(const Eigen::Vector3d& off) {
  const auto mm = [](double metres) { return fixed_digits(1000 * metres, 1); };
  return mm(off.norm()) + " mm elsewhere (E " + mm(off.x()) + ", N " + mm(off.y()) + ", H " + mm(off.z()) + " mm)";
}

}  // namespace

/// Direction, zenith angle and slope distance, whether taken out or not: e along the sight, across it, and downwards.
std::optional<Eigen::Vector3d> Adjuster::seen_beside(const Pass& pass, const std::vector<int>& sight) const {
  std::map<std::string, double> off;  // seen minus adjusted [rad, m]
  for (const int row : sight) {
    const auto at = std::find(pass.problem.rows.begin(), pass.problem.rows.end(), row);
    off[m_.rows[row].kind] =
        -(at == pass.problem.rows.end() ? removed_statistics(pass, row).residual
                                        : pass.reliability.rows[at - pass.problem.rows.begin()].residual);
  }
  if (!off.contains("direction") || !off.contains("zenith_angle") || !off.contains("slope_distance")) return {};
  const Eigen::Vector3d d = sight_of(pass, sight.front());
  const double h = d.head<2>().norm(), s = d.norm();
  if (!(h > 0) || !std::isfinite(s)) return {};
  const Eigen::Vector3d across(d.y(), -d.x(), 0);  // of length h, clockwise
  const Eigen::Vector3d down(d.x() * d.z() / h, d.y() * d.z() / h, -h);
  return (off["slope_distance"] / s * d + off["direction"] * across + off["zenith_angle"] * down).eval();
}

/// A reading that another round of the same set-up has and keeps was that round's mistake: the target is where the
/// others have it.
void Adjuster::count_removed(const std::vector<int>& sight, int set_up, SightsOfPoint& point) const {
  std::set<std::string> kept;
  for (const int row : sight)
    if (!state_.removed[row]) kept.insert(m_.rows[row].kind);
  for (const int row : sight) {
    const std::string& kind = m_.rows[row].kind;
    if (!state_.removed[row] || kept.contains(kind)) continue;
    ++point.removed;
    point.touched.insert(set_up);
    // An edge or a pane falsifies distances alone; the directions to the target stand.
    point.angles = point.angles || kind == "direction" || kind == "zenith_angle";
  }
}

std::map<std::string, Adjuster::SightsOfPoint> Adjuster::sights_with_removed() const {
  const std::set<int> misnamed(m_.misnamed.begin(), m_.misnamed.end());  // of them more is known than that they misfit
  std::map<std::string, SightsOfPoint> points;
  for (int row = 0; row < static_cast<int>(m_.observations.size()); ++row) {
    if (set_up_of_row_[row] < 0 || !m_.rows[row].removable || m_.dropped[row] || misnamed.contains(row)) continue;
    points[m_.rows[row].to].of_set_up[set_up_of_row_[row]].push_back(row);
  }
  for (auto& [id, point] : points)
    for (const auto& [set_up, sight] : point.of_set_up) count_removed(sight, set_up, point);
  std::erase_if(points, [&](const auto& entry) {
    const SightsOfPoint& p = entry.second;
    // A reading each, beside a sight that kept all: each was wrong by itself.
    const bool singly = p.touched.size() < p.of_set_up.size() && p.removed <= static_cast<int>(p.touched.size());
    return singly || p.removed < 2 || !p.angles || 2 * p.touched.size() < p.of_set_up.size() ||
           !m_.index.contains(entry.first) || !is_unknown(entry.first);
  });
  return points;
}

std::set<std::string> Adjuster::tell_contradicting_sights(const Pass& pass) {
  std::set<std::string> told;
  for (const auto& [id, point] : sights_with_removed()) {
    std::vector<std::string> set_ups;
    std::string beside;
    for (const int set_up : point.touched) {
      const std::vector<int>& sight = point.of_set_up.at(set_up);
      set_ups.push_back(m_.rows[sight.front()].set_up);
      if (!beside.empty()) continue;
      if (const auto off = seen_beside(pass, sight))
        beside = "; as " + set_ups.back() + " has it, it lies " + off_words(*off);
    }
    const std::string text =
        id + ": of " + std::to_string(point.of_set_up.size()) + " set-ups that sighted it " +
        std::to_string(set_ups.size()) + " lost readings to it (" + join(set_ups) + ")" + beside +
        ": it was moved between them, or two marks have this name, and nothing tells which place counts; measure " +
        id + " once more";
    m_.findings.push_back({Finding::Severity::warning, text, {id}, Finding::Subject::either});
    if (told.empty()) either_ = text;
    told.insert(id);
  }
  if (told.size() > 1) either_ += " (and " + std::to_string(told.size() - 1) + " more of that kind)";
  return told;
}

}  // namespace plumbline::survey
