// Says in words which movements a network leaves open.
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <set>

#include "network_model.hpp"
#include "network_words.hpp"

namespace plumbline::survey {

namespace {

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

}  // namespace plumbline::survey
