// Known points against the network that is to be tied to them: the observations are adjusted as a free network, and the
// given coordinates are compared with it like another epoch. A point whose coordinates are wrong, or that has moved,
// shows here before it bends the network.
#pragma once

#include "survey/adjust/adjust_network.hpp"
#include "survey/epochs/compare_epochs.hpp"

namespace plumbline::survey {

struct ControlCheck {
  std::string problem;    ///< why nothing could be tested; empty: `comparison` holds
  Comparison comparison;  ///< first: as given; second: as measured
  int free_motions = 0;
  std::string cause;  ///< of a misfit that all points share: another unit, axes exchanged; empty if none is plain
};

/// The points of an adjusted network with their full covariance, in its order; of `only` these, if there are any.
Epoch epoch_of(const NetworkResult& network, const std::vector<std::string>& only = {});

/// Control are `control` and the points that the files hold fixed with complete coordinates. Never throws NetworkError:
/// what cannot be tested is said in `problem`. Where an adjustment on control has `measured` already what its readings
/// alone say, that is compared, and nothing is adjusted: `adjustment` has no meaning then.
ControlCheck check_control(const SurveyObservations& survey, const ControlPoints& control, AdjustOptions adjustment,
                           ComparisonOptions options, const MeasuredControl& measured = {});

/// The same of points that an adjustment holds without error, so that it has no differences of theirs to show (see
/// compare_with_known): what its readings alone say of them, largest difference first. None where nothing can be said.
std::vector<KnownPoint> compare_with_held(const SurveyObservations& survey, const ControlPoints& control,
                                          const NetworkResult& adjusted);

/// What two networks with these rank defects may differ by, as ComparisonOptions::free_motions; `epoch` says whether
/// they have plan positions and heights.
int merged_motions(int first_defect, int second_defect, const Epoch& epoch);

}  // namespace plumbline::survey
