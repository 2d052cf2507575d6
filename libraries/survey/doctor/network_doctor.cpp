// Says in words what the numbers mean: which observations nothing controls, where the network hangs on a single point.
#include "survey/doctor/network_doctor.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "geometry/statistics.hpp"
#include "survey/words/network_words.hpp"

namespace plumbline::survey {

namespace {

/// No instrument is that much worse than its profile.
constexpr double kAbsurd = 30;

std::string describe(const ResultRow& row) {
  std::string kind = row.kind;
  std::replace(kind.begin(), kind.end(), '_', ' ');
  return kind + " " + (row.from.empty() ? "" : row.from + " -> ") + row.to +
         (row.detail.empty() ? "" : " (" + row.detail + ")") +
         (row.source.line > 0 ? " (" + place(row.source) + ")" : "");
}

bool is_angular(const ResultRow& row) {
  return row.kind == "direction" || row.kind == "zenith_angle" || row.kind == "angle" || row.kind == "azimuth";
}

std::string amount(const ResultRow& row, double value) {
  if (is_angular(row)) return fixed_digits(value * 200000 / std::numbers::pi, 1) + " mgon";
  return fixed_digits(value * 1000, 1) + " mm";
}

std::string in_words(long n, const std::string& what) {
  return std::to_string(n) + " observation" + (n == 1 ? " is " : "s are ") + what;
}

/// A target at another height than noted looks like a wrong zenith angle: which it is only the pole can tell.
std::string or_target_height(const NetworkResult& r, const ResultRow& row) {
  constexpr double kLeast = 0.01, kMost = 5;  // [m]
  if (row.kind != "zenith_angle" || row.set_up.empty() || !std::isfinite(row.statistics.estimated_blunder)) return "";
  const Eigen::Vector3d d = r.point(row.to).position - r.point(row.from).position;
  const double h = d.head<2>().norm();
  if (!(h > 0)) return "";
  const double too_large = row.statistics.estimated_blunder * d.squaredNorm() / h;
  if (!(std::abs(too_large) > kLeast && std::abs(too_large) < kMost)) return "";
  return ", or its target height noted too " + std::string(too_large > 0 ? "large" : "small") + " by " +
         fixed_digits(1000 * std::abs(too_large), 0) + " mm";
}

/// Worst first: the others often follow from it. What would fail by chance alone is said too.
void examine_failures(const NetworkResult& r, const AdjustOptions& options, std::vector<Finding>& findings) {
  constexpr size_t kShown = 10;
  constexpr double kFalseAlarm = 0.01;  ///< chance that a sound network has a warning
  std::vector<const ResultRow*> failing;
  for (const ResultRow& row : r.rows)
    if (row.flagged) failing.push_back(&row);
  // Two readings of one condition have the same w: they come in the order of the file, not in that of its last digit.
  const auto size = [](const ResultRow* row) { return std::round(1e6 * std::abs(row->statistics.w)); };
  std::stable_sort(failing.begin(), failing.end(), [&](const ResultRow* a, const ResultRow* b) {
    return a->removed != b->removed ? a->removed : size(a) > size(b);
  });
  const auto removed = std::count_if(failing.begin(), failing.end(), [](const ResultRow* row) { return row->removed; });
  // One of many readings fails by chance; a warning is for what the largest of them all would hardly reach.
  const double warned =
      normal_quantile(1 - 0.5 * kFalseAlarm / static_cast<double>(std::max<size_t>(1, r.rows.size())));
  const auto is_by_chance = [&](const ResultRow& row) { return !row.removed && std::abs(row.statistics.w) < warned; };
  for (size_t i = 0; i < failing.size() && i < kShown; ++i) {
    const ResultRow& row = *failing[i];
    const bool by_chance = is_by_chance(row);
    findings.push_back({by_chance ? Finding::Severity::note : Finding::Severity::warning,
                        (row.removed ? "removed: " : "suspect: ") + describe(row) +
                            ", w = " + fixed_digits(row.statistics.w, 1) + ", probably wrong by " +
                            amount(row, row.statistics.estimated_blunder) + or_target_height(r, row),
                        {row.from, row.to},
                        Finding::Subject::reading});
  }
  const bool rest_by_chance = std::all_of(failing.begin() + std::min<long>(kShown, std::ssize(failing)), failing.end(),
                                          [&](const ResultRow* row) { return is_by_chance(*row); });
  if (failing.size() > kShown)
    findings.push_back({rest_by_chance ? Finding::Severity::note : Finding::Severity::warning,
                        std::to_string(failing.size() - kShown) + " more fail, see the list of observations",
                        {}});
  const double by_chance = options.alpha0 * static_cast<double>(r.rows.size());
  const auto suspects = static_cast<double>(static_cast<long>(failing.size()) - removed);
  if (suspects > 0 && by_chance >= 1 && suspects <= by_chance + 3 * std::sqrt(by_chance))
    findings.push_back({Finding::Severity::note,
                        "of " + std::to_string(r.rows.size()) + " observations about " + fixed_digits(by_chance, 0) +
                            " fail by chance alone where nothing is wrong",
                        {}});
  else if (suspects > 1)
    findings.push_back(
        {Finding::Severity::note, "mend or remove the first suspect and adjust again: others may follow from it", {}});
}

void examine_rows(const NetworkModel& m, const NetworkResult& r, const AdjustOptions& options,
                  std::vector<Finding>& findings) {
  std::vector<std::string> uncontrolled, points;
  int weak = 0;
  for (const ResultRow& row : r.rows) {
    const double redundancy = row.statistics.controlled;
    // What holds a network is compared with it as known points, not as readings.
    if (row.kind == "coordinate" && m.keyed_in.contains(row.to)) continue;
    if (!row.removed && redundancy < 0.1) {
      uncontrolled.push_back(describe(row));
      points.push_back(row.to);
    }
    weak += !row.removed && redundancy >= 0.1 && redundancy < 0.3;
  }
  examine_failures(r, options, findings);
  if (!uncontrolled.empty() && r.degrees_of_freedom > 0)
    findings.push_back({Finding::Severity::warning,
                        in_words(static_cast<long>(uncontrolled.size()), "not controlled by others (a blunder there ") +
                            "would go unseen): " + join(uncontrolled, 6),
                        points});
  if (weak > 0)
    findings.push_back(
        {Finding::Severity::note, in_words(weak, "weakly controlled (redundancy number below 0.3)"), {}});
}

/// Points whose loss would split the network: articulation points of the graph of sights (Tarjan 1972).
class HingePoints {
 public:
  explicit HingePoints(const NetworkResult& r) {
    for (const ResultRow& row : r.rows) {
      if (row.removed || row.from.empty() || row.to.empty()) continue;
      connect(row.from, row.to);
      if (row.kind == "angle") connect(row.from, row.detail);
    }
    depth_.assign(neighbours_.size(), -1);
    low_.assign(neighbours_.size(), 0);
    for (size_t i = 0; i < neighbours_.size(); ++i)
      if (depth_[i] < 0) visit(static_cast<int>(i), -1, 0);
  }
  const std::set<std::string>& points() const { return hinges_; }

