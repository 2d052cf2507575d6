// Symmetric matrices as artifacts and files keep them: the lower triangle row by row, (0,0), (1,0), (1,1), (2,0) ...
#pragma once

#include <Eigen/Core>
#include <stdexcept>
#include <string>
#include <vector>

namespace plumbline {

/// Number of values of an n × n matrix.
constexpr std::size_t packed_size(std::size_t n) { return n * (n + 1) / 2; }

/// Reads the lower triangle; what stands above it is not looked at.
template <typename Derived>
std::vector<double> pack_symmetric(const Eigen::MatrixBase<Derived>& matrix) {
  std::vector<double> values;
  values.reserve(packed_size(static_cast<std::size_t>(matrix.rows())));
  for (Eigen::Index r = 0; r < matrix.rows(); ++r)
    for (Eigen::Index c = 0; c <= r; ++c) values.push_back(matrix(r, c));
  return values;
}

/// n × n from its packed values; 0 × 0 from none. Throws std::runtime_error that says what is wrong with the covariance
/// `of` whom ("camera 'c1'") for any other number of values.
inline Eigen::MatrixXd unpack_symmetric(const std::vector<double>& values, std::size_t n, const std::string& of) {
  if (values.empty()) return {};
  if (values.size() != packed_size(n))
    throw std::runtime_error("the covariance of " + of + " has " + std::to_string(values.size()) +
                             " values, expected " + std::to_string(packed_size(n)) + " for the lower triangle of " +
                             std::to_string(n) + " rows");
  Eigen::MatrixXd matrix(n, n);
  const double* value = values.data();
  for (Eigen::Index r = 0; r < matrix.rows(); ++r)
    for (Eigen::Index c = 0; c <= r; ++c) matrix(r, c) = matrix(c, r) = *value++;
  return matrix;
}

}  // namespace plumbline
