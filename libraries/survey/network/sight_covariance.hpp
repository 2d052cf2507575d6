// Readings of one set-up share where target and instrument stood. Each is displaced from its mark by one amount for all
// that is read meanwhile, so that direction, zenith angle and distance of a sight, what is read to it again, and the
// angles of a station correlate:
//   covariance = diag(instrument's own) + sum over marks of J C J',
// J the change of the readings by the displacement of a mark, C its covariance: centring squared in E and N, height
// centring squared in H. The displacement of a target that one block alone depends on is eliminated by it, exactly
// (Niemeier, Ausgleichungsrechnung, 8.3); that of an instrument over a mark, which all sights of a set-up see, is an
// unknown with a prior (reading_sigmas.hpp).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "survey/network/network_model.hpp"
#include "survey/network/reading_sigmas.hpp"

namespace plumbline::survey {

/// Covariance [rad, m] of mean observations of one block; of a set-up: to one target.
Eigen::MatrixXd sight_covariance(const NetworkModel& model, const ReadingSigmas& sigmas,
                                 const std::vector<int>& members);

/// Of vectors, with the factors of a geocentric group, each vector in the horizon of its start [m^2].
Eigen::MatrixXd covariance_of(const VectorGroup& group, const NetworkModel& model);
/// Of a point measured with the profile's angles and distance, in the frame that its `position` is in [m^2].
Eigen::Matrix3d polar_covariance(const Eigen::Vector3d& position, const InstrumentProfile& profile);

}  // namespace plumbline::survey
