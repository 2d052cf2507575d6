// The judgement as a workbook: anchors, panels, floors, and what was asked for, in English or German.
#pragma once

#include <string>
#include <vector>

#include "artifacts/deviation.hpp"
#include "show/report/language.hpp"
#include "show/report/workbook.hpp"

namespace plumbline::report {

/// Anchors and panels in the order in which they are to be mended; lengths in mm, coordinates in m, whatever is spoken.
std::vector<Sheet> deviation_sheets(const DeviationT& deviation, Language language);

}  // namespace plumbline::report
