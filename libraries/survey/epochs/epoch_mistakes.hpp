// What one mistake in a whole epoch makes of another epoch: a ppm setting that was another, two names that were
// exchanged. Each would be movements of many points, or of metres; undone, fewer points have moved or none. A scale is
// told only where three points at least seem to have moved, it explains all of it, and without each of them too.
#pragma once

#include <optional>
#include <string>

#include "survey/epochs/compare_epochs.hpp"

namespace plumbline::survey {

struct EpochMistake {
  std::string words;      ///< without a full stop
  std::string undone;     ///< what was made of it, likewise
  Comparison comparison;  ///< with it undone
  int free_motions = 4;   ///< that it was made with
  bool is_undone = true;  ///< false (a scale): points that moved may look the same, the comparison stays as it is
};

/// The mistake that explains why points of `compared` seem to have moved, which is the comparison of both; none if none
/// does.
std::optional<EpochMistake> find_epoch_mistake(const Epoch& first, const Epoch& second,
                                               const ComparisonOptions& options, const Comparison& compared);

/// That points of `compared` moved as one body against its other_body, and what tells which of them stayed. Empty: no
/// such body.
std::string two_bodies_in_words(const Comparison& compared);

}  // namespace plumbline::survey
