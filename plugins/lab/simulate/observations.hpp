// Observations without photographs: what an ideal detector and surveyor would deliver, with noise of a known size. For
// Monte Carlo trials that need hundreds of campaigns.
#pragma once

#include <cstdint>

#include "campaign.hpp"

namespace plumbline::simulate {

/// Tags of one image in the order of their ids, corners [px] with normal noise of `sigma` in each coordinate.
struct ObservedImage {
  const CameraStation* station = nullptr;
  std::vector<VisibleTag> tags;
};
std::vector<ObservedImage> observe_corners(const Campaign& campaign, double sigma, std::uint64_t seed);

/// A surveyed anchor with its true position displaced.
struct ObservedPoint {
  const Anchor* anchor = nullptr;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< [m]
};
/// Independent noise of `sigma` in each coordinate [m], and a height error common to a floor that is the sum of normal
/// steps of `height_walk` from floor to floor [m].
std::vector<ObservedPoint> observe_points(const Campaign& campaign, double sigma, double height_walk,
                                          std::uint64_t seed);

/// Whether a control marker holds the model in a layout of control: "all", "two_per_floor" (outermost markers,
/// crosswise), "ground_floor" (all of the lowest storey), "one_column" (the leftmost, all the way up). Check anchors
/// never do.
bool holds_model(const Anchor& anchor, int columns, const std::string& layout);

/// Blunders: this share of the control points, rounded to whole ones, off by `size` [m] in random directions; which
/// ones, the seed draws. Their covariance knows nothing of it.
void displace_points(std::vector<ObservedPoint>& points, double share, double size, std::uint64_t seed);
/// Each tag with probability `share` off by 5 to `largest` px in a random direction, all its corners alike.
void displace_tags(ObservedImage& image, double share, double largest, std::uint64_t seed);
/// Each corner with probability `share` off by 2 to `largest` px in a random direction, for itself.
void displace_corners(ObservedImage& image, double share, double largest, std::uint64_t seed);

/// Covariance of all observed points, 3n × 3n, in their order [m²].
Eigen::MatrixXd point_covariance(const std::vector<ObservedPoint>& points, double sigma, double height_walk);

/// What a surveyor hands over: coordinates of all anchors with their covariance, and what they were computed from.
struct SurveyedSite {
  std::vector<ObservedPoint> points;
  Eigen::MatrixXd covariance;  ///< 3n × 3n [m²]
  survey::SurveyObservations readings;
};

/// Points that were observed as coordinates, as one group of a survey.
survey::SurveyObservations as_observed_coordinates(const std::vector<ObservedPoint>& points,
                                                   const Eigen::MatrixXd& covariance);

/// The campaign's total-station readings and ground control, adjusted as a network with the instrument's own profile.
/// Throws survey::NetworkError for a network that cannot be adjusted.
SurveyedSite survey_by_readings(const Campaign& campaign);

}  // namespace plumbline::simulate
