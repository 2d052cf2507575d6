#include <gtest/gtest.h>

#include <map>
#include <set>
#include <tuple>

#include "building.hpp"
#include "obstruction.hpp"

namespace plumbline::simulate {
namespace test_building {

TEST(Building, StandsOnTheGridOfTable1) {
  for (int floors = 1; floors <= 5; ++floors) {
    for (int columns = 3; columns <= 4; ++columns) {
      const Building b = make_building({.floors = floors, .columns = columns}, 1);
      std::map<AnchorRole, int> count;
      std::set<double> rows, grid;
      std::set<std::string> ids;
      std::set<int> tags;
      for (const Anchor& a : b.anchors) {
        ++count[a.role];
        ids.insert(a.id);
        tags.insert(a.tag_id);
        if (a.role == AnchorRole::control) rows.insert(a.design.z()), grid.insert(a.design.x());
      }
      EXPECT_EQ(count[AnchorRole::control], floors * columns * 2);
      EXPECT_EQ(count[AnchorRole::check], floors * 3);
      EXPECT_EQ(ids.size(), b.anchors.size());
      EXPECT_EQ(tags.size(), b.anchors.size());
      for (const auto& values : {rows, grid}) {  // 2.0 m apart throughout, storey boundaries too
        for (auto at = std::next(values.begin()); at != values.end(); ++at) EXPECT_DOUBLE_EQ(*at - *std::prev(at), 2.0);
      }
    }
  }
}

TEST(Building, ControlAndCheckAnchorsHangInVerticalColumns) {
  for (int columns = 2; columns <= 5; ++columns) {
    const Building b = make_building({.floors = 4, .columns = columns}, 1);
    std::map<int, std::set<double>> places;
    std::map<int, std::set<int>> floors;
    std::map<int, std::set<AnchorRole>> roles;
    for (const Anchor& a : b.anchors) {
      places[a.column].insert(a.design.x());
      floors[a.column].insert(a.floor);
      roles[a.column].insert(a.role);
    }
    ASSERT_EQ(places.size(), static_cast<std::size_t>(columns + 3));
    EXPECT_EQ(places.begin()->first, 1) << "no anchor is without a column";
    for (const auto& [column, xs] : places) {
      EXPECT_EQ(xs.size(), 1u);
      EXPECT_EQ(floors[column].size(), 4u);
      EXPECT_EQ(roles[column].size(), 1u);
    }
  }
}

/// Check anchors hang in the middle of a cell; where the facade is two or three columns wide there are too few cells.
TEST(Building, CheckAnchorsHangInCellsOfTheGrid) {
  for (int columns = 4; columns <= 8; ++columns) {
    const Building b = make_building({.floors = 1, .columns = columns}, 1);
    std::set<double> cells;
    double first = 1e9;
    for (const Anchor& a : b.anchors)
      if (a.role == AnchorRole::control) first = std::min(first, a.design.x());
    for (const Anchor& a : b.anchors)
      if (a.role == AnchorRole::check) cells.insert((a.design.x() - first) / 2.0);
    const double middle = columns % 2 ? 0.5 * columns - 1 : 0.5 * columns - 0.5;
    EXPECT_EQ(cells, (std::set<double>{0.5, middle, columns - 1.5})) << columns;
  }
}

TEST(Building, PlatesDoNotTouch) {
  for (int columns = 2; columns <= 7; ++columns) {
    const Building b = make_building({.floors = 2, .columns = columns}, 3);
    for (std::size_t i = 0; i < b.anchors.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) EXPECT_GT((b.anchors[i].built - b.anchors[j].built).norm(), 0.6);
    }
  }
}

TEST(Building, DeviationsAreOfTheSizeAskedFor) {
  double sum = 0;
  int n = 0;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    for (const Anchor& a : make_building({.floors = 5, .as_built_sigma = 0.004}, seed).anchors) {
      sum += (a.built - a.design).squaredNorm();
      n += 3;
    }
  }
  EXPECT_NEAR(std::sqrt(sum / n), 0.004, 0.004 * 4 / std::sqrt(2.0 * n));
}

TEST(Building, ASeedGivesTheSameBuildingAndAFloorMoreChangesNoOther) {
  const Building a = make_building({.floors = 2}, 5), b = make_building({.floors = 3}, 5),
                 c = make_building({.floors = 2}, 6);
  for (std::size_t i = 0; i < a.anchors.size(); ++i) {
    EXPECT_EQ(a.anchors[i].id, b.anchors[i].id);
    EXPECT_EQ(a.anchors[i].built, b.anchors[i].built);
    EXPECT_NE(a.anchors[i].built, c.anchors[i].built);
  }
}

TEST(Building, PlatesFaceTheCameras) {
  for (const Anchor& a : make_building({}, 1).anchors) {
    EXPECT_LT((a.building_from_plate.rotation * Eigen::Vector3d::UnitZ()).y(), -0.98);
    EXPECT_GT((a.building_from_plate.rotation * Eigen::Vector3d::UnitY()).z(), 0.98);
  }
}

/// A scaffold goes round the facade's ends and over its top: tubes begin less than one spacing from where it begins.
TEST(Obstruction, AScaffoldReachesFourMetresPastTheFacadeOnAllSides) {
  const Building building = make_building({.floors = 3}, 1);
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Obstruction scaffold = make_obstruction(building, {.scaffold_spacing = 2.5}, seed);
    EXPECT_EQ(scaffold.plane, -1.0) << "before the facade, which looks to negative y";
    for (const auto& [tubes, spacing, length] :
         {std::tuple(scaffold.uprights, 2.5, building.width), std::tuple(scaffold.ledgers, 2.0, building.height)}) {
      ASSERT_GE(tubes.size(), 2u);
      EXPECT_GE(tubes.front(), -4.0);
      EXPECT_LT(tubes.front(), -4.0 + spacing);
      EXPECT_LE(tubes.back(), length + 4.0);
      EXPECT_GT(tubes.back(), length + 4.0 - spacing);
      for (std::size_t i = 1; i < tubes.size(); ++i) EXPECT_NEAR(tubes[i] - tubes[i - 1], spacing, 1e-12);
    }
  }
}

TEST(Building, RefusesWhatCannotBeBuilt) {
  for (const int floors : {0, 21}) EXPECT_THROW(make_building({.floors = floors}, 1), std::invalid_argument);
  for (const int columns : {1, 13}) EXPECT_THROW(make_building({.columns = columns}, 1), std::invalid_argument);
  for (const int floors : {1, 20}) EXPECT_NO_THROW(make_building({.floors = floors}, 1));
  for (const int columns : {2, 12}) EXPECT_NO_THROW(make_building({.columns = columns}, 1));
  EXPECT_THROW(make_building({.tag_size = 1.5}, 1), std::invalid_argument);
}

}  // namespace test_building
}  // namespace plumbline::simulate
