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

/// Control are `control` and the points that the files hold fixed with complete coordinates; those without a standard
/// deviation may be rounded to millimetres (rounding_variance). Never throws NetworkError:
/// what cannot be tested is said in `problem`. Where an adjustment on control has `measured` already what its readings
/// alone say, that is compared, and nothing is adjusted: `adjustment` has no meaning then.
ControlCheck check_control(const SurveyObservations& survey, const ControlPoints& control, AdjustOptions adjustment,
                           ComparisonOptions options, const MeasuredControl& measured = {});

/// The same of an adjusted network that has `measured_control`, as survey.check_control would tell it: where it fails
/// though each known point stands by itself, that is a finding, a sound network is doubtful, and true comes back.
bool doubt_failed_control(const SurveyObservations& survey, const ControlPoints& control, double known_sigma,
                          NetworkResult& adjusted);

/// What two networks with these rank defects may differ by, as ComparisonOptions::free_motions; `epoch` says whether
/// they have plan positions and heights.
int merged_motions(int first_defect, int second_defect, const Epoch& epoch);

}  // namespace plumbline::survey