 private:
  int number(const std::string& id) {
    const auto [at, is_new] = index_.try_emplace(id, static_cast<int>(names_.size()));
    if (is_new) {
      names_.push_back(id);
      neighbours_.emplace_back();
    }
    return at->second;
  }
  void connect(const std::string& a, const std::string& b) {
    const int i = number(a), j = number(b);
    neighbours_[i].insert(j);
    neighbours_[j].insert(i);
  }
  void visit(int node, int parent, int depth) {
    depth_[node] = low_[node] = depth;
    int children = 0;
    for (int next : neighbours_[node]) {
      if (next == parent) continue;
      if (depth_[next] >= 0) {
        low_[node] = std::min(low_[node], depth_[next]);
        continue;
      }
      visit(next, node, depth + 1);
      low_[node] = std::min(low_[node], low_[next]);
      // A dead end (a point seen from one place only) is told of as uncontrolled, not as a hinge.
      if (parent >= 0 && low_[next] >= depth && neighbours_[next].size() > 1) hinges_.insert(names_[node]);
      children += neighbours_[next].size() > 1;
    }
    if (parent < 0 && children > 1) hinges_.insert(names_[node]);
  }
  std::map<std::string, int> index_;
  std::vector<std::string> names_;
  std::vector<std::set<int>> neighbours_;
  std::vector<int> depth_, low_;
  std::set<std::string> hinges_;
};

/// One wrong control point pulls at the others, so the worst is named first.
void examine_control(const NetworkModel& m, const NetworkResult& r, std::vector<Finding>& findings) {
  if (m.datum != DatumMode::weighted) return;
  const std::vector<std::string> ids = contradicting(r.known_points);
  if (ids.empty()) return;
  const std::vector<std::string> others(ids.begin() + 1, ids.end());
  findings.push_back({Finding::Severity::warning,
                      "control point " + ids[0] +
                          " does not fit the observations: it may have moved, or its coordinates are another point's" +
                          (others.empty() ? "" : "; less so, and perhaps because of it, " + join(others)),
                      ids});
}

}  // namespace

std::vector<Finding> examine(const NetworkModel& model, const AdjustOptions& options, const NetworkResult& result) {
  std::vector<Finding> findings;
  if (result.degrees_of_freedom == 0 && !result.without_readings)
    findings.push_back({Finding::Severity::warning, "there is no redundancy: nothing controls the observations", {}});
  using Verdict = least_squares::GlobalTest::Verdict;
  const std::string sigma0 = fixed_digits(result.sigma0, 2);
  // One sound network in twenty fails at the usual level: that is a note. A warning is for what is certain.
  const bool certain = result.degrees_of_freedom > 0 && result.sigma0 * result.sigma0 * result.degrees_of_freedom >
                                                            chi_squared_quantile(0.999, result.degrees_of_freedom);
  if (result.degrees_of_freedom > 0 && result.global_test.verdict == Verdict::high)
    findings.push_back({certain ? Finding::Severity::warning : Finding::Severity::note,
                        "global test fails: sigma0 " + sigma0 +
                            " is too large; there are blunders, or the assumed accuracies are too good" +
                            (result.sigma0 > kAbsurd ? "; so large: check the units of angles and lengths first" : ""),
                        {}});
  constexpr double kWrongPlace = 30;  // of sigma0: a few gross errors hardly reach it
  if (model.searched && result.degrees_of_freedom > 0 && result.sigma0 > kWrongPlace)
    findings.push_back(
        {Finding::Severity::error,
         "these coordinates are probably wrong: approximate coordinates had to be computed and sigma0 is " + sigma0 +
             "; mend the gross errors, or give approximate coordinates",
         {}});
  if (result.degrees_of_freedom > 0 && result.global_test.verdict == Verdict::low)
    findings.push_back({Finding::Severity::note,
                        "global test: sigma0 " + sigma0 + " is small; the assumed accuracies are too cautious",
                        {}});
  examine_rows(model, result, options, findings);
  const HingePoints hinges(result);
  if (!hinges.points().empty()) {
    const std::vector<std::string> ids(hinges.points().begin(), hinges.points().end());
    findings.push_back({Finding::Severity::warning,
                        "the network hangs on " + join(ids) +
                            ": parts of it are connected through these points only; add sights past them",
                        ids});
  }
  examine_control(model, result, findings);
  return findings;
}

}  // namespace plumbline::survey
