// What, of the mistakes that are made with whole files, would explain readings that do not fit: each is a hypothesis,
// and its counter-test is the same network with the mistake undone. Only what explains nearly everything, where without
// it a good part does not fit, is named; the mending is the user's.
#pragma once

#include <string>
#include <vector>

#include "survey/model/adjust_options.hpp"

namespace plumbline::survey {

struct Cause {
  std::string text;                 ///< "the zenith angles are counted from the horizon", with what was tested
  std::vector<std::string> points;  ///< concerned
  SurveyObservations mended;        ///< the survey as it would be
  ControlPoints control;            ///< likewise
};

/// The hypotheses that stand the counter-test, the best first; none if the set-ups agree with each other and with the
/// known points. Angles in another unit or sense or from another zero (of all set-ups or one), one name on two marks,
/// control with axes exchanged, mirrored, with a zone number, in another unit, or on another level.
std::vector<Cause> find_causes(const SurveyObservations& survey, const AdjustOptions& options,
                               const ControlPoints& control);

}  // namespace plumbline::survey
