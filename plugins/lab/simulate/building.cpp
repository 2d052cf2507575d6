#include "building.hpp"

#include <fmt/core.h>

#include <stdexcept>

#include "geometry/random.hpp"

namespace plumbline::simulate {
namespace {

std::string two_digits(const char* prefix, int number) { return fmt::format("{}{:02}", prefix, number); }

void require(bool holds, const std::string& what) {
  if (!holds) throw std::invalid_argument("simulated building: " + what);
}

void check_options(const BuildingOptions& o) {
  require(o.floors >= 1 && o.floors <= 20, "floors is " + std::to_string(o.floors) + ", it must be 1 to 20");
  require(o.columns >= 2 && o.columns <= 12, "columns is " + std::to_string(o.columns) + ", it must be 2 to 12");
  require(o.spacing >= 1.0, "spacing must be at least 1 m, or plates would overlap");
  require(o.as_built_sigma >= 0 && o.plate_tilt_sigma >= 0 && o.tag_scale_sigma >= 0,
          "standard deviations must not be negative");
  require(o.tag_size >= 0.02 && o.tag_size <= 0.5 * o.spacing, "tag_size must lie between 20 mm and half the spacing");
  require(o.print_batches >= 1, "print_batches must be at least 1");
  const int anchors = o.floors * (2 * o.columns + 3);
  require(anchors <= 587, std::to_string(anchors) + " anchors need more ids than the 587 of tag36h11");
}

/// Three places a floor that are no grid points, the same on every floor, so that each makes a column of its own:
/// centres of cells, and for narrow grids the middle between two rows.
std::vector<double> check_columns(int columns) {
  if (columns == 2) return {0.0, 0.5, 1.0};
  if (columns == 3) return {0.5, 1.5, 2.0};
  return {0.5, 0.5 * (columns - 1) - (columns % 2 ? 0.5 : 0.0), columns - 1.5};
}

}  // namespace

const char* to_string(AnchorRole role) { return role == AnchorRole::control ? "control" : "check"; }

std::array<Eigen::Vector3d, 4> Anchor::tag_corners() const {
  auto corners = tag_corners_in_plate(true_plate);
  for (std::size_t i = 0; i < 4; ++i) corners[i].z() += i % 2 == 0 ? bend : -bend;
  return corners;
}

Eigen::Quaterniond facade_from_plate() {
  Eigen::Matrix3d axes;
  axes.col(0) = Eigen::Vector3d::UnitX();
  axes.col(1) = Eigen::Vector3d::UnitZ();
  axes.col(2) = -Eigen::Vector3d::UnitY();
  return Eigen::Quaterniond(axes);
}

PlateOutline plate_outline(const MarkerPlate& plate) {
  // tag36h11 has a white edge one eighth of the tag wide, which the detector needs; the plate adds a little to hold it
  // by.
  const double quiet = plate.tag_size / 8, rim = 0.05 * plate.tag_size;
  const double radius = 0.19 * plate.tag_size;
  return {0.5 * plate.tag_size + quiet + rim, -radius - rim - 0.01,
          plate.tag_centre_in_plate.y() + 0.5 * plate.tag_size + quiet + rim, radius};
}

Building make_building(const BuildingOptions& options, std::uint64_t seed) {
  check_options(options);
  Building building;
  building.options = options;
  building.storey_height = 2 * options.spacing;
  building.width = options.spacing * options.columns;
  building.height = building.storey_height * options.floors;
  building.nominal_plate = {options.tag_size, Eigen::Vector3d(0, options.tag_size, 0)};

  Random scale_random(seed, "tag scale");
  for (int batch = 0; batch < options.print_batches; ++batch) {
    building.batch_scale.push_back(1.0 + scale_random.normal(options.tag_scale_sigma));
  }

  const auto add = [&](int floor, int column, int row, AnchorRole role, std::string id, double x, double z) {
    Anchor anchor;
    anchor.id = std::move(id);
    anchor.floor = floor;
    anchor.column = column;
    anchor.row = row;
    anchor.role = role;
    anchor.tag_id = static_cast<int>(building.anchors.size());
    anchor.batch = (floor - 1) * options.print_batches / options.floors;
    anchor.design = Eigen::Vector3d(x, 0.0, z);
    Random random(seed, anchor.id);  // by name: adding a floor leaves the others as they are
    anchor.built = anchor.design + random.normal3(options.as_built_sigma);
    const Eigen::Quaterniond tilt = quaternion_from_rotation_vector(random.normal3(options.plate_tilt_sigma));
    anchor.building_from_plate = {(facade_from_plate() * tilt).normalized(), anchor.built};
    anchor.true_plate = building.nominal_plate;
    anchor.true_plate.tag_size *= building.batch_scale[anchor.batch];
    Random flaws(seed, "flaws of " + anchor.id);
    Eigen::Vector3d offset = flaws.normal3(options.flaws.plate_offset_sigma);
    offset.z() = 0;  // the print lies on the plate
    anchor.true_plate.tag_centre_in_plate += offset;
    anchor.building_from_plate.translation += flaws.normal3(options.flaws.mounting_sigma);
    anchor.bend = flaws.normal(options.flaws.plate_bend);
    building.anchors.push_back(std::move(anchor));
  };

  for (int floor = 1; floor <= options.floors; ++floor) {
    const double bottom = building.storey_height * (floor - 1);
    const std::string name = two_digits("F", floor);
    for (int row = 1; row <= 2; ++row) {
      for (int column = 1; column <= options.columns; ++column) {
        add(floor, column, row, AnchorRole::control, name + two_digits("-C", column) + "-R" + std::to_string(row),
            options.spacing * (column - 0.5), bottom + options.spacing * (row - 0.5));
      }
    }
    int number = 0;
    for (const double column : check_columns(options.columns)) {
      ++number;
      add(floor, options.columns + number, 0, AnchorRole::check, name + "-K" + std::to_string(number),
          options.spacing * (column + 0.5), bottom + options.spacing);
    }
  }
  return building;
}

}  // namespace plumbline::simulate
