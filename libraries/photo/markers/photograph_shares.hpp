// What each photograph by itself says of the unknowns that all photographs share. In an adjustment whose photographs
// meet only in what is kept, each adds a score and an information to the reduced normal equations, once its pose is
// eliminated. What any part of the photographs would give, what leaving one out changes, and how much they scatter
// follows from these without another adjustment, to first order.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "photo/bundle/cofactors.hpp"

namespace plumbline::markers {

struct PhotographShare {
  std::vector<int> columns;     ///< kept unknowns it depends on, ascending; effects follow from kept_count on
  Eigen::VectorXd score;        ///< slope of −½ vᵀPv in these, the pose eliminated
  Eigen::MatrixXd information;  ///< normal matrix of these, the pose eliminated
  Eigen::MatrixXd pose_by;      ///< how the estimated pose moves with these, the photograph's observations as they are
};

/// Some whitened rows of a photograph.
struct PhotographRows {
  int photograph = 0;
  std::vector<int> columns;    ///< kept unknowns they depend on, each once
  Eigen::MatrixXd kept, own;   ///< derivatives of the computed values by these, and by the pose
  Eigen::VectorXd misclosure;  ///< observed minus computed
  Eigen::MatrixXd effects;     ///< derivatives by what the model does not have (rolling shutter); empty: not asked for
};

/// One share for each photograph.
std::vector<PhotographShare> shares_of(int photographs, int kept_count, const std::vector<PhotographRows>& rows);

/// The same of a block at `state`, with the effects of effects_at(). All images have a pose of their own; kept unknowns
/// are the others in the order of the layout. `heights`: of each camera's image [px].
std::vector<PhotographShare> shares_of(const bundle::Problem& problem, const bundle::Layout& layout,
                                       const bundle::State& state, const std::vector<int>& heights);

/// Of the nine values of a camera among the kept unknowns of such a block; −1 for those held.
std::vector<int> interior_columns(const bundle::Problem& problem, const bundle::Layout& layout, int camera);

/// Cofactors of all of its kept unknowns.
Eigen::MatrixXd kept_cofactor(const bundle::Problem& problem, const bundle::Layout& layout,
                              const bundle::Cofactors& cofactors);

/// How the kept unknowns `wanted` move when this photograph is left out, to first order but with its leverage:
/// −(N − Nᵢ)⁻¹ gᵢ. `cofactor`: of all kept unknowns. Source: Cook and Weisberg (1982), 3.8; the leverage is that of a
/// whole photograph.
Eigen::VectorXd change_without(const PhotographShare& share, const Eigen::MatrixXd& cofactor,
                               const std::vector<int>& wanted);

}  // namespace plumbline::markers
