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

/// What else was open than anchors (those are counted as not measured already) and was not closed for want of a
/// measurement, as warnings. Where all that was measured is in order it is as open as before: it is counted as not
/// judged, and the verdict of the whole is undecided. Of a campaign in part, or one in which something fails, the
/// verdict says so already.
std::vector<std::string> leave_open(const AsBuiltChangesT& changes, DeviationT& judged);

}  // namespace plumbline::judgement
