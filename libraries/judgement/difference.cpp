#include "judgement/difference.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <stdexcept>

namespace plumbline::evaluate {

std::map<std::string, std::size_t> index_points(const PointSet& points, const std::string& what) {
  if (points.ids.size() != points.positions.size())
    throw std::runtime_error(what + " points: " + std::to_string(points.ids.size()) + " ids but " +
                             std::to_string(points.positions.size()) + " positions");
  const auto expected = static_cast<Eigen::Index>(3 * points.ids.size());
  const Eigen::MatrixXd& s = points.covariance;
  if (s.size() != 0 && (s.rows() != expected || s.cols() != expected))
    throw std::runtime_error(what + " points: the covariance is " + std::to_string(s.rows()) + " x " +
                             std::to_string(s.cols()) + ", expected " + std::to_string(expected) + " x " +
                             std::to_string(expected) + " for " + std::to_string(points.ids.size()) + " points");
  std::map<std::string, std::size_t> index;
  for (std::size_t i = 0; i < points.ids.size(); ++i)
    if (!index.emplace(points.ids[i], i).second)
      throw std::runtime_error(what + " points: '" + points.ids[i] + "' occurs twice; ids must be unique");
  return index;
}

Eigen::VectorXd DifferenceSet::heights() const {
  Eigen::VectorXd z(size());
  for (Eigen::Index i = 0; i < z.size(); ++i) z[i] = difference[3 * i + 2];
  return z;
}

Eigen::MatrixXd DifferenceSet::height_covariance() const {
  if (covariance.size() == 0) return {};
  const auto n = static_cast<Eigen::Index>(size());
  Eigen::MatrixXd s(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) s(i, j) = covariance(3 * i + 2, 3 * j + 2);
  return s;
}

DifferenceSet DifferenceSet::subset(const std::vector<std::size_t>& positions) const {
  const auto n = static_cast<Eigen::Index>(positions.size());
  DifferenceSet part;
  part.difference.resize(3 * n);
  if (covariance.size() != 0) part.covariance.resize(3 * n, 3 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto from = static_cast<Eigen::Index>(positions[static_cast<std::size_t>(i)]);
    part.anchors.push_back(anchors[static_cast<std::size_t>(from)]);
    part.difference.segment<3>(3 * i) = difference.segment<3>(3 * from);
    for (Eigen::Index j = 0; j < n && covariance.size() != 0; ++j)
      part.covariance.block<3, 3>(3 * i, 3 * j) =
          covariance.block<3, 3>(3 * from, 3 * static_cast<Eigen::Index>(positions[static_cast<std::size_t>(j)]));
  }
  return part;
}

namespace {

using Index = Eigen::Index;

/// Blocks of a covariance for two lists of points.
template <typename Row, typename Column>
Eigen::MatrixXd blocks(const Eigen::MatrixXd& s, const std::vector<Match>& rows, Row row,
                       const std::vector<Match>& columns, Column column) {
  Eigen::MatrixXd out(3 * static_cast<Index>(rows.size()), 3 * static_cast<Index>(columns.size()));
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t j = 0; j < columns.size(); ++j)
      out.block<3, 3>(3 * static_cast<Index>(i), 3 * static_cast<Index>(j)) =
          s.block<3, 3>(3 * static_cast<Index>(row(rows[i])), 3 * static_cast<Index>(column(columns[j])));
  return out;
}

/// Pseudo-inverse of a symmetric matrix: the survey of a free network has a singular covariance.
Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& s) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(s);
  const double limit = 1e-10 * eigen.eigenvalues().cwiseAbs().maxCoeff();
  Eigen::VectorXd inverse = eigen.eigenvalues();
  for (Index i = 0; i < inverse.size(); ++i) inverse[i] = inverse[i] > limit ? 1.0 / inverse[i] : 0.0;
  return eigen.eigenvectors() * inverse.asDiagonal() * eigen.eigenvectors().transpose();
}

}  // namespace

DifferenceCovariance difference_covariance(const PointSet& model, const PointSet& survey,
                                           const std::vector<Match>& matches, const std::vector<Match>& control) {
  const auto of_model = [](const Match& m) { return m.model; };
  const auto of_survey = [](const Match& m) { return m.reference; };
  const Eigen::MatrixXd sum = blocks(model.covariance, matches, of_model, matches, of_model) +
                              blocks(survey.covariance, matches, of_survey, matches, of_survey);
  if (control.empty() || matches.empty()) return {sum, true};
  const Eigen::MatrixXd gain = blocks(model.covariance, matches, of_model, control, of_model) *
                               pseudo_inverse(blocks(survey.covariance, control, of_survey, control, of_survey));
  const Eigen::MatrixXd cross = gain * blocks(survey.covariance, control, of_survey, matches, of_survey);
  const Eigen::MatrixXd s = sum - cross - cross.transpose();
  const Eigen::MatrixXd symmetric = 0.5 * (s + s.transpose());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(symmetric);
  // An adjustment may add a little to the control's variances (a hundredth of a millimetre, to keep weights finite), so
  // small negative eigenvalues are zeros; a thousandth of the largest variance is more than that and means that C is
  // wrong.
  if (eigen.eigenvalues().minCoeff() < -1e-3 * sum.diagonal().maxCoeff()) return {sum, false};
  const Eigen::VectorXd kept = eigen.eigenvalues().cwiseMax(0);
  return {eigen.eigenvectors() * kept.asDiagonal() * eigen.eigenvectors().transpose(), true};
}

}  // namespace plumbline::evaluate
