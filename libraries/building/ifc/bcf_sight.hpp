// From where something can be seen: the building stands before it, or it is inside of a wall.
#pragma once

#include <string>
#include <vector>

#include "building/ifc/bcf_surroundings.hpp"
#include "building/ifc/bcf_topic.hpp"

namespace plumbline::ifc {

/// How a topic is looked at.
struct BcfView {
  FacadeFrame frame;                   ///< `out` points to the camera
  std::vector<const Element*> hidden;  ///< what the view must leave out, panels among them
  std::string words;                   ///< what a reader should know of it; empty: it is seen from before, freely
};

/// What stands farther before the issue than this is cut away: scaffolds, trees, the other side of a narrow court [m].
double clipped_beyond(const BcfIssue& issue);

/// The issue with the middle and the size of its element, where that is larger than what is seen around its point.
BcfIssue with_its_shape(const BcfIssue& issue, const BcfSurroundings& surroundings);

/// From before if nothing of the design stands in the way, else obliquely or from behind, the first that is free.
/// Panels and other anchors are hidden and never in the way. Where no view is free, that with the least in the way, and
/// what it is is hidden. Elements are as large as the boxes of their shapes here: what is called free is free, but
/// beside what has no box.
BcfView free_view(const BcfIssue& issue, const BcfSurroundings& surroundings);

}  // namespace plumbline::ifc
