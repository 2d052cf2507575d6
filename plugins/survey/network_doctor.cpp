// Says in words what the numbers mean: which movements a network leaves open, which observations nothing controls,
// where it hangs on a single point.
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <set>
#include <sstream>

#include "network_model.hpp"

namespace plumbline::survey {

namespace {

std::string join(const std::vector<std::string>& ids, size_t most = 10) {
  std::string text;
  for (size_t i = 0; i < ids.size() && i < most; ++i) text += (i ? ", " : "") + ids[i];
  if (ids.size() > most) text += " and " + std::to_string(ids.size() - most) + " more";
  return text;
}

std::string fixed_digits(double value, int digits) {
  std::ostringstream text;
  text.setf(std::ios::fixed);
  text.precision(digits);
  text << value;
  return text.str();
}

/// Movements of a whole part of the network, as columns over all unknowns.
struct Movement {
  std::string name;
  Eigen::VectorXd direction;
};

/// Connected parts of the network: blocks joined by observations.
std::vector<int> parts_of(const NetworkProblem& p) {
  std::vector<int> parent(p.problem.parameters.size());
  std::iota(parent.begin(), parent.end(), 0);
  const std::function<int(int)> root = [&](int i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  std::set<int> common;
  for (const auto& [name, block] : p.common_blocks) common.insert(block);
  for (const auto& residual : p.problem.residuals) {
    int first = -1;
    for (int block : residual->parameters) {
      if (common.contains(block)) continue;
      if (first < 0)
        first = root(block);
      else
        parent[root(block)] = first;
    }
  }
  for (size_t i = 0; i < parent.size(); ++i) parent[i] = root(static_cast<int>(i));
  return parent;
}

class DefectNamer {
 public:
  DefectNamer(const NetworkModel& model, const NetworkProblem& problem, const Eigen::MatrixXd& directions)
      : m_(model), p_(problem), unknowns_(problem.problem), open_(directions), part_(parts_of(problem)) {}

  /// What of the open directions is not a movement of the network as a whole, as an orthonormal basis: 0 columns if
  /// nothing.
  Eigen::MatrixXd beyond_motions() const {
    std::vector<int> all(m_.ids.size());
    std::iota(all.begin(), all.end(), 0);
    const Eigen::Vector3d centre = anchor_of(all);
    Eigen::MatrixXd motions(unknowns_.count(), 7);
    for (int axis = 0; axis < 3; ++axis) motions.col(axis) = translation(all, axis);
    motions.col(3) = turn(all, -1, centre);
    motions.col(4) = dilation(all, centre);
    motions.col(5) = tumble(all, centre, 0);
    motions.col(6) = tumble(all, centre, 1);
    const Eigen::MatrixXd unit = open_.colwise().normalized();
    const Eigen::MatrixXd rest = unit - motions * motions.completeOrthogonalDecomposition().solve(unit);
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(rest, Eigen::ComputeThinU);
    const auto count = (svd.singularValues().array() > 1e-3).count();
    return svd.matrixU().leftCols(count);
  }

  int parts() const {
    std::set<int> parts;
    for (size_t i = 0; i < m_.ids.size(); ++i) parts.insert(part_[p_.point_blocks[i]]);
    return static_cast<int>(parts.size());
  }

  std::vector<Finding> name() {
    std::set<int> parts;
    for (size_t i = 0; i < m_.ids.size(); ++i) parts.insert(part_[p_.point_blocks[i]]);
    for (int part : parts) name_part(part, parts.size() > 1);
    name_rest();
    if (findings_.empty())
      findings_.push_back({Finding::Severity::error, "the normal matrix is singular; no datum holds the network", {}});
    return findings_;
  }

 private:
  std::vector<int> points_of(int part) const {
    std::vector<int> points;
    for (size_t i = 0; i < m_.ids.size(); ++i)
      if (part_[p_.point_blocks[i]] == part) points.push_back(static_cast<int>(i));
    return points;
  }

  Eigen::Vector3d now(int point) const {
    return Eigen::Map<const Eigen::Vector3d>(p_.problem.parameters[p_.point_blocks[point]].value.data());
  }

  void put(Eigen::VectorXd& v, int block, int component, double value) const {
    const int unknown = unknowns_(block, component);
    if (unknown >= 0) v[unknown] = value;
  }

  /// Does a movement of these points that turns orientations with it lie in the open directions?
  bool is_open(const Eigen::VectorXd& movement) const {
    if (movement.norm() == 0) return false;
    const Eigen::VectorXd fit = open_ * open_.completeOrthogonalDecomposition().solve(movement);
    return (movement - fit).norm() < 1e-4 * movement.norm();
  }

  Eigen::VectorXd translation(const std::vector<int>& points, int axis) const {
    Eigen::VectorXd v = Eigen::VectorXd::Zero(unknowns_.count());
    for (int i : points) put(v, p_.point_blocks[i], axis, 1);
    return v;
  }

  /// Rotation about a horizontal axis (0 east, 1 north): open where nothing knows the vertical.
  Eigen::VectorXd tumble(const std::vector<int>& points, const Eigen::Vector3d& centre, int axis) const {
    Eigen::VectorXd v = Eigen::VectorXd::Zero(unknowns_.count());
    for (int i : points) {
      const Eigen::Vector3d moved = Eigen::Vector3d::Unit(axis).cross(now(i) - centre);
      for (int k = 0; k < 3; ++k) put(v, p_.point_blocks[i], k, moved[k]);
    }
    return v;
  }

  /// Clockwise turn about the vertical through `centre`; part -1: of the whole network.
  Eigen::VectorXd turn(const std::vector<int>& points, int part, const Eigen::Vector3d& centre) const {
    Eigen::VectorXd v = Eigen::VectorXd::Zero(unknowns_.count());
    for (int i : points) {
      const Eigen::Vector3d d = now(i) - centre;
      put(v, p_.point_blocks[i], 0, d.y());
      put(v, p_.point_blocks[i], 1, -d.x());
    }
    for (int block : p_.orientation_blocks)
      if (block >= 0 && (part < 0 || part_[block] == part)) put(v, block, 0, 1);
    return v;
  }

  Eigen::VectorXd dilation(const std::vector<int>& points, const Eigen::Vector3d& centre) const {
    Eigen::VectorXd v = Eigen::VectorXd::Zero(unknowns_.count());
    for (int i : points)
      for (int k = 0; k < 3; ++k) put(v, p_.point_blocks[i], k, (now(i) - centre)[k]);
    return v;
  }

  void report(const std::string& text, const std::vector<int>& points, const Eigen::VectorXd& direction) {
    std::vector<std::string> ids;
    for (int i : points) ids.push_back(m_.ids[i]);
    findings_.push_back({Finding::Severity::error, text, ids});
    named_.conservativeResize(unknowns_.count(), named_.cols() + 1);
    named_.col(named_.cols() - 1) = direction;
  }

  void name_part(int part, bool several) {
    const std::vector<int> points = points_of(part);
    if (points.size() < 2) return;
    std::vector<std::string> ids;
    for (int i : points) ids.push_back(m_.ids[i]);
    const std::string of = several ? " of the part with " + join(ids, 5) : " of the network";
    static const char* const axes[] = {"east", "north", "height"};
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::VectorXd v = translation(points, axis);
      if (is_open(v)) report(std::string("translation in ") + axes[axis] + of + " is open", points, v);
    }
    name_turn(part, points, of);
    const Eigen::Vector3d anchor = anchor_of(points);
    const Eigen::VectorXd scale = dilation(points, anchor);
    if (is_open(scale)) report("scale" + of + " is open: there is no distance in it", points, scale);
  }

  /// Mean of the held points, else of all.
  Eigen::Vector3d anchor_of(const std::vector<int>& points) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero(), all = Eigen::Vector3d::Zero();
    int held = 0;
    for (int i : points) {
      all += now(i);
      if (m_.roles[i][0] != CoordinateRole::fixed) continue;
      sum += now(i);
      ++held;
    }
    return held > 0 ? Eigen::Vector3d(sum / held) : Eigen::Vector3d(all / static_cast<double>(points.size()));
  }

