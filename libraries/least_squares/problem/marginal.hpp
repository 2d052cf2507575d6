// What part of the observations say by themselves of some parameters, once all have been adjusted together: the
// readings of a network, without the coordinates that hold it, of the known points.
//
// The normal equations of the rest share pattern, order of elimination and place with those of the whole. With f the
// unknowns that are not asked about and c those that are, N_ff is what its factor is made of (where the coordinates
// were held as they are, it is the factor of the whole adjustment), and S = N_cc - N_cf N_ff^-1 N_fc, as small as c,
// says all the rest: what of it is singular is the datum that the rest alone lacks. Steps to its minimum are taken with
// the same factor (chord method).
#pragma once

#include <optional>
#include <vector>

#include "least_squares/problem/solver.hpp"

namespace plumbline::least_squares {

/// A tangent component of a parameter block without a `plus`; it may be held constant in the problem.
struct Component {
  int block = 0, component = 0;
};

struct Marginal {
  Eigen::VectorXd values;      ///< k, where the sum of squares of the rest is least and they have changed least
  Eigen::MatrixXd cofactors;   ///< k x k: the inverse of S, of its singular directions none
  Eigen::MatrixXd null_space;  ///< k x d, unscaled: what the rest leaves open
  double sum_of_squares = 0;   ///< of the rest, there
  int degrees_of_freedom = 0;
};

/// Of `components`, without the residual blocks that `left_out` marks (one per block). `problem` is as it was after
/// `solution`, and is so again afterwards. Nothing if the solution has a datum of its own, the other unknowns are not
/// determined without these blocks even where the components are held, or the minimum is too far for the factor.
std::optional<Marginal> marginal_of(Problem& problem, const Solution& solution, const std::vector<char>& left_out,
                                    const std::vector<Component>& components);

}  // namespace plumbline::least_squares
