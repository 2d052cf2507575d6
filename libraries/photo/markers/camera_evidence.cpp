#include "photo/markers/camera_evidence.hpp"

#include <algorithm>
#include <numeric>

#include "base/text/name_order.hpp"

namespace plumbline::markers {

Eigen::Matrix2d effects_at(const Eigen::Vector2d& pixel, int height) {
  return (pixel.y() / height - 0.5) * Eigen::Matrix2d::Identity();
}

CameraEvidence evidence_of(const std::vector<PhotographShare>& shares, const Eigen::MatrixXd& cofactor, double factor,
                           const std::vector<int>& columns, const std::vector<int>& members,
                           const std::vector<std::string>& paths) {
  CameraEvidence evidence;
  std::vector<int> wanted;
  for (std::size_t k = 0; k < columns.size(); ++k)
    if (columns[k] >= 0) evidence.parameters.push_back(static_cast<int>(k)), wanted.push_back(columns[k]);
  evidence.formal = factor * cofactor(wanted, wanted);
  std::vector<std::size_t> order(members.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return text::before_by_name(paths[a], paths[b]); });
  const auto kept = static_cast<int>(cofactor.rows());
  for (int e = 0; e < effect_count; ++e) wanted.push_back(kept + e);
  const auto n = static_cast<Eigen::Index>(wanted.size());
  for (const std::size_t k : order) {
    const PhotographShare& share = shares[members[k]];
    evidence.paths.push_back(paths[k]), evidence.members.push_back(members[k]);
    Eigen::VectorXd score = Eigen::VectorXd::Zero(n);
    Eigen::MatrixXd information = Eigen::MatrixXd::Zero(n, n);
    std::vector<Eigen::Index> at;
    for (const int column : wanted) {
      const auto found = std::lower_bound(share.columns.begin(), share.columns.end(), column);
      const bool there = found != share.columns.end() && *found == column;
      at.push_back(there ? found - share.columns.begin() : -1);
    }
    for (Eigen::Index i = 0; i < n; ++i) {
      if (at[i] < 0) continue;
      score(i) = share.score(at[i]) / factor;
      for (Eigen::Index j = 0; j < n; ++j)
        if (at[j] >= 0) information(i, j) = share.information(at[i], at[j]) / factor;
    }
    evidence.score.push_back(score), evidence.information.push_back(information);
    const std::vector<int> parameters(wanted.begin(), wanted.end() - effect_count);
    evidence.change_without.push_back(change_without(share, cofactor, parameters));
  }
  return evidence;
}

Eigen::MatrixXd in_nine(const CameraEvidence& evidence, const Eigen::MatrixXd& of_estimated) {
  Eigen::MatrixXd nine = Eigen::MatrixXd::Zero(BrownCamera::parameter_count, BrownCamera::parameter_count);
  for (std::size_t i = 0; i < evidence.parameters.size(); ++i)
    for (std::size_t j = 0; j < evidence.parameters.size(); ++j)
      nine(evidence.parameters[i], evidence.parameters[j]) =
          of_estimated(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
  return nine;
}

}  // namespace plumbline::markers
