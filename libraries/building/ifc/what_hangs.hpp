// What hangs at anchors and is called neither a panel nor anything else: what is part of a fixing is no panel, and what
// may be a panel is not passed over without a word.
#pragma once

#include <functional>
#include <set>
#include <string>

#include "building/ifc/design.hpp"

namespace plumbline::ifc {

/// Kinds of plates (PredefinedType, IFC4X3) that are parts of a fixing or of steelwork: no panels, wherever they are.
bool is_fixing_plate(const std::string& kind);

/// Panels of which nothing says whether they are panels or parts of the fixing: small plates of no said kind that stand
/// by themselves. Three or more that follow one another in one plane with a joint between each two are a field of
/// panels: base plates stand apart, or side by side in pairs.
std::set<const Element*> may_be_fixings(const Design& design);

/// Anchors that hold no panel, or only what may be a part of the fixing.
std::set<const Element*> bare_anchors(Design& design);

/// Takes small plates of no said kind, at whose anchors something much larger hangs, for parts of the fixing and not
/// for panels; a warning says so.
void leave_out_fixing_plates(Design& design);

/// Whether an element of this class may be a panel though its class does not say it: windows, doors, proxies,
/// assemblies, members, parts.
bool may_hang(const std::string& ifc_class);

/// Elements that may hang, flat and upright, at anchors that hold no panel, are counted as not judged. `read` is called
/// for those whose shape is not known yet, only where there are such anchors; `fills` says whether a wall's opening
/// holds it (by Element::instance).
void tell_what_hangs(Design& design, const std::function<void(Element&)>& read,
                     const std::function<bool(std::uint64_t)>& fills);

}  // namespace plumbline::ifc
