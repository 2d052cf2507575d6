// The same readings handed over twice: a file named twice, a copy under another name, a download of noon and one of the
// evening. Counted twice they would make the network look as if it were measured twice.
#pragma once

#include <string>
#include <vector>

#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

/// Takes every set-up out whose readings all stand in another one too (same kinds, targets, faces and values, at least
/// three that are not zero), or in one of another file with more or fewer digits (the one with fewer goes), the
/// readings without a set-up of a file likewise, and the points that nothing speaks of any more. A file of which
/// nothing else is left goes out as a whole. Returns a sentence about each pair of files.
std::vector<std::string> take_out_repeated_readings(std::vector<SurveyObservations>& surveys);

}  // namespace plumbline::survey
