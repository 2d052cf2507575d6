// Directions, zenith angles and distances of a survey network and tags of photographs, in one least-squares system.
//
// The unknowns are the marks y that both see (anchors of control plates), the network's other unknowns n (stations,
// orientations, marks that carry no plate) and the block's other unknowns b (poses, plates' rotations, camera, ...).
// The sum of squares is S(y, n) + I(y, b). It is minimised without forming the joint normal matrix, and is exactly the
// same:
//
//   1. S is linearised at the current (y, n). Its own minimum (ŷ, n̂) and the cofactors Q there say all of it:
//      S = S_min + (x − x̂)ᵀ Q⁻¹ (x − x̂). For given y the best n is n̂ + Q_ny Q_yy⁻¹ (y − ŷ), and what is left is
//      S_min + (y − ŷ)ᵀ Q_yy⁻¹ (y − ŷ): known coordinates of the marks with their full covariance.
//   2. The block is adjusted with these as control: y and b minimise the sum with S linearised.
//   3. n follows from y as above, S is linearised anew there, until nothing moves.
//
// A fixed point of this has the gradient of I by b zero, that of S by n zero, and those of both by y opposite: it is a
// stationary point of the sum. The covariance that the block then has of y and b is that of the joint system, because
// Q_yy⁻¹ is the Schur complement that eliminates n from it; that of all network unknowns x follows from
// Q_xx − K Q_yx + K C_yy Kᵀ with K = Q_xy Q_yy⁻¹ and C_yy from the block.
//
// The first pass is the adjustment in two steps with full covariance. The joint one differs from it by the weights, if
// variance components are estimated (of the images, and of the survey as one group), and by what the relinearisation
// moves, which is of second order: in a simulated storey with distances of a millimetre at ten metres at most 2 µm,
// with a tenth of that noise less than 0.1 µm.
#pragma once

#include <string>
#include <vector>

#include "geometry/frame_graph.hpp"
#include "photo/block/tag_block.hpp"
#include "survey/adjust/kept_network.hpp"

namespace plumbline::joint {

struct JointOptions {
  block::TagBlockOptions block;           ///< weighting by covariance, with control
  bool estimate_survey_variance = false;  ///< one factor for all readings (Förstner 1979)
  int max_iterations = 20;
};

/// A mark of the network that carries a plate.
struct Mark {
  std::string id;
  int plate = 0;  ///< index into TagBlock::plates
};

struct JointResult {
  /// As of adjust_tag_block(). In `groups` and the totals the survey stands with all its readings, as "survey". With
  /// robust_control marks whose plates contradict are adjusted as points of the survey alone.
  block::TagBlockResult block;
  int iterations = 0;          ///< relinearisations of the network
  double survey_variance = 1;  ///< by which the readings' a priori variances were multiplied
  std::vector<std::string> survey_ids;
  Eigen::VectorXd survey_positions;   ///< 3n of the network's points in its frame [m]
  Eigen::MatrixXd survey_covariance;  ///< 3n × 3n [m²]; zero for coordinates that are held
  /// What the readings say without the photographs, at these weights, of the points that have all three coordinates: in
  /// the frame of the block, with what the transform is uncertain by. What the model is to be compared with.
  std::vector<std::string> surveyed_ids;
  FramePoints surveyed;
  /// Readings whose test fails, largest first; with all marks, whatever is left out.
  std::vector<survey::KeptNetwork::Conspicuous> conspicuous;
};

/// `network` is adjusted already and ends where the joint adjustment has it. `block_from_survey` is exact, or of known
/// covariance. `block.control` is ignored: the marks are the control. Throws std::runtime_error: what
/// adjust_tag_block() throws, fewer than three marks, lambda weighting, no convergence.
JointResult adjust_jointly(const block::TagBlock& block, const std::vector<Mark>& marks, survey::KeptNetwork& network,
                           const FrameLink& block_from_survey, const JointOptions& options);

}  // namespace plumbline::joint
