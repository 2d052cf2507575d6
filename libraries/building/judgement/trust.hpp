// Whether the measurement behind a judgement stands: one law for anchors, panels and surfaces.
#pragma once

#include <vector>

#include "artifacts/block.hpp"
#include "artifacts/deviation.hpp"
#include "artifacts/survey_network.hpp"

namespace plumbline::judgement {

struct Trust {
  /// Why the measurement is not to be trusted: then nothing is decided.
  std::vector<MeasurementDoubtT> doubts;
  /// What of its model does not hold, with the command that mends it: uncertainties are larger for it.
  std::vector<MeasurementDoubtT> misfits;
  double factor = 1;  ///< by which all covariances are to be multiplied for the misfits
};

/// What fails a test that says so proves nothing (a doubt); what fits less well than it should is less certain, by what
/// its residuals say (a misfit). Null: there is none to ask.
Trust trust_of(const Block* block, const SurveyNetwork* network);

}  // namespace plumbline::judgement
