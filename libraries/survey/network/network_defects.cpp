// Says in words which movements a network leaves open.
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <set>

#include "geometry/linear_algebra/decompositions.hpp"
#include "survey/network/network_model.hpp"
#include "survey/network/network_parts.hpp"
#include "survey/words/network_words.hpp"

namespace plumbline::survey {

namespace {

class DefectNamer {
 public:
  DefectNamer(const NetworkModel& model, const NetworkProblem& problem, const Eigen::MatrixXd& directions)
      : m_(model), p_(problem), unknowns_(problem.problem), open_(directions), part_(parts_of(problem)) {
    for (size_t i = 0; i < m_.ids.size(); ++i)
      for (int axis = 0; axis < 3; ++axis)
        if (m_.roles[i][axis] == CoordinateRole::fixed) held_.insert({static_cast<int>(i), axis});
    for (const CoordinateGroup& g : m_.survey.coordinates)
      for (const auto& c : g.components) held_.insert({m_.index.at(c.point), c.axis});
  }

  /// What of the open directions is not a movement of the network as a whole, as an orthonormal basis: 0 columns if
  /// nothing.
  Eigen::MatrixXd beyond_motions() const {
    const Eigen::MatrixXd motions = whole_motions();
    const Eigen::MatrixXd unit = open_.colwise().normalized();
    const Eigen::MatrixXd rest = unit - motions * linear_algebra::minimum_norm_solution(motions, unit);
    const linear_algebra::SingularValues svd(rest, Eigen::ComputeThinU);
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
    name_hinges();
    name_rest(open_);
    if (findings_.empty())
      findings_.push_back({Finding::Severity::error, "the normal matrix is singular; no datum holds the network", {}});
    return findings_;
  }

  /// The same of a free network in one piece, whose movements as a whole are no defects.
  std::vector<Finding> name_local() {
    const Eigen::MatrixXd motions = whole_motions();
    for (Eigen::Index c = 0; c < motions.cols(); ++c)
      if (is_open(motions.col(c))) remember(motions.col(c));
    name_hinges();
    name_rest(open_);
    return findings_;
  }

 private:
  Eigen::MatrixXd whole_motions() const {
    std::vector<int> all(m_.ids.size());
    std::iota(all.begin(), all.end(), 0);
    const Eigen::Vector3d centre = anchor_of(all);
    Eigen::MatrixXd motions(unknowns_.count(), 7);
    for (int axis = 0; axis < 3; ++axis) motions.col(axis) = translation(all, axis);
    motions.col(3) = turn(all, orientations_of(all), centre);
    motions.col(4) = dilation(all, centre);
    motions.col(5) = rotation(all, centre, Eigen::Vector3d::UnitX());
    motions.col(6) = rotation(all, centre, Eigen::Vector3d::UnitY());
    return motions;
  }

  bool holds(int point, int axis) const { return held_.contains({point, axis}); }

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
    if (movement.norm() == 0 || open_.cols() == 0) return false;
    const Eigen::VectorXd fit = open_ * linear_algebra::minimum_norm_solution(open_, movement);
    return (movement - fit).norm() < 1e-4 * movement.norm();
  }

  Eigen::VectorXd translation(const std::vector<int>& points, int axis) const {
    Eigen::VectorXd v = Eigen::VectorXd::Zero(unknowns_.count());
    for (int i : points) put(v, p_.point_blocks[i], axis, 1);
    return v;
  }

  /// About an axis that is not vertical: open where nothing knows the vertical.
  Eigen::VectorXd rotation(const std::vector<int>& points, const Eigen::Vector3d& centre,
                           const Eigen::Vector3d& axis) const {
    Eigen::VectorXd v = Eigen::VectorXd::Zero(unknowns_.count());
    for (int i : points) {
      const Eigen::Vector3d moved = axis.cross(now(i) - centre);
      for (int k = 0; k < 3; ++k) put(v, p_.point_blocks[i], k, moved[k]);
    }
    return v;
  }

  /// Orientation unknowns that turn with these points: of set-ups on them, or on `hinge` if all they sight is of them.
  std::vector<int> orientations_of(const std::vector<int>& points, int hinge = -1) const {
    std::set<std::string> ids;
    for (int i : points) ids.insert(m_.ids[i]);
    std::vector<char> turns(p_.orientation_blocks.size(), 0);
    for (size_t s = 0; s < turns.size(); ++s)
      turns[s] =
          ids.contains(m_.survey.set_ups[s].station) || (hinge >= 0 && m_.survey.set_ups[s].station == m_.ids[hinge]);
    if (hinge >= 0)
      for (const MeanObservation& mean : m_.observations)
        if (const Observation& o = mean.observation; o.set_up >= 0 && o.from == m_.ids[hinge] && !ids.contains(o.to))
          turns[o.set_up] = 0;
    std::vector<int> blocks;
    for (size_t s = 0; s < turns.size(); ++s)
      if (turns[s] && p_.orientation_blocks[s] >= 0) blocks.push_back(p_.orientation_blocks[s]);
    return blocks;
  }

