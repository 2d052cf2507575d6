// A network after its adjustment, kept with its equations: it can be asked what its readings alone say from any place
// nearby, and moved there, as somebody does who adjusts it together with other observations of its points.
#pragma once

#include <string>
#include <vector>

#include "survey/network/network_model.hpp"

namespace plumbline::survey {

class KeptNetwork {
 public:
  /// `problem` and `solution` as they were left by the adjustment, whose covariances are
  /// multiplied by `variance_factor`.
  KeptNetwork(const NetworkModel& model, NetworkProblem problem, least_squares::Solution solution,
              double variance_factor);

  const std::vector<std::string>& ids() const { return ids_; }
  bool has(const std::string& id) const;
  Eigen::Vector3d position(const std::string& id) const;     ///< E, N, H where it is now [m]; NaN: does not exist
  std::array<int, 3> unknowns(const std::string& id) const;  ///< numbers of its coordinates; -1: held
  int unknown_count() const { return solution_.unknowns.count(); }
  int observations() const { return solution_.linearisation.rows; }
  int degrees_of_freedom() const { return solution_.degrees_of_freedom(); }
  double variance_factor() const { return variance_factor_; }
  double sum_of_squares() const { return solution_.sum_of_squares(); }  ///< v'Pv where it is now, a priori weights

  /// What the readings say, linearised where the network is now and in its datum.
  struct Estimate {
    Eigen::VectorXd step;       ///< to their own minimum, one per unknown
    Eigen::MatrixXd cofactors;  ///< there, a priori weights
    double sum_of_squares = 0;  ///< v'Pv there
  };
  Estimate estimate();

  void move(const Eigen::VectorXd& step) { least_squares::move(problem_.problem, solution_, step); }

  /// A reading whose normalised residual is large: row of the adjustment, in words, with its w.
  struct Conspicuous {
    std::string what;
    double w = 0;
  };
  /// Readings with |w| above `critical` where the network is now, largest first, if its unknowns have these cofactors
  /// and the readings' variances are `variance` times those a priori.
  std::vector<Conspicuous> conspicuous(const Eigen::MatrixXd& cofactors, double variance, double critical) const;

 private:
  int number(const std::string& id) const;  ///< throws std::out_of_range
  std::vector<std::string> ids_;
  std::vector<ResultRow> rows_;
  std::vector<std::array<CoordinateRole, 3>> roles_;
  NetworkProblem problem_;
  least_squares::Solution solution_;
  double variance_factor_;
};

}  // namespace plumbline::survey
