// Topics of what is no anchor's or panel's own: doubts, misfits, what anchors have in common, what was not judged;
// private to ifc/bcf*.cpp.
#pragma once

#include <string>
#include <vector>

#include "building/ifc/bcf_topic.hpp"
#include "building/ifc/findings.hpp"

namespace plumbline::ifc {

/// The issue of a finding, of its topic's id. That of a shift selects the anchors that share it, those that are open
/// first, and is looked at from before the facade of the first of them.
BcfIssue issue_of(const Finding& finding);

/// Selects anchors, and looks at those of the facade of the first; none: nothing is selected.
void show_together(const std::vector<const AnchorDeviationT*>& anchors, BcfIssue& issue);

/// What is to be looked for before this anchor is reset, as a sentence with a blank before it; empty: nothing.
std::string shared_by(const std::vector<Finding>& findings, const AnchorDeviationT& anchor);

}  // namespace plumbline::ifc
