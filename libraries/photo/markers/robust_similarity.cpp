#include "photo/markers/robust_similarity.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>

namespace plumbline::markers {
namespace {

using Points = std::vector<Eigen::Vector3d>;

bool on_one_line(const Points& points) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const auto& p : points) middle += p / static_cast<double>(points.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const auto& p : points) spread += (p - middle) * (p - middle).transpose();
  const Eigen::Vector3d values = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvalues();
  return !(values(1) > 1e-6 * values(2));
}

/// Visits all triples of n, or 2000 of them.
template <typename Visit>
void for_triples(size_t n, const Visit& visit) {
  constexpr size_t most = 2000;
  if (n * (n - 1) * (n - 2) / 6 <= most) {
    for (size_t i = 0; i < n; ++i)
      for (size_t j = i + 1; j < n; ++j)
        for (size_t k = j + 1; k < n; ++k) visit(i, j, k);
    return;
  }
  std::mt19937_64 random(1);
  for (size_t count = 0; count < most; ++count) {
    const size_t i = random() % n, j = random() % n, k = random() % n;
    if (i != j && j != k && i != k) visit(i, j, k);
  }
}

}  // namespace

RobustSimilarity fit_similarity_robustly(const Points& from, const Points& to, double tolerance) {
  const size_t n = from.size();
  if (n < 3) throw std::runtime_error(std::to_string(n) + " points, at least 3 are needed");
  if (on_one_line(to) || on_one_line(from)) throw std::runtime_error("all points lie on one line");
  RobustSimilarity result{fit_similarity(from, to, true), std::vector<double>(n), std::vector<bool>(n, true)};
  double lowest = std::numeric_limits<double>::infinity();
  std::vector<double> distances(n);
  const auto third = static_cast<std::ptrdiff_t>(2 * n / 3);
  if (n > 3)
    for_triples(n, [&](size_t i, size_t j, size_t k) {
      const double area = (to[j] - to[i]).cross(to[k] - to[i]).norm(),
                   sides = (to[j] - to[i]).squaredNorm() + (to[k] - to[i]).squaredNorm();
      if (area < 0.02 * sides) return;
      const SimilarityMotion motion = fit_similarity({from[i], from[j], from[k]}, {to[i], to[j], to[k]}, true);
      for (size_t m = 0; m < n; ++m) distances[m] = (motion * from[m] - to[m]).norm();
      std::nth_element(distances.begin(), distances.begin() + third, distances.end());
      if (distances[third] < lowest) lowest = distances[third], result.motion = motion;
    });
  if (lowest < std::numeric_limits<double>::infinity()) {
    Points good_from, good_to;
    for (size_t m = 0; m < n; ++m) {
      result.agrees[m] = (result.motion * from[m] - to[m]).norm() < std::max(5 * lowest, tolerance);
      if (result.agrees[m]) good_from.push_back(from[m]), good_to.push_back(to[m]);
    }
    if (good_from.size() >= 3 && !on_one_line(good_to)) result.motion = fit_similarity(good_from, good_to, true);
  }
  for (size_t m = 0; m < n; ++m) result.distances[m] = (result.motion * from[m] - to[m]).norm();
  return result;
}

}  // namespace plumbline::markers
