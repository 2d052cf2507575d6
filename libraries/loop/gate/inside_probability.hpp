// Probability that correlated normal values lie within their limits all at once.
#pragma once

#include <Eigen/Core>

namespace plumbline::loop {

/// P(low <= v <= high) for v normal about `mean` with `covariance`, which may be singular. Infinite limits are none.
/// Separation of variables after Genz (1992), with rows that depend on others folded into the variable that decides
/// them (Genz and Kwong 2000), the variables ordered by how narrow their limits are (Gibson, Glasbey and Elston 1994),
/// over a fixed lattice of Richtmyer with the baker's transform: the same bits each time. Points are added until the
/// mean of blocks of them has a standard deviation below `precision`, 2560 at most; the error stays below 0.003 for up
/// to twelve independent variables (tests/unit/loop). Values that are together outside with less than a fifth of
/// `precision` are left to themselves, and half of that taken away. Where bounds of Boole and of the least marginal are
/// closer than 0.001, their mean is taken instead. Zero variance: inside or not. nan if mean or covariance are not
/// finite.
double inside_probability(const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance, const Eigen::VectorXd& low,
                          const Eigen::VectorXd& high, double precision = 0.001);

/// Phi, and its inverse (Wichura 1988, AS 241); p is held inside [1e-300, 1 - 1e-16].
double normal_below(double x);
double normal_quantile(double p);

}  // namespace plumbline::loop
