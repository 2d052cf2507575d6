// The judgement as a workbook: anchors, panels, floors, and what was asked for, in English or German.
#pragma once

#include <string>
#include <vector>

#include "artifacts/deviation.hpp"
#include "show/report/workbook.hpp"

namespace plumbline::report {

enum class Language { english, german };

/// A word of the workbook in both languages.
struct Word {
  const char *english, *german;
};
/// All of them, for the test that none is missing.
const std::vector<Word>& workbook_words();

/// Anchors and panels in the order in which they are to be mended; lengths in mm, coordinates in m.
std::vector<Sheet> deviation_sheets(const DeviationT& deviation, Language language);

}  // namespace plumbline::report
