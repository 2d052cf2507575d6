#include "build/loop/bracket_covariance.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <map>
#include <stdexcept>

#include "geometry/linear_algebra/decompositions.hpp"
#include "geometry/packed_symmetric.hpp"

namespace plumbline::loop {
namespace {

/// The covariance of the measured anchors if control were known: that of the readings alone. What is left is the same
/// for all campaigns on that control, and a little more: control as it was adjusted with these readings.
void add_own(const Eigen::MatrixXd& all, const std::map<std::string, Eigen::Index>& point,
             const std::vector<Eigen::Index>& at, const std::vector<std::string>& control, FacadeInput& in) {
  std::vector<Eigen::Index> known, anchors;
  std::size_t found = 0;
  for (const std::string& id : control)
    if (const auto place = point.find(id); place != point.end()) {
      ++found, in.control.push_back(id);
      for (Eigen::Index k = 0; k < 3; ++k) known.push_back(3 * place->second + k);
    }
  if (found == 0) return;
  for (const Eigen::Index place : at)
    for (Eigen::Index k = 0; k < 3; ++k) anchors.push_back(place < 0 ? 0 : 3 * place + k);
  const linear_algebra::SymmetricEigen of_control(all(known, known));
  const double largest = std::max(0.0, of_control.eigenvalues().maxCoeff());
  Eigen::MatrixXd across = all(anchors, known) * of_control.eigenvectors();
  for (std::size_t b = 0; b < at.size(); ++b)
    if (at[b] < 0) across.middleRows<3>(3 * static_cast<Eigen::Index>(b)).setZero();
  Eigen::MatrixXd own = in.facade.covariance;
  for (Eigen::Index i = 0; i < across.cols(); ++i)
    if (const double value = of_control.eigenvalues()[i]; value > 1e-9 * largest && value > 0)
      own -= across.col(i) * across.col(i).transpose() / value;
  in.facade.own = 0.5 * (own + own.transpose());
}

}  // namespace

void add_covariance(const PointsT& model, const std::vector<const AnchorDeviationT*>& anchors,
                    const std::vector<std::string>& control, FacadeInput& in) {
  const std::size_t n = in.facade.brackets.size();
  in.facade.covariance = Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(n), 3 * static_cast<Eigen::Index>(n));
  const Eigen::MatrixXd all = unpack_symmetric(model.covariance, 3 * model.points.size(), "the model");
  if (all.size() == 0 || !all.allFinite())
    throw std::runtime_error("the model has no covariance: without it nothing can be said of how a panel will hang");
  std::map<std::string, Eigen::Index> point;
  for (std::size_t i = 0; i < model.points.size(); ++i) point[model.points[i]->id] = static_cast<Eigen::Index>(i);
  std::vector<Eigen::Index> at(n, -1);
  for (std::size_t b = 0; b < n; ++b) {
    const auto found = point.find(in.facade.brackets[b].id);
    if (found != point.end()) at[b] = found->second;
    if (in.facade.brackets[b].measured() && at[b] < 0)
      throw std::runtime_error("anchor " + in.facade.brackets[b].id +
                               " was judged, but is no point of 'model'; connect the points that were judged");
  }
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j)
      if (at[i] >= 0 && at[j] >= 0)
        in.facade.covariance.block<3, 3>(3 * static_cast<Eigen::Index>(i), 3 * static_cast<Eigen::Index>(j)) =
            all.block<3, 3>(3 * at[i], 3 * at[j]);
  add_own(all, point, at, control, in);
  // Where plates sit on their anchors is part of the judged covariance, and not of the model's.
  for (std::size_t b = 0; b < n; ++b)
    if (anchors[b]->covariance.size() == 9)
      in.facade.covariance.block<3, 3>(3 * static_cast<Eigen::Index>(b), 3 * static_cast<Eigen::Index>(b)) =
          Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(anchors[b]->covariance.data());
}

}  // namespace plumbline::loop