  /// Clockwise turn about the vertical through `centre`.
  Eigen::VectorXd turn(const std::vector<int>& points, const std::vector<int>& orientations,
                       const Eigen::Vector3d& centre) const {
    Eigen::VectorXd v = Eigen::VectorXd::Zero(unknowns_.count());
    for (int i : points) {
      const Eigen::Vector3d d = now(i) - centre;
      put(v, p_.point_blocks[i], 0, d.y());
      put(v, p_.point_blocks[i], 1, -d.x());
    }
    for (int block : orientations) put(v, block, 0, 1);
    return v;
  }

  Eigen::VectorXd dilation(const std::vector<int>& points, const Eigen::Vector3d& centre) const {
    Eigen::VectorXd v = Eigen::VectorXd::Zero(unknowns_.count());
    for (int i : points)
      for (int k = 0; k < 3; ++k) put(v, p_.point_blocks[i], k, (now(i) - centre)[k]);
    return v;
  }

  void remember(const Eigen::VectorXd& direction) {
    named_.conservativeResize(unknowns_.count(), named_.cols() + 1);
    named_.col(named_.cols() - 1) = direction;
  }
  /// Nothing that was named already says it.
  bool is_new(const Eigen::VectorXd& movement) const {
    if (named_.cols() == 0) return true;
    const Eigen::VectorXd fit = named_ * linear_algebra::minimum_norm_solution(named_, movement);
    return (movement - fit).norm() > 1e-3 * movement.norm();
  }
  std::vector<std::string> names_of(const std::vector<int>& points) const {
    std::vector<std::string> ids;
    for (int i : points) ids.push_back(m_.ids[i]);
    return ids;
  }
  void report(const std::string& text, const std::vector<int>& points, const Eigen::VectorXd& direction) {
    findings_.push_back({Finding::Severity::error, text, names_of(points)});
    remember(direction);
  }

  void name_part(int part, bool several) {
    const std::vector<int> points = points_of(part);
    if (points.size() < 2) return;
    const std::string of = several ? " of the part with " + join(names_of(points), 5) : " of the network";
    if (several && name_loose_part(points)) return;
    static const char* const axes[] = {"east", "north", "height"};
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::VectorXd v = translation(points, axis);
      if (is_open(v))
        report(std::string("translation in ") + axes[axis] + of + " is open" +
                   (axis == 1   ? " (give the position of a point in it)"
                    : axis == 2 ? " (give the height of a point in it)"
                                : ""),
               points, v);
    }
    name_turn(points, of);
    name_tilt(points, of);
    const Eigen::VectorXd scale = dilation(points, anchor_of(points));
    if (is_open(scale))
      report("scale" + of + " is open: there is no distance in it and no second control point", points, scale);
    name_combined(points, of);
  }

  /// One sentence for a part that nothing ties to the others or to control.
  bool name_loose_part(const std::vector<int>& points) {
    std::vector<Eigen::VectorXd> movements;
    for (int axis = 0; axis < 3; ++axis)
      if (const Eigen::VectorXd v = translation(points, axis); v.norm() > 0) movements.push_back(v);
    if (movements.size() < 2) return false;
    movements.push_back(turn(points, orientations_of(points), anchor_of(points)));
    if (!std::all_of(movements.begin(), movements.end(), [&](const Eigen::VectorXd& v) { return is_open(v); }))
      return false;
    for (const Eigen::VectorXd& v : movements) remember(v);
    findings_.push_back(
        {Finding::Severity::error,
         "place and rotation of the part with " + join(names_of(points), 5) +
             " are open: it shares no point with the rest of the network or with control (2 are needed)",
         names_of(points)});
    return true;
  }

