// What each photograph by itself says of the unknowns that all photographs share. In an adjustment whose photographs
// meet only in what is kept, each adds a score and an information to the reduced normal equations, once its pose is
// eliminated. What any part of the photographs would give, what leaving one out changes, and how much they scatter
// follows from these without another adjustment, to first order.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "least_squares/problem/schur.hpp"

namespace plumbline::markers {

struct PhotographShare {
  std::vector<int> columns;     ///< kept unknowns it depends on, ascending; effects follow from kept_count on
  Eigen::VectorXd score;        ///< slope of −½ vᵀPv in these, the pose eliminated
  Eigen::MatrixXd information;  ///< normal matrix of these, the pose eliminated
};

/// One share for each eliminated block of `system`, at its linearisation point. `effects`: for each of
/// system.observations the derivative of its whitened computed rows by what the model does not have (rolling shutter),
/// rows × the number of effects, or empty: all without.
std::vector<PhotographShare> shares_of(const least_squares::PartitionedSystem& system,
                                       const std::vector<Eigen::MatrixXd>& effects = {});

/// How the kept unknowns `wanted` move when this photograph is left out, to first order but with its leverage:
/// −(N − Nᵢ)⁻¹ gᵢ. `cofactor`: of all kept unknowns. Source: Cook and Weisberg (1982), 3.8; the leverage is that of a
/// whole photograph.
Eigen::VectorXd change_without(const PhotographShare& share, const Eigen::MatrixXd& cofactor,
                               const std::vector<int>& wanted);

}  // namespace plumbline::markers
