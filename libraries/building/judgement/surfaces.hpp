// Panels and joints against rules: flatness, bow, twist, steps, widths, each by its conformance probability.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "artifacts/design.hpp"
#include "artifacts/deviation.hpp"
#include "artifacts/surface_judgement.hpp"
#include "artifacts/surfaces.hpp"
#include "building/judgement/surface_rules.hpp"
#include "building/judgement/whose_surface.hpp"

namespace plumbline::judgement {

/// Every panel and joint that rules select, against the last rule that limits each quantity; of a joint, rules that
/// select either of its panels. `facts`: of the design's elements by GlobalId; a panel without is known by its name
/// alone. What is asked for and cannot be judged stands among the verdicts with its reason; in the requests stands of
/// every rule what of it is not judged, or not everywhere. A panel of `facts` that nobody looked at, because which of
/// its sides is outside is not known, is not judged either, nor is one whose surface may be something else's (see
/// whose_surface.hpp, `within` [m]), nor a joint at it.
///
/// Errors are normal with the stated covariance, random and systematic. Along a joint the probability of n places is
/// bounded by Boole's inequality, 1 - Σ(1 - P): places have errors in common that are not known here, and the bound
/// holds for any. It fails if one place does with a probability of at most risk / n of keeping its limit: the worst of
/// many noisy places is worse than any of them is. Where so few places were measured that they are less than 30 % of
/// those looked at, a joint does not pass. Flatness fails if the largest gap is above the limit by more than the
/// points' noise makes of a true one with a probability of the risk.
///
/// Throws std::runtime_error with both rules where a joint's `narrowest` by one is above its `widest` by the other.
SurfaceJudgementT judge_surfaces(const SurfacesT& surfaces, const std::map<std::string, ifc::ElementFacts>& facts,
                                 const std::vector<SurfaceRule>& rules, double risk, double within = kPlausiblePlace);

/// A measurement that contradicts itself shows no surface to be in order, and none to be out of it.
void leave_open(SurfaceJudgementT& judgement);

/// Where the design has its panels, also those that no anchor holds: by GlobalId the storey's, and storeys' names.
struct PanelStoreys {
  std::map<std::string, std::string> storey_of, names;
};
PanelStoreys panel_storeys(const DesignT& design);

/// Takes surfaces into the judgement of the whole: what fails or is undecided on a floor, or anywhere, is not ready to
/// install, nor is what a rule asks for and nobody could judge. Surfaces of a measurement that is in doubt are left
/// open. A joint counts on the floor of its first panel where that panel's name is its own; else in the whole alone. A
/// panel without anchors counts on the floor of its storey, if `storeys` say it and that has anchors; else its storey
/// is told.
void take_surfaces(SurfaceJudgementT surfaces, DeviationT& deviation, const PanelStoreys& storeys = {});

}  // namespace plumbline::judgement