  void name_turn(int part, const std::vector<int>& points, const std::string& of) {
    // Held points lie on the axis if there are any: try each of them, then the centre.
    std::vector<Eigen::Vector3d> centres;
    std::vector<std::vector<int>> on_axis;
    for (int i : points)
      if (m_.roles[i][0] == CoordinateRole::fixed) {
        centres.push_back(now(i));
        break;
      }
    centres.push_back(anchor_of(points));
    for (const Eigen::Vector3d& centre : centres) {
      const Eigen::VectorXd v = turn(points, part, centre);
      if (!is_open(v)) continue;
      std::vector<std::string> ids;
      for (int i : points)
        if ((now(i) - centre).head<2>().norm() < 0.01) ids.push_back(m_.ids[i]);
      const std::string where =
          ids.empty() ? "E " + fixed_digits(centre.x(), 2) + ", N " + fixed_digits(centre.y(), 2) : join(ids, 5);
      report("rotation about the vertical through " + where + of + " is open", points, v);
      return;
    }
  }

  /// What whole-part movements do not explain belongs to single points or set-ups.
  void name_rest() {
    Eigen::MatrixXd rest = open_;
    if (named_.cols() > 0) rest -= named_ * named_.completeOrthogonalDecomposition().solve(rest);
    std::set<int> blocks;
    for (int c = 0; c < rest.cols(); ++c) {
      const double before = open_.col(c).norm();
      if (rest.col(c).norm() < 1e-3 * before) continue;
      const double largest = rest.col(c).cwiseAbs().maxCoeff();
      for (int u = 0; u < rest.rows(); ++u)
        if (std::abs(rest(u, c)) > 0.05 * largest) blocks.insert(unknowns_.block_of(u));
    }
    std::vector<std::string> names, points;
    for (int block : blocks) {
      const std::string& name = p_.problem.parameters[block].name;
      names.push_back(name);
      if (m_.index.contains(name)) points.push_back(name);
    }
    if (!names.empty())
      findings_.push_back({Finding::Severity::error, "not determined by the observations: " + join(names), points});
  }

