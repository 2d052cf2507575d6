// Topics of the campaign before, closed by a new measurement or carried on; private to ifc/bcf*.cpp.
#pragma once

#include <vector>

#include "building/ifc/bcf_topic.hpp"

namespace plumbline::ifc {

/// Where an issue of an anchor or panel lies and is looked at from: element, floor, place, size and frame. No words.
BcfIssue placed_issue(const AnchorDeviationT& anchor);
BcfIssue placed_issue(const PanelDeviationT& panel);

/// Gives the issues that were open before a comment on how they came, and adds those that are closed now, and those
/// that were open and that nobody measured again. `options.changes` must be given.
void add_changes(const DeviationT& deviation, const BcfOptions& options, std::vector<BcfIssue>& issues);

}  // namespace plumbline::ifc
