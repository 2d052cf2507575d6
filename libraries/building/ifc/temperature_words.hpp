// What no survey says of itself: what the temperature does to a building between its lowest and highest anchor. The
// same for the page, the summary, IFC and the loop.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "artifacts/deviation.hpp"
#include "artifacts/installation_plan.hpp"

namespace plumbline::ifc {

/// What 10 K do is told where it is more than this share of the smallest tolerance, or more than so many median
/// standard deviations of a height: below that it drowns.
inline constexpr double kToldShare = 0.2, kToldSigmas = 2;

/// One sentence with what 10 K do to the height and the width that `places` [m, z up] span, beside the smallest
/// `tolerance` and the median of `sigmas` of their heights [m; nan: not known]. Empty where it matters less than
/// kToldShare and kToldSigmas say, or nothing was measured.
std::string temperature_words(const std::vector<Eigen::Vector3d>& places, double tolerance, std::vector<double> sigmas);

/// The same of the anchors that were measured and what they are held against.
std::string temperature_words(const DeviationT& deviation);

/// The same of a plan's brackets and the lengths that are judged.
std::string temperature_words(const InstallationPlanT& plan);

}  // namespace plumbline::ifc
