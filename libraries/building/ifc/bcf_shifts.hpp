// Topics of what floors, facades, columns or the whole building have in common; private to ifc/bcf*.cpp.
#pragma once

#include <string>
#include <vector>

#include "building/ifc/bcf_topic.hpp"

namespace plumbline::ifc {

/// One issue for each significant shift of which some anchor is open, that of the whole building first. It selects the
/// anchors of the group, those that are open first, and is looked at from before the facade of the first of them. Of
/// grid axes and print batches a deviation does not know the anchors: they have words alone.
std::vector<BcfIssue> shift_issues(const DeviationT& deviation);

/// What is to be looked for before this anchor is reset, as a sentence with a blank before it; empty: nothing.
std::string shared_by(const DeviationT& deviation, const AnchorDeviationT& anchor);

}  // namespace plumbline::ifc