  /// Mean of the held points, else of all.
  Eigen::Vector3d anchor_of(const std::vector<int>& points) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero(), all = Eigen::Vector3d::Zero();
    int held = 0;
    for (int i : points) {
      all += now(i);
      if (!holds(i, 0)) continue;
      sum += now(i);
      ++held;
    }
    return held > 0 ? Eigen::Vector3d(sum / held) : Eigen::Vector3d(all / static_cast<double>(points.size()));
  }

  void name_turn(const std::vector<int>& points, const std::string& of) {
    // Held points lie on the axis if there are any: try the first of them, then the centre.
    std::vector<Eigen::Vector3d> centres;
    for (int i : points)
      if (holds(i, 0)) {
        centres.push_back(now(i));
        break;
      }
    centres.push_back(anchor_of(points));
    for (const Eigen::Vector3d& centre : centres) {
      const Eigen::VectorXd v = turn(points, orientations_of(points), centre);
      if (!is_open(v)) continue;
      std::vector<std::string> ids;
      for (int i : points)
        if (holds(i, 0) && (now(i) - centre).head<2>().norm() < 0.01) ids.push_back(m_.ids[i]);
      const std::string where =
          ids.empty() ? "E " + fixed_digits(centre.x(), 2) + ", N " + fixed_digits(centre.y(), 2) : join(ids, 5);
      report("rotation about the vertical through " + where + of + " is open (give " +
                 (ids.empty()       ? ""
                  : ids.size() == 1 ? "a second control point or "
                                    : "a control point off this line or ") +
                 "an azimuth)",
             points, v);
      return;
    }
  }

  /// Distances alone know no vertical.
  void name_tilt(const std::vector<int>& points, const std::string& of) {
    std::vector<int> held;
    for (int i : points)
      if (holds(i, 0) || holds(i, 2)) held.push_back(i);
    const Eigen::Vector3d centre = held.empty() ? anchor_of(points) : now(held.front());
    const Eigen::VectorXd east = rotation(points, centre, Eigen::Vector3d::UnitX());
    const Eigen::VectorXd north = rotation(points, centre, Eigen::Vector3d::UnitY());
    if (is_open(east) && is_open(north) && is_new(east) && is_new(north)) {
      remember(east);
      report("tilt" + of + " about any horizontal axis" + (held.empty() ? "" : " through " + m_.ids[held.front()]) +
                 " is open: nothing in it tells the vertical (give three points in height that are not on a line, or "
                 "zenith "
                 "angles)",
             points, north);
      return;
    }
    if (held.size() < 2) return;
    const Eigen::Vector3d axis = now(held.back()) - centre;
    if (axis.norm() < 1e-3) return;
    const Eigen::VectorXd v = rotation(points, centre, axis.normalized());
    if (is_open(v) && is_new(v))
      report("rotation" + of + " about the line through " + join(names_of(held), 5) +
                 " is open (give a control point off this line)",
             points, v);
  }

  /// Movements of the whole that are open only together, such as a shift along the only sight to a control point.
  void name_combined(const std::vector<int>& points, const std::string& of) {
    if (open_.cols() == 0) return;
    const Eigen::Vector3d centre = anchor_of(points);
    Eigen::MatrixXd motions(unknowns_.count(), 4);
    for (int axis = 0; axis < 3; ++axis) motions.col(axis) = translation(points, axis);
    motions.col(3) = turn(points, orientations_of(points), centre);
    // A movement is not of the whole if a held point would have to take part in it.
    const Eigen::MatrixXd unseen = open_ * linear_algebra::minimum_norm_solution(open_, motions) - motions;
    const linear_algebra::SingularValues svd(unseen, Eigen::ComputeFullV);
    int count = 0;
    for (int c = 0; c < 4; ++c) {
      const Eigen::VectorXd v = motions * svd.matrixV().col(c);
      if (v.norm() < 1e-9 || !is_open(v) || !is_new(v)) continue;
      remember(v);
      ++count;
    }
    if (count > 0)
      findings_.push_back({Finding::Severity::error,
                           std::to_string(count) + " further movement" + (count > 1 ? "s" : "") + of +
                               " as a whole (shift and rotation together) " + (count > 1 ? "are" : "is") +
                               " open: too little ties it to its control points",
                           names_of(points)});
  }

  /// Parts that turn about the one point they share with the rest.
  void name_hinges() {
    const std::vector<std::set<int>> neighbours = neighbours_of(p_);
    for (int hinge = 0; hinge < static_cast<int>(m_.ids.size()); ++hinge) {
      const auto groups = groups_behind(hinge, neighbours);
      if (groups.size() < 2) continue;
      for (const std::vector<int>& group : groups) name_hinge(hinge, group);
    }
  }

  void name_hinge(int hinge, const std::vector<int>& group) {
    const Eigen::VectorXd v = turn(group, orientations_of(group, hinge), now(hinge));
    if (!is_open(v) || !is_new(v)) return;
    std::vector<std::string> set_ups;
    for (const SetUp& s : m_.survey.set_ups)
      if (std::any_of(group.begin(), group.end(), [&](int i) { return m_.ids[i] == s.station; }))
        set_ups.push_back(s.id);
    const std::string part = set_ups.empty()       ? "the part with " + join(names_of(group), 5)
                             : set_ups.size() == 1 ? "set-up " + set_ups[0]
                                                   : "the part with set-ups " + join(set_ups, 5);
    report(
        part + " shares only 1 point (" + m_.ids[hinge] +
            ") with the rest of the network: its rotation about the vertical through it is open (2 shared points are "
            "needed, 3 for control)",
        group, v);
  }

  /// What these movements do not explain belongs to single points or set-ups.
  void name_rest(Eigen::MatrixXd rest) {
    const Eigen::VectorXd before = rest.colwise().norm().transpose();
    if (named_.cols() > 0) rest -= named_ * linear_algebra::minimum_norm_solution(named_, rest);
    std::set<int> blocks;
    for (int c = 0; c < rest.cols(); ++c) {
      if (rest.col(c).norm() < 1e-3 * before[c]) continue;
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
  least_squares::UnknownIndex unknowns_;
  Eigen::MatrixXd open_;
  std::vector<int> part_;
  Eigen::MatrixXd named_;
  std::set<std::pair<int, int>> held_;  ///< point and axis: coordinates that are fixed or observed
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
  return whole.name_local();
}

}  // namespace plumbline::survey