  const NetworkModel& m_;
  const NetworkProblem& p_;
  adjustment::UnknownIndex unknowns_;
  Eigen::MatrixXd open_;
  std::vector<int> part_;
  Eigen::MatrixXd named_;
  std::vector<Finding> findings_;
};

std::string describe(const ResultRow& row) {
  return row.kind + " " + (row.from.empty() ? "" : row.from + " -> ") + row.to +
         (row.source.line > 0 ? " (" + row.source.file + ":" + std::to_string(row.source.line) + ")" : "");
}

bool is_angular(const ResultRow& row) {
  return row.kind == "direction" || row.kind == "zenith_angle" || row.kind == "angle" || row.kind == "azimuth";
}

std::string amount(const ResultRow& row, double value) {
  if (is_angular(row)) return fixed_digits(value * 200000 / std::acos(-1.0), 1) + " mgon";
  return fixed_digits(value * 1000, 1) + " mm";
}

void examine_rows(const NetworkResult& r, std::vector<Finding>& findings) {
  std::vector<std::string> uncontrolled, points;
  int weak = 0;
  for (const ResultRow& row : r.rows) {
    const double redundancy = row.statistics.redundancy_number;
    if (!row.removed && redundancy < 0.1) {
      uncontrolled.push_back(describe(row));
      points.push_back(row.to);
    }
    weak += !row.removed && redundancy >= 0.1 && redundancy < 0.3;
    if (row.flagged)
      findings.push_back({Finding::Severity::warning,
                          (row.removed ? "removed: " : "suspect: ") + describe(row) +
                              ", w = " + fixed_digits(row.statistics.w, 1) + ", probably wrong by " +
                              amount(row, row.statistics.estimated_blunder),
                          {row.from, row.to}});
  }
  if (!uncontrolled.empty() && r.degrees_of_freedom > 0)
    findings.push_back(
        {Finding::Severity::warning,
         std::to_string(uncontrolled.size()) +
             " observations are not controlled by others (a blunder in them would go unseen): " + join(uncontrolled, 6),
         points});
  if (weak > 0)
    findings.push_back({Finding::Severity::note,
                        std::to_string(weak) + " observations are weakly controlled (redundancy number below 0.3)",
                        {}});
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

void examine_control(const NetworkModel& m, const NetworkResult& r, std::vector<Finding>& findings) {
  if (m.datum != DatumMode::weighted) return;
  std::set<std::string> shifted;
  for (const ResultRow& row : r.rows)
    if (row.kind == "coordinate" && row.flagged) shifted.insert(row.to);
  for (const std::string& id : shifted)
    findings.push_back({Finding::Severity::warning,
                        "control point " + id +
                            " does not fit the observations: it may have moved, or its coordinates are another point's",
                        {id}});
}

}  // namespace

std::vector<Finding> name_defects(const NetworkModel& model, const NetworkProblem& problem,
                                  const Eigen::MatrixXd& directions) {
  return DefectNamer(model, problem, directions).name();
}

std::vector<Finding> name_local_defects(const NetworkModel& model, const NetworkProblem& problem,
                                        const Eigen::MatrixXd& null_space) {
  if (null_space.cols() == 0) return {};
  DefectNamer whole(model, problem, null_space);
  const Eigen::MatrixXd rest = whole.beyond_motions();
  if (rest.cols() == 0) return {};
  if (whole.parts() > 1) return whole.name();
  return DefectNamer(model, problem, rest).name();
}

std::vector<Finding> examine(const NetworkModel& model, const NetworkResult& result) {
  std::vector<Finding> findings;
  if (result.degrees_of_freedom == 0)
    findings.push_back({Finding::Severity::warning, "there is no redundancy: nothing controls the observations", {}});
  using Verdict = adjustment::GlobalTest::Verdict;
  const std::string sigma0 = fixed_digits(result.sigma0, 2);
  if (result.degrees_of_freedom > 0 && result.global_test.verdict == Verdict::high)
    findings.push_back({Finding::Severity::warning,
                        "global test fails: sigma0 " + sigma0 +
                            " is too large; there are blunders, or the assumed accuracies are too good",
                        {}});
  if (result.degrees_of_freedom > 0 && result.global_test.verdict == Verdict::low)
    findings.push_back({Finding::Severity::note,
                        "global test: sigma0 " + sigma0 + " is small; the assumed accuracies are too cautious",
                        {}});
  examine_rows(result, findings);
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
