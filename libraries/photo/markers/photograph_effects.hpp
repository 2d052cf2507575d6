// What photographs have of their own beside the noise of their corners, as a linear mixed model of their scores.
//
// A photograph's score u (slope of its log-likelihood in the camera's parameters and the rows, its pose eliminated) and
// its information J say how far its own camera lies from the common one: E u = J δ, Cov u = f J + J T J. δ is a change
// (weights of the photographs times directions), what goes with the place it was taken from (a board that is not quite
// the model looks alike from neighbouring places) and what the common parameters leave; T is what scatters from
// photograph to photograph: principal distance, principal point, rows that are read while the camera moves. One
// likelihood holds all of it, so that nothing is blamed on one effect that another explains as well.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "photo/markers/camera_evidence.hpp"
#include "plumbline/rigid_transform.hpp"

namespace plumbline::markers {

/// How strong the effects are, as logarithms: rms of the principal distance from photograph to photograph (relative),
/// of the principal point [px], of the rows from the first to the last [px]; variance factor of the corners; what goes
/// with the place, in units of EffectModel::place_sizes.
struct Strengths {
  enum Kind { focus, principal_point, rows, factor, place, count };
  Eigen::Array<double, count, 1> log = {-7, -0.7, -0.7, 0.4, -1.2};
  double of(Kind kind) const { return std::exp(log(kind)); }
};

/// Photographs that differ by `weights` times a step along `directions` (columns, in the model's units), of normal
/// prior with `sizes` as standard deviations.
struct Step {
  Eigen::VectorXd weights;
  Eigen::MatrixXd directions;
  Eigen::VectorXd sizes;
};

/// The evidence, scaled so that it is well conditioned.
class EffectModel {
 public:
  /// `cam_from_object`: poses in the order of the evidence.
  EffectModel(const CameraEvidence& evidence, const BrownCamera& camera,
              const std::vector<RigidTransform>& cam_from_object);

  std::size_t size() const { return scores_.size(); }
  /// Of the photographs: line of sight (two columns), roll, distance; mean 0, rms 1, those that differ.
  const std::vector<Eigen::VectorXd>& places() const { return places_; }
  /// Root of the covariance of what each photograph has of its own at `strengths`, in the units of the evidence: own
  /// columns, of variance 1, which no other photograph shares.
  std::vector<Eigen::MatrixXd> own_roots(const Strengths& strengths) const;
  /// The same of what goes with the place: columns that all photographs share.
  std::vector<Eigen::MatrixXd> common_roots(const Strengths& strengths) const;
  /// A direction in the nine parameters, in the model's units; those that are not estimated are left out.
  Eigen::VectorXd direction(const std::array<double, 9>& nine) const;

 private:
  friend class EffectFit;
  int parameters_ = 0;
  std::array<int, 9> place_of_{};  // of each of the nine in the scores, -1 if held
  Eigen::VectorXd scale_;
  std::vector<Eigen::VectorXd> scores_;
  std::vector<Eigen::MatrixXd> information_;
  double squares_ = 0;             // Σ uᵀ J⁺ u
  double ranks_ = 0;               // Σ rank J, of what is well determined
  Eigen::MatrixXd effects_;        // directions of focus, principal point (2), rows (2)
  Eigen::MatrixXd place_effects_;  // directions of what goes with the place
  std::vector<Eigen::VectorXd> places_;
};

struct StepFit {
  double gain = 0;            ///< of the logarithm of the marginal likelihood over no step
  Eigen::VectorXd by, sigma;  ///< the step and its standard deviations
};

/// The model at given strengths.
class EffectFit {
 public:
  EffectFit(const EffectModel& model, const Strengths& strengths);

  double log_likelihood() const { return log_likelihood_; }  ///< marginal, without a step
  StepFit fit(const Step& step) const;
  /// Slope and information of each photograph's logarithm of the likelihood along `directions`, at the common camera.
  void own_scores(const Eigen::MatrixXd& directions, std::vector<Eigen::VectorXd>& scores,
                  std::vector<Eigen::MatrixXd>& information) const;
  /// What each photograph by itself says of a step along `directions`: estimates, one a row, and how well they are
  /// known.
  void own_steps(const Eigen::MatrixXd& directions, Eigen::MatrixXd& steps, Eigen::VectorXd& information) const;

 private:
  const EffectModel& model_;
  std::vector<Eigen::VectorXd> scores_;  // u (J + J T J)⁻¹ J, and below its information
  std::vector<Eigen::MatrixXd> information_;
  std::vector<Eigen::MatrixXd> of_place_;  // information_ · place_effects_
  Eigen::MatrixXd cofactor_;               // of the common parameters and of what goes with the place
  Eigen::VectorXd common_;                 // their estimates
  double log_likelihood_ = 0;
};

struct Optimum {
  Strengths strengths;
  double log_likelihood = 0;
};

/// The strengths of largest likelihood, with `step` if it is given; those of `without` are held at nothing. By steps
/// along one after the other, which halve.
Optimum most_likely(const EffectModel& model, const Strengths& start, const Step* step = nullptr,
                    const std::vector<Strengths::Kind>& without = {});

}  // namespace plumbline::markers
