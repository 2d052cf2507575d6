// Ways in which photographs of one camera may fall into two parts, each with what is expected of it beforehand.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "photo/markers/camera_changes.hpp"
#include "photo/markers/photograph_effects.hpp"
#include "plumbline/rigid_transform.hpp"

namespace plumbline::markers {

/// Fewest photographs of either part.
constexpr std::size_t smallest_part = 3;

/// A way to weigh the photographs against each other, with the part of all changes that are expected to be of it.
struct Contrast {
  CameraChange::Split split = CameraChange::Split::from_on;
  Eigen::VectorXd weights;
  std::vector<int> second;
  int period = 0;
  double log_prior = 0;
};

/// By the order of `photographs`: of the changes that are expected 0.4 are a cut, 0.15 a drift, 0.15 every so many.
std::vector<Contrast> contrasts_in_order(std::size_t photographs);

/// The camera's x axis in the object: held one way or upside down against most; 0.1.
std::optional<Contrast> upside_down(const std::vector<RigidTransform>& cam_from_object);

/// Photographs sorted by what each says of its own along `directions`, cut at every place: as many ways as there are
/// subsets of the size, so each counts as little; 0.1 of what is expected.
std::vector<Contrast> groups(const EffectFit& fit, const Eigen::MatrixXd& directions);

/// Stretches of the order between which the camera goes there and back: a zoom for a while, two folders put into one.
/// The likeliest window of all and what becomes of it, and of the likeliest cut, when every photograph may go to the
/// part that it fits better, at a price for each place where the part changes (Viterbi 1967, IEEE Trans. Inf. Theory
/// 13(2)). 0.1 of what is expected, half of it one window, a quarter three changes and so on, all places alike.
/// `directions`, `sizes`: as of Step.
std::vector<Contrast> stretches(const EffectFit& fit, const Eigen::MatrixXd& directions, const Eigen::VectorXd& sizes);

/// What each photograph by itself says along the axis of `directions` by which the photographs differ most, and its
/// standard deviations; empty where one of them says nothing.
std::pair<Eigen::VectorXd, Eigen::VectorXd> along_their_axis(const EffectFit& fit, const Eigen::MatrixXd& directions);

/// First and last of each run of neighbours in `second`, which is ascending.
std::vector<std::pair<int, int>> runs_of(const std::vector<int>& second);

}  // namespace plumbline::markers
