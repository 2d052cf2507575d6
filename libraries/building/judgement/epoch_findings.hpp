// Findings of campaigns that are no anchor's or panel's own, from one to the next; private to judgement/.
#pragma once

#include <vector>

#include "building/judgement/epochs.hpp"

namespace plumbline::judgement {

/// Those of this campaign, then those of `before` (null: none) that are open still by `changes`, or were once.
std::vector<EpochFinding> findings_kept(const DeviationT& deviation, const EpochRecord* before,
                                        const AsBuiltChangesT* changes);

}  // namespace plumbline::judgement
