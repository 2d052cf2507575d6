// Known points as the readings alone have them, from the network that is adjusted with them: what a free network of its
// own would say, without its start, its iterations, its order of elimination and its tests.
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "least_squares/problem/defects.hpp"
#include "least_squares/problem/marginal.hpp"
#include "survey/adjust/adjuster.hpp"

namespace plumbline::survey {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr std::size_t kMost = 200;  // known points: what is left of the system is one matrix of theirs

/// Residual blocks that are coordinates of control.
std::vector<char> control_blocks(const NetworkModel& m, const NetworkProblem& problem,
                                 const least_squares::Linearisation& lin) {
  std::set<int> rows;  // of the model
  for (std::size_t g = 0; g < m.survey.coordinates.size(); ++g)
    if (m.survey.coordinates[g].is_control) rows.insert(m.first_row_of_group[g]);
  std::vector<char> out;
  for (const auto& block : lin.blocks) out.push_back(rows.contains(problem.rows[block.row]));
  return out;
}

/// Whether what is open moves the points as one figure. Parts that share nothing but known points would each move by
/// themselves: a free network of them is not determined, and there is nothing to compare.
bool is_a_datum(const MatrixXd& null_space, const std::vector<least_squares::NamedPoint>& points,
                const std::vector<Index>& rows) {
  constexpr double kSame = 1e-4;
  if (null_space.cols() == 0) return true;
  const MatrixXd motions = least_squares::motion_basis(points, least_squares::centre_of(points))(rows, Eigen::all);
  const MatrixXd unit = motions.colwise().norm().cwiseMax(1e-12).cwiseInverse().asDiagonal();
  const auto basis = MatrixXd(motions * unit).colPivHouseholderQr();
  for (Index k = 0; k < null_space.cols(); ++k) {
    const Eigen::VectorXd direction = null_space.col(k).normalized();
    if ((motions * unit * basis.solve(direction) - direction).norm() > kSame) return false;
  }
  return true;
}

}  // namespace

MeasuredControl Adjuster::measured_control(Pass& pass) const {
  MeasuredControl result;
  const std::set<std::string> known = known_ids(m_);
  if (known.size() < 3 || known.size() > kMost) return result;
  if (m_.datum == DatumMode::inner || pass.solution.datum.defect() > 0) return result;
  std::vector<least_squares::Component> components;
  std::vector<least_squares::NamedPoint> points;
  std::vector<Index> rows;
  for (std::size_t i = 0; i < m_.ids.size(); ++i) {
    if (!known.contains(m_.ids[i])) continue;
    const int block = pass.problem.point_blocks[i];
    const auto& value = pass.problem.problem.parameters[block].value;
    for (int c = 0; c < 3; ++c) {
      if (m_.roles[i][c] == CoordinateRole::unused) continue;
      components.push_back({block, c});
      rows.push_back(static_cast<Index>(3 * points.size()) + c);
    }
    points.push_back({m_.ids[i], {value[0], value[1], value[2]}});
  }
  const auto marginal = least_squares::marginal_of(
      pass.problem.problem, pass.solution, control_blocks(m_, pass.problem, pass.solution.linearisation), components);
  if (!marginal || !is_a_datum(marginal->null_space, points, rows)) return result;
  const auto n = static_cast<Index>(3 * points.size());
  result.coordinates = Eigen::VectorXd::Constant(n, kNotGiven);
  result.covariance = MatrixXd::Constant(n, n, kNotGiven);
  result.coordinates(rows) = marginal->values;
  const bool scale = options_.scale_with_sigma0 == Switch::on ||
                     (options_.scale_with_sigma0 == Switch::automatic && m_.survey.info.use_a_posteriori_sigma0);
  const int degrees = marginal->degrees_of_freedom;
  result.covariance(rows, rows) = marginal->cofactors * (scale && degrees > 0 ? marginal->sum_of_squares / degrees : 1);
  result.defect = static_cast<int>(marginal->null_space.cols());
  result.sum_of_squares = marginal->sum_of_squares, result.degrees_of_freedom = degrees;
  for (const auto& p : points) result.ids.push_back(p.name);
  return result;
}

}  // namespace plumbline::survey
