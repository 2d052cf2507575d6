// What a floor, a facade, a column or the whole building has in common, in words, the same for the page, summary, IFC,
// BCF, JUnit and the sheets: one cause in place of many bad anchors.
#pragma once

#include <string>
#include <vector>

#include "artifacts/deviation.hpp"

namespace plumbline::ifc {

/// A sentence for each significant shift, that of the whole building first, then the clearest.
inline std::vector<std::string> shift_words(const DeviationT& deviation) {
  std::vector<std::string> words;
  if (deviation.common_shift && deviation.common_shift->significant) words.push_back(deviation.common_shift->words);
  for (const auto& group : deviation.group_shifts)
    if (group->significant) words.push_back(group->words);
  return words;
}

/// The sentence without how many share it and what to do: "Floor 2 hangs 12.0 mm ± 0.9 mm low"; an older record has the
/// whole of it alone. `Shift`: CommonShiftT or GroupShiftT.
template <class Shift>
const std::string& shift_in_short(const Shift& shift) {
  return shift.finding.empty() ? shift.words : shift.finding;
}

}  // namespace plumbline::ifc
