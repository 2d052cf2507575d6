#include "building/judgement/linear_length.hpp"

#include <algorithm>
#include <cmath>

#include "building/judgement/figures.hpp"

namespace plumbline::judgement {
namespace {

constexpr double kNoPart = 1e-9;

}  // namespace

void LinearLength::add(const LinearLength& other, double factor) {
  for (const auto& [at, row] : other.anchors)
    anchors.try_emplace(at, Eigen::RowVector3d::Zero()).first->second += factor * row;
  for (const auto& [at, value] : other.unmeasured) unmeasured[at] += factor * value;
  std::erase_if(anchors, [](const auto& entry) { return entry.second.norm() < kNoPart; });
  std::erase_if(unmeasured, [](const auto& entry) { return std::abs(entry.second) < kNoPart; });
}

double LengthBasis::value(const LinearLength& length) const {
  double sum = 0;
  for (const auto& [at, row] : length.anchors)
    sum += row.dot(deviations.difference.segment<3>(3 * static_cast<Eigen::Index>(at)));
  return sum;
}

double LengthBasis::covariance(const LinearLength& a, const LinearLength& b) const {
  if (deviations.covariance.size() == 0) return nan;
  double sum = 0;
  for (const auto& [i, row_i] : a.anchors)
    for (const auto& [j, row_j] : b.anchors)
      sum += row_i * deviations.covariance.block(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) *
             row_j.transpose();
  for (const auto& [at, factor] : a.unmeasured)
    if (const auto other = b.unmeasured.find(at); other != b.unmeasured.end())
      sum += factor * other->second * variances[at];
  return sum;
}

}  // namespace plumbline::judgement
