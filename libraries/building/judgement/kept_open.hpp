// What passes now and was not mended: the frame has moved under it, or may have.
#pragma once

#include <array>
#include <set>
#include <string>
#include <vector>

#include "artifacts/as_built_changes.hpp"
#include "artifacts/deviation.hpp"
#include "building/judgement/epoch_movements.hpp"

namespace plumbline::judgement {

/// What was open and passes stays open where all anchors moved alike (AsBuiltChanges.together), or where it moved as
/// the anchors of its floor, facade, column or of the whole did that were in order before: nobody resets those. A panel
/// does so where all its anchors do that were measured twice.
void keep_open_for_the_frame(const std::vector<MeasuredTwice>& pairs, const DeviationT& after, AsBuiltChangesT& out);

using KeptItem = std::array<std::string, 4>;  // kind, id, guid, topic

/// What passes and was not closed, because of how anchors have moved.
std::set<KeptItem> items_kept_open(const AsBuiltChangesT* changes);

}  // namespace plumbline::judgement
