// The verdict on one quantity of one panel or joint, for surfaces.hpp, which says how limits are held.
#pragma once

#include "artifacts/surface_judgement.hpp"
#include "artifacts/surfaces.hpp"
#include "building/judgement/surface_rules.hpp"

namespace plumbline::judgement {

/// Share of a panel that has to have points before it passes, and of a joint that has to show its edges. What is beyond
/// its limit is so wherever it is.
inline constexpr double kSeenEnough = 0.75;

/// That a value [m] with a standard deviation [m] keeps the limit (conformance_probability), whose one side may be
/// open.
double limit_probability(double value, double sigma, const SurfaceLimit& limit);

/// Pass where `kept`, the probability of the whole, reaches 1 - risk; fail where that of the worst place is at most
/// `fails_at`; else undecided.
void decide(SurfaceVerdictT& verdict, double kept, double at_worst, double fails_at, double risk);

/// Flatness, bow, twist or offset of a measured panel of `surfaces`: value, standard deviation, probability and verdict
/// go to `verdict`, or the reason why there is none. Throws std::runtime_error where the figures lack their covariance.
void judge_panel(const SurfacesT& surfaces, const PanelSurfaceFiguresT& panel, const SurfaceLimit& limit, double risk,
                 SurfaceVerdictT& verdict);

/// Step, width or shift of a joint of `surfaces` at all of its places likewise.
void judge_joint(const SurfacesT& surfaces, const JointFiguresT& joint, const SurfaceLimit& limit, double risk,
                 SurfaceVerdictT& verdict);

}  // namespace plumbline::judgement
