// Sentences of the judgement hold lengths in millimetres rounded to 0.1 mm. In inches they are made anew from what was
// rounded, or a length would read otherwise in a sentence than in its own row.
#pragma once

#include <string>

#include "artifacts/deviation.hpp"

namespace plumbline::report {

/// PanelDeviation.reason in the units spoken.
std::string reason_of(const PanelDeviationT& panel, const DeviationT& deviation);
/// CommonShift.words in the units spoken.
std::string words_of(const CommonShiftT& shift);
/// GroupShift.words in the units spoken.
std::string words_of(const GroupShiftT& shift, const DeviationT& deviation);

}  // namespace plumbline::report
