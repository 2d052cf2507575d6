#include "observations.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/random.hpp"
#include "survey/adjust/adjust_network.hpp"

namespace plumbline::simulate {

std::vector<ObservedImage> observe_corners(const Campaign& campaign, double sigma, std::uint64_t seed) {
  std::vector<ObservedImage> images;
  for (std::size_t i = 0; i < campaign.stations.size(); ++i) {
    const CameraStation& station = campaign.stations[i];
    ObservedImage image{&station,
                        visible_tags(campaign.building, camera_at(campaign, i).truth, station.camera_from_building, 12,
                                     campaign.obstruction, depth_distortion_of(campaign))};
    Random random(seed, "corners " + station.image);
    for (VisibleTag& tag : image.tags) {
      for (Eigen::Vector2d& corner : tag.corners) {
        const double dx = random.normal(sigma), dy = random.normal(sigma);
        corner += Eigen::Vector2d(dx, dy);
      }
    }
    images.push_back(std::move(image));
  }
  return images;
}

std::vector<ObservedPoint> observe_points(const Campaign& campaign, double sigma, double height_walk,
                                          std::uint64_t seed) {
  std::vector<double> floor_error(static_cast<std::size_t>(campaign.building.options.floors), 0.0);
  Random walk(seed, "height walk");
  for (std::size_t f = 1; f < floor_error.size(); ++f) floor_error[f] = floor_error[f - 1] + walk.normal(height_walk);
  std::vector<ObservedPoint> points;
  for (const Anchor& anchor : campaign.building.anchors) {
    Random random(seed, "survey " + anchor.id);
    const Eigen::Vector3d common(0, 0, floor_error[anchor.floor - 1]);
    points.push_back({&anchor, anchor.target() + random.normal3(sigma) + common});
  }
  return points;
}

bool holds_model(const Anchor& anchor, int columns, const std::string& layout) {
  if (anchor.role != AnchorRole::control) return false;
  if (layout == "ground_floor") return anchor.floor == 1;
  if (layout == "one_column") return anchor.column == 1;
  if (layout == "two_per_floor") {  // left below and right above, the other way round on the next floor
    const bool rising = anchor.floor % 2 == 1;
    return (anchor.column == 1 && anchor.row == (rising ? 1 : 2)) ||
           (anchor.column == columns && anchor.row == (rising ? 2 : 1));
  }
  return true;
}

void displace_points(std::vector<ObservedPoint>& points, double share, double size, std::uint64_t seed) {
  struct Drawn {
    double order;
    ObservedPoint* point;
    Eigen::Vector3d direction;
  };
  std::vector<Drawn> drawn;
  for (ObservedPoint& point : points) {
    if (point.anchor->role != AnchorRole::control) continue;
    Random random(seed, "blunder " + point.anchor->id);
    const double order = random.uniform();
    drawn.push_back({order, &point, random.normal3(1).normalized()});
  }
  std::sort(drawn.begin(), drawn.end(), [](const Drawn& a, const Drawn& b) { return a.order < b.order; });
  const auto wrong = static_cast<std::size_t>(std::lround(share * static_cast<double>(drawn.size())));
  for (std::size_t k = 0; k < wrong; ++k) drawn[k].point->position += size * drawn[k].direction;
}

void displace_tags(ObservedImage& image, double share, double largest, std::uint64_t seed) {
  Random random(seed, "tag blunders " + image.station->image);
  for (VisibleTag& tag : image.tags) {
    const double draw = random.uniform(), angle = random.uniform(0, 2 * std::numbers::pi),
                 length = random.uniform(5, largest);
    if (draw >= share) continue;
    for (Eigen::Vector2d& corner : tag.corners) corner += length * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  }
}

void displace_corners(ObservedImage& image, double share, double largest, std::uint64_t seed) {
  Random random(seed, "corner blunders " + image.station->image);
  for (VisibleTag& tag : image.tags)
    for (Eigen::Vector2d& corner : tag.corners) {
      const double draw = random.uniform(), angle = random.uniform(0, 2 * std::numbers::pi),
                   length = random.uniform(2, largest);
      if (draw < share) corner += length * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    }
}

Eigen::MatrixXd point_covariance(const std::vector<ObservedPoint>& points, double sigma, double height_walk) {
  const auto n = static_cast<Eigen::Index>(points.size());
  Eigen::MatrixXd covariance = sigma * sigma * Eigen::MatrixXd::Identity(3 * n, 3 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) {
      // Two floors share the steps up to the lower of them.
      const int steps = std::min(points[i].anchor->floor, points[j].anchor->floor) - 1;
      covariance(3 * i + 2, 3 * j + 2) += height_walk * height_walk * steps;
    }
  }
  return covariance;
}

namespace {

/// Adds a point with these coordinates to a survey, and to the group of those observed; its covariance is the caller's.
void add_coordinates(const std::string& id, const Eigen::Vector3d& position, survey::SurveyObservations& out,
                     survey::CoordinateGroup& group) {
  survey::Point point;
  point.id = id;
  point.coordinates = position;
  out.points.push_back(point);
  group.values.conservativeResize(group.values.size() + 3);
  group.values.tail<3>() = position;
  for (int axis = 0; axis < 3; ++axis) group.components.push_back({id, axis});
}

}  // namespace

survey::SurveyObservations as_observed_coordinates(const std::vector<ObservedPoint>& points,
                                                   const Eigen::MatrixXd& covariance) {
  survey::SurveyObservations out;
  out.info.format = "simulated";
  survey::CoordinateGroup group;
  for (const ObservedPoint& point : points) add_coordinates(point.anchor->id, point.position, out, group);
  group.covariance = covariance;
  out.coordinates.push_back(std::move(group));
  return out;
}

SurveyedSite survey_by_readings(const Campaign& campaign) {
  SurveyedSite site;
  site.readings = campaign.observations;
  survey::CoordinateGroup ground;
  ground.is_control = true;
  for (const GroundPoint& point : campaign.plan.ground_points)
    add_coordinates(point.id, point.given, site.readings, ground);
  ground.covariance = Eigen::MatrixXd::Zero(ground.values.size(), ground.values.size());
  for (std::size_t k = 0; k < campaign.plan.ground_points.size(); ++k)
    ground.covariance.diagonal().segment<3>(static_cast<Eigen::Index>(3 * k)).array() =
        campaign.plan.ground_points[k].sigma * campaign.plan.ground_points[k].sigma;
  site.readings.coordinates.push_back(std::move(ground));
  survey::AdjustOptions options;
  options.profile = survey::built_in_profile(campaign.options.survey.instrument);
  const survey::NetworkResult network = survey::adjust_network(site.readings, options);
  std::vector<int> unknowns;
  for (const Anchor& anchor : campaign.building.anchors) {
    const survey::ResultPoint& point = network.point(anchor.id);
    site.points.push_back({&anchor, point.position});
    unknowns.insert(unknowns.end(), point.unknowns.begin(), point.unknowns.end());
  }
  site.covariance = network.cofactors.joint(unknowns);
  return site;
}

}  // namespace plumbline::simulate
