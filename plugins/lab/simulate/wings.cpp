#include "wings.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <numbers>
#include <stdexcept>

namespace plumbline::simulate {
namespace {

using Eigen::Vector3d;

constexpr double kFarthestSight = 60;  ///< to a control point [m]

/// A facade that begins at a place, its x axis turned from that of the building, counter-clockwise [rad].
RigidTransform wing_at(double x, double y, double turn) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(turn, Vector3d::UnitZ())), Vector3d(x, y, 0)};
}

std::vector<RigidTransform> around(double width, double side, bool inward) {
  const double quarter = 0.5 * std::numbers::pi, half = 0.5 * side;
  std::vector<RigidTransform> wings;
  for (int k = 0; k < 4; ++k) {
    // Outside one goes around counter-clockwise and has the building on the left; in a court it is the other way.
    const RigidTransform turned = wing_at(0, 0, (inward ? -k : k) * quarter);
    const Vector3d start(-0.5 * width, inward ? half : -half, 0);
    wings.push_back(turned * RigidTransform{Eigen::Quaterniond::Identity(), start});
  }
  return wings;
}

class Joiner {
 public:
  explicit Joiner(WingPlan& all) : all_(all) {}

  void add(const WingPlan& flat, const RigidTransform& place) {
    const int wing = static_cast<int>(all_.building.wings.size());
    const auto anchors = all_.building.anchors.size(), ground = all_.plan.ground_points.size();
    all_.building.wings.push_back(place);
    for (const Anchor& anchor : flat.building.anchors) add_anchor(anchor, flat.building.options, place, wing);
    for (const double scale : flat.building.batch_scale) all_.building.batch_scale.push_back(scale);
    for (CameraStation station : flat.stations) {
      station.image = std::string(1, static_cast<char>('A' + wing)) + "-" + station.image;
      station.camera_from_building = station.camera_from_building * place.inverse();
      all_.stations.push_back(std::move(station));
    }
    for (GroundPoint point : flat.plan.ground_points) {
      point.id = "G" + std::to_string(all_.plan.ground_points.size() + 1);
      point.truth = place * point.truth, point.given = place * point.given;
      all_.plan.ground_points.push_back(std::move(point));
    }
    std::vector<int> number(static_cast<std::size_t>(flat.building.options.floors) + 1);
    for (PlannedSetUp set_up : flat.plan.set_ups) {
      set_up.id = fmt::format("S{:02}-{}", set_up.floor, 2 * wing + ++number[set_up.floor]);
      set_up.axis = place * set_up.axis, set_up.given_mark = place * set_up.given_mark;
      for (std::size_t& anchor : set_up.anchors) anchor += anchors;
      for (std::size_t& point : set_up.ground_points) point += ground;
      all_.plan.set_ups.push_back(std::move(set_up));
    }
  }

  /// What else of the control points a set-up sees that sees some already.
  void add_sights() {
    for (PlannedSetUp& set_up : all_.plan.set_ups)
      for (std::size_t g = 0; g < all_.plan.ground_points.size() && set_up.floor <= 2; ++g) {
        const GroundPoint& point = all_.plan.ground_points[g];
        const Vector3d target = point.truth + Vector3d(0, 0, point.target_height);
        const bool own = std::count(set_up.ground_points.begin(), set_up.ground_points.end(), g) > 0;
        if (!own && (target - set_up.axis).norm() < kFarthestSight && free_sight(all_.building, set_up.axis, target))
          set_up.ground_points.push_back(g);
      }
  }

 private:
  void add_anchor(Anchor anchor, const BuildingOptions& options, const RigidTransform& place, int wing) {
    const int columns = options.columns;
    const bool control = anchor.role == AnchorRole::control;
    const int number = anchor.column - (control ? 0 : columns);
    anchor.column = control ? wing * columns + number : static_cast<int>(kWings) * columns + 3 * wing + number;
    anchor.id = control ? fmt::format("F{:02}-C{:02}-R", anchor.floor, anchor.column) + std::to_string(anchor.row)
                        : fmt::format("F{:02}-K{}", anchor.floor, 3 * wing + number);
    anchor.wing = wing, anchor.tag_id = static_cast<int>(all_.building.anchors.size());
    anchor.batch += wing * options.print_batches;
    anchor.design = place * anchor.design, anchor.built = place * anchor.built;
    anchor.building_from_plate = place * anchor.building_from_plate;
    all_.building.anchors.push_back(std::move(anchor));
  }

  static constexpr std::size_t kWings = 4;  ///< at most
  WingPlan& all_;
};

}  // namespace

const std::vector<std::string>& shape_names() {
  static const std::vector<std::string> names = {"flat", "set_back", "curved", "corner", "block", "courtyard"};
  return names;
}

std::vector<RigidTransform> wings_of(const std::string& shape, double width, double step, double clear) {
  if (shape == "flat") return {wing_at(0, 0, 0)};
  if (shape == "set_back") return {wing_at(0, 0, 0), wing_at(width, step, 0), wing_at(2 * width, 0, 0)};
  if (shape == "corner") return {wing_at(0, 0, 0), wing_at(width + 1, -1, -0.5 * std::numbers::pi)};
  if (shape == "block") return around(width, width + 0.5, false);
  if (shape == "courtyard") return around(width, std::max(width + 1, clear), true);
  if (shape == "curved") {
    std::vector<RigidTransform> wings;
    Vector3d start = Vector3d::Zero();
    for (int k = 0; k < 4; ++k) {
      wings.push_back(wing_at(start.x(), start.y(), k * std::numbers::pi / 12));
      start = wings.back() * Vector3d(width, 0, 0);
    }
    return wings;
  }
  std::string known;
  for (const std::string& name : shape_names()) known += (known.empty() ? "" : ", ") + name;
  throw std::invalid_argument("there is no shape '" + shape + "'; known are " + known);
}

bool free_sight(const Building& building, const Vector3d& from, const Vector3d& to, int own_wing) {
  for (std::size_t w = 0; w < building.wings.size(); ++w) {
    if (static_cast<int>(w) == own_wing) continue;
    const RigidTransform wing_from_building = building.wings[w].inverse();
    const Vector3d a = wing_from_building * from, b = wing_from_building * to;
    if ((a.y() < 0) == (b.y() < 0)) continue;
    const Vector3d p = a + (b - a) * (a.y() / (a.y() - b.y()));
    if (p.x() > 0.01 && p.x() < building.width - 0.01 && p.z() < building.height) return false;
  }
  return true;
}

WingPlan join_wings(std::vector<WingPlan> flat, const std::vector<RigidTransform>& places, const BrownCamera& camera,
                    int required_tags) {
  if (places.size() == 1) return std::move(flat.front());
  WingPlan all;
  all.building = flat.front().building;
  all.building.anchors.clear(), all.building.wings.clear(), all.building.batch_scale.clear();
  Joiner joiner(all);
  for (std::size_t w = 0; w < places.size(); ++w) joiner.add(flat[w], places[w]);
  if (all.building.anchors.size() > 587)
    throw std::invalid_argument(std::to_string(all.building.anchors.size()) +
                                " anchors need more ids than the 587 of tag36h11; take fewer floors or columns");
  joiner.add_sights();
  for (const CameraStation& station : all.stations) {
    const auto seen = static_cast<int>(visible_tags(all.building, camera, station.camera_from_building).size());
    if (seen < required_tags)
      throw std::invalid_argument("image " + station.image + " would see " + std::to_string(seen) +
                                  " whole tags past the other facades, every image has to see " +
                                  std::to_string(required_tags));
  }
  return all;
}

}  // namespace plumbline::simulate
