// Whether two epochs are of one size. Points that moved change some distances; another unit, a ppm setting or a map
// scale changes all of them alike, and would be taken for movements of every point.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "survey/epochs/compare_epochs.hpp"

namespace plumbline::survey {

/// The factor by which distances of `second` are longer than those of `first`, if at least four common points agree on
/// one that is not 1: four in five distances within a tenth of its difference from 1, which is at least 50 ppm.
std::optional<double> common_scale(const Epoch& first, const Epoch& second);

/// "3.28084 times those of the first epoch: it is in feet"; "by 387 ppm longer than ..." of a scale near 1.
std::string scale_in_words(double scale);

/// What the page has to say of both, beside what moved: a scale near 1 that they do not share, and what 10 K do to the
/// extent of the points where it is more than two median standard deviations of a coordinate of `sigmas` [m; not
/// finite: not known].
std::vector<std::string> size_notes(std::optional<double> scale, const std::vector<Eigen::Vector3d>& places,
                                    const std::vector<Eigen::Vector3d>& sigmas);

/// From this difference from 1 on no instrument explains it: the epochs must not be compared.
constexpr double kImpossibleScale = 0.01;

}  // namespace plumbline::survey
