// Buildings of several facades: each is the flat one in another place, and nobody looks through a wall.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "campaign.hpp"
#include "wings.hpp"

namespace plumbline::simulate {
namespace test_wings {

Campaign campaign_of(const std::string& shape, double step = 1.0) {
  CampaignOptions options;
  options.shape = shape, options.step = step;
  options.building.floors = 2;
  options.cameras.images_per_floor = 4;
  return make_campaign(options, 3);
}

Eigen::Vector3d outward(const Building& building, const Anchor& anchor) {
  return building.wings[anchor.wing].rotation * -Eigen::Vector3d::UnitY();
}

TEST(Wings, EachFacadeIsTheFlatOneInItsPlace) {
  const Campaign flat = campaign_of("flat");
  for (const std::string& shape : shape_names()) {
    const Campaign c = campaign_of(shape);
    const std::size_t wings = c.building.wings.size();
    EXPECT_EQ(c.building.anchors.size(), wings * flat.building.anchors.size()) << shape;
    EXPECT_EQ(c.stations.size(), wings * flat.stations.size()) << shape;
    EXPECT_EQ(c.plan.set_ups.size(), wings * flat.plan.set_ups.size()) << shape;
    std::set<std::string> ids;
    std::set<int> tags;
    for (const Anchor& a : c.building.anchors) {
      ids.insert(a.id), tags.insert(a.tag_id);
      const Eigen::Vector3d normal = a.building_from_plate.rotation * Eigen::Vector3d::UnitZ();
      EXPECT_GT(normal.dot(outward(c.building, a)), 0.99) << shape << ": " << a.id;
    }
    EXPECT_EQ(ids.size(), c.building.anchors.size()) << shape;
    EXPECT_EQ(tags.size(), c.building.anchors.size()) << shape;
    // The first facade stands as the flat one does, but for where it begins.
    const RigidTransform flat_from_building = c.building.wings[0].inverse();
    for (std::size_t i = 0; i < flat.building.anchors.size(); ++i) {
      const Anchor &a = c.building.anchors[i], &b = flat.building.anchors[i];
      EXPECT_LT((flat_from_building * a.built - b.built).norm(), 1e-12) << shape << ": " << a.id;
    }
    for (std::size_t i = 0; i < c.building.anchors.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        EXPECT_GT((c.building.anchors[i].design - c.building.anchors[j].design).norm(), 0.6) << shape;
  }
}

/// A court is looked at from within it, a block from around it: outward is to whoever measures.
TEST(Wings, CamerasAndSetUpsStandBeforeTheirFacades) {
  for (const std::string& shape : shape_names()) {
    const Campaign c = campaign_of(shape);
    for (const PlannedSetUp& s : c.plan.set_ups)
      for (const std::size_t a : s.anchors) {
        const Anchor& anchor = c.building.anchors[a];
        EXPECT_GT(outward(c.building, anchor).dot(s.axis - anchor.built), 3) << shape << ": " << s.id;
        EXPECT_TRUE(free_sight(c.building, s.axis, anchor.built, anchor.wing))
            << shape << ": " << s.id << " " << anchor.id;
      }
    std::map<const Anchor*, int> seen;
    for (const CameraStation& station : c.stations)
      for (const VisibleTag& tag : visible_tags(c.building, c.camera.truth, station.camera_from_building)) {
        ++seen[tag.anchor];
        const Eigen::Vector3d centre = station.camera_from_building.inverse().translation;
        EXPECT_GT(outward(c.building, *tag.anchor).dot(centre - tag.anchor->built), 0)
            << shape << ": " << station.image;
      }
    EXPECT_EQ(seen.size(), c.building.anchors.size()) << shape << ": every plate is in some photograph";
  }
}

TEST(Wings, NobodyLooksThroughAWall) {
  Building block;
  block.width = 8, block.height = 8;
  block.wings = wings_of("block", 8, 0, 0);
  EXPECT_TRUE(free_sight(block, {0, -20, 1}, {2, -4.25, 1}, 0));
  EXPECT_FALSE(free_sight(block, {0, -20, 1}, {0, 20, 1}));
  EXPECT_TRUE(free_sight(block, {0, -20, 9}, {0, 20, 9})) << "over the roof";
  EXPECT_FALSE(free_sight(block, {0, -20, 1}, {0, 4.25, 1}, 2)) << "the far side from before the near one";
}

TEST(Wings, TheControlPointsMakeOneNetwork) {
  for (const std::string& shape : shape_names()) {
    const Campaign c = campaign_of(shape);
    std::vector<std::size_t> group(c.plan.set_ups.size());
    for (std::size_t i = 0; i < group.size(); ++i) group[i] = i;
    const auto share = [&](const PlannedSetUp& a, const PlannedSetUp& b) {
      const auto common = [](const auto& p, const auto& q) {
        return std::any_of(p.begin(), p.end(), [&](std::size_t i) { return std::count(q.begin(), q.end(), i) > 0; });
      };
      return common(a.ground_points, b.ground_points) || common(a.anchors, b.anchors);
    };
    for (std::size_t round = 0; round < group.size(); ++round)
      for (std::size_t i = 0; i < group.size(); ++i)
        for (std::size_t j = 0; j < group.size(); ++j)
          if (share(c.plan.set_ups[i], c.plan.set_ups[j])) group[i] = group[j] = std::min(group[i], group[j]);
    EXPECT_EQ(std::set<std::size_t>(group.begin(), group.end()).size(), 1u) << shape;
  }
}

TEST(Wings, WhatCannotBeIsRefusedInWords) {
  EXPECT_THROW(wings_of("round", 8, 1, 0), std::invalid_argument);
  CampaignOptions options;
  options.shape = "block", options.building.floors = 20, options.building.columns = 6;
  EXPECT_THROW(make_campaign(options, 1), std::invalid_argument) << "more tags than ids";
  options.building.floors = 2, options.obstruction.scaffold_spacing = 2;
  EXPECT_THROW(make_campaign(options, 1), std::invalid_argument) << "a scaffold around a corner";
}

}  // namespace test_wings
}  // namespace plumbline::simulate
