#include "geometry/frame_graph.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <map>
#include <stdexcept>

namespace plumbline {

namespace {

using Matrix37 = Eigen::Matrix<double, 3, 7>;

/// Change of p_to = S R p_from + t by (rotation vector in `to`, translation, scale) at a fixed p_from.
Matrix37 by_parameters(const FrameLink& link, const Eigen::Vector3d& p_to) {
  const Eigen::Vector3d scales(link.scale, link.scale, link.plan_only ? 1.0 : link.scale),
      turned = (p_to - link.to_from_from.translation).cwiseQuotient(scales);
  Matrix37 change;
  change.leftCols<3>() = -(scales.asDiagonal() * skew(turned));
  change.middleCols<3>(3).setIdentity();
  change.col(6) = turned;
  if (link.plan_only) change(2, 6) = 0;
  return change;
}

FramePoints through(const FrameGraph::Step& step, const FramePoints& given) {
  const FrameLink& link = *step.link;
  const auto n = static_cast<Eigen::Index>(given.positions.size());
  const Eigen::Matrix3d linear = step.backwards ? link.linear().inverse() : link.linear();
  FramePoints out;
  Eigen::MatrixXd common(3 * n, 7);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Vector3d& p = given.positions[i];
    out.positions.push_back(step.backwards ? link.apply_inverse(p) : link.apply(p));
    // Backwards p_to is held: 0 = S R dp + B dx, so dp = -(S R)^-1 B dx.
    if (step.backwards)
      common.middleRows<3>(3 * i) = -linear * by_parameters(link, p);
    else
      common.middleRows<3>(3 * i) = by_parameters(link, out.positions.back());
  }
  if (given.covariance.size() == 0) return out;
  out.covariance = given.covariance;
  for (Eigen::Index i = 0; i < n; ++i)
    out.covariance.middleRows<3>(3 * i) = (linear * out.covariance.middleRows<3>(3 * i)).eval();
  for (Eigen::Index i = 0; i < n; ++i)
    out.covariance.middleCols<3>(3 * i) = (out.covariance.middleCols<3>(3 * i) * linear.transpose()).eval();
  out.covariance += common * link.covariance * common.transpose();
  return out;
}

}  // namespace

Eigen::Matrix3d FrameLink::linear() const {
  const Eigen::Vector3d scales(scale, scale, plan_only ? 1.0 : scale);
  return scales.asDiagonal() * to_from_from.rotation.toRotationMatrix();
}

Eigen::Vector3d FrameLink::apply(const Eigen::Vector3d& p_from) const {
  return linear() * p_from + to_from_from.translation;
}

Eigen::Vector3d FrameLink::apply_inverse(const Eigen::Vector3d& p_to) const {
  const Eigen::Vector3d scales(1 / scale, 1 / scale, plan_only ? 1.0 : 1 / scale);
  return to_from_from.rotation.conjugate() * (scales.asDiagonal() * (p_to - to_from_from.translation));
}

std::vector<std::string> FrameGraph::frames() const {
  std::vector<std::string> names;
  for (const FrameLink& link : links_)
    for (const std::string* name : {&link.from, &link.to})
      if (std::find(names.begin(), names.end(), *name) == names.end()) names.push_back(*name);
  return names;
}

std::vector<FrameGraph::Step> FrameGraph::way(const std::string& to, const std::string& from) const {
  std::map<std::string, std::vector<Step>> ways{{from, {}}};
  std::vector<std::string> reached{from};  // breadth first: the first way to a frame is the shortest
  for (std::size_t k = 0; k < reached.size(); ++k)
    for (const FrameLink& link : links_)
      for (const bool backwards : {false, true}) {
        const std::string &start = backwards ? link.to : link.from, &end = backwards ? link.from : link.to;
        if (start != reached[k] || ways.count(end)) continue;
        ways[end] = ways[start];
        ways[end].push_back({&link, backwards});
        reached.push_back(end);
      }
  if (const auto found = ways.find(to); found != ways.end()) return found->second;
  std::string names;
  for (const std::string& name : reached) names += (names.empty() ? "'" : ", '") + name + "'";
  throw std::runtime_error("no transform leads from the frame '" + from + "' to '" + to +
                           "'; from there one can reach " + names);
}

FramePoints FrameGraph::express(const FramePoints& points, const std::string& to, const std::string& from) const {
  FramePoints result = points;
  for (const Step& step : way(to, from)) result = through(step, result);
  return result;
}

}  // namespace plumbline
