// simulate.observations: noise, blunders and layouts are of the size, the share and the kind that their parameters say.
#include <algorithm>
#include <cmath>
#include <map>

#include "artifacts/image_tags.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "node_harness.hpp"
#include "parameter_effects.hpp"

namespace plumbline::test {
namespace test_observations {

using Settings = std::vector<std::pair<std::string, std::string>>;

NodeHarness prepared(const Settings& settings) {
  NodeHarness node("simulate.observations");
  node.set("floors", "3"), node.set("pixel_sigma", "0"), node.set("survey_sigma", "0");
  for (const auto& [name, value] : settings) node.set(name, value);
  return node;
}

NodeHarness site(const Settings& settings) {
  NodeHarness node = prepared(settings);
  node.run();
  return node;
}

/// How far each corner lies from where it is without that, tag by tag.
std::vector<std::array<Eigen::Vector2d, 4>> corner_shifts(const Settings& settings) {
  const NodeHarness sound = site({}), wrong = site(settings);
  std::vector<std::array<Eigen::Vector2d, 4>> shifts;
  for (size_t i = 0; i < sound.output_count("observations"); ++i) {
    const auto before = sound.output<ImageTags>("observations", i), after = wrong.output<ImageTags>("observations", i);
    EXPECT_EQ(before.tags.size(), after.tags.size());
    for (size_t t = 0; t < std::min(before.tags.size(), after.tags.size()); ++t)
      for (size_t k = 0; k < 4; ++k)
        (k == 0 ? shifts.emplace_back() : shifts.back())[k] = after.tags[t]->corners[k] - before.tags[t]->corners[k];
  }
  return shifts;
}

/// Lengths of what is off at all: as many as `share` says of `all`, from `least` to `most`, in all directions.
void expect_blunders(const std::vector<Eigen::Vector2d>& off, size_t all, double share, double least, double most) {
  const auto n = static_cast<double>(all);
  EXPECT_NEAR(static_cast<double>(off.size()), share * n, 4 * std::sqrt(n * share * (1 - share)));
  ASSERT_GT(off.size(), 50u);
  double shortest = 1e9, longest = 0;
  Eigen::Vector2d direction = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& shift : off) {
    shortest = std::min(shortest, shift.norm()), longest = std::max(longest, shift.norm());
    direction += shift.normalized() / static_cast<double>(off.size());
  }
  EXPECT_GE(shortest, least - 1e-9);
  EXPECT_LT(shortest, least + 0.1 * (most - least));
  EXPECT_LE(longest, most + 1e-9);
  EXPECT_GT(longest, most - 0.1 * (most - least));
  EXPECT_LT(direction.norm(), 4 / std::sqrt(static_cast<double>(off.size())));
}

TEST(SimulatedBlunders, OfTagsMoveAllFourCornersTogether) {
  const auto shifts = corner_shifts({{"tag_blunders", "0.3"}, {"tag_blunder_size", "30"}});
  std::vector<Eigen::Vector2d> off;
  for (const auto& corners : shifts) {
    for (const Eigen::Vector2d& corner : corners) EXPECT_LT((corner - corners[0]).norm(), 1e-9);
    if (corners[0].norm() > 0) off.push_back(corners[0]);
  }
  expect_blunders(off, shifts.size(), 0.3, 5, 30);
}

TEST(SimulatedBlunders, OfCornersAreEachOnesOwn) {
  const auto shifts = corner_shifts({{"corner_blunders", "0.2"}, {"corner_blunder_size", "12"}});
  std::vector<Eigen::Vector2d> off;
  for (const auto& corners : shifts)
    for (const Eigen::Vector2d& corner : corners)
      if (corner.norm() > 0) off.push_back(corner);
  expect_blunders(off, 4 * shifts.size(), 0.2, 2, 12);
}

TEST(SimulatedBlunders, OfControlAreAShareOfItAndOfOneSize) {
  const auto sound = site({}).output<Points>("points"),
             wrong = site({{"control_blunders", "0.25"}, {"blunder_size", "0.05"}}).output<Points>("points");
  size_t control = 0;
  std::vector<Eigen::Vector3d> off;
  for (size_t i = 0; i < sound.points.size(); ++i) {
    const Eigen::Vector3d shift = wrong.points[i]->position - sound.points[i]->position;
    control += sound.points[i]->role == "control";
    if (shift.norm() == 0) continue;
    EXPECT_EQ(sound.points[i]->role, "control") << sound.points[i]->id;
    EXPECT_NEAR(shift.norm(), 0.05, 1e-12) << sound.points[i]->id;
    off.push_back(shift);
  }
  EXPECT_EQ(control, 24u);
  ASSERT_EQ(off.size(), 6u);
  EXPECT_LT(std::abs(off[0].dot(off[1])), 0.999 * 0.05 * 0.05) << "each in a direction of its own";
}

TEST(SimulatedNoise, OfPointsIsWhatTheirCovarianceSays) {
  const NodeHarness node = site({{"survey_sigma", "0.001"}, {"height_walk", "0.002"}});
  const PointsT points = node.output<Points>("points");
  std::map<std::string, int> floor;
  for (const auto& plate : node.output<Plates>("plates").plates) floor[plate->anchor] = plate->floor;
  ASSERT_EQ(points.covariance.size(), 3 * points.points.size() * (3 * points.points.size() + 1) / 2);
  for (size_t i = 0; i < 3 * points.points.size(); ++i)
    for (size_t j = 0; j <= i; ++j) {
      const int common = std::min(floor.at(points.points[i / 3]->id), floor.at(points.points[j / 3]->id)) - 1;
      const double expected = (i == j ? 1e-6 : 0) + (i % 3 == 2 && j % 3 == 2 ? 4e-6 * common : 0);
      EXPECT_NEAR(points.covariance[i * (i + 1) / 2 + j], expected, 1e-15) << i << " " << j;
      if (i != j) continue;
      EXPECT_NEAR(points.points[i / 3]->sigma[static_cast<Eigen::Index>(i % 3)], std::sqrt(expected), 1e-12);
    }
}

TEST(SimulatedNoise, OfReadingsGrowsAndNobodyIsTold) {
  const PointsT none = site({}).output<Points>("points");
  const auto of = [&](const char* factor) {
    const PointsT points = site({{"survey", "readings"}, {"survey_noise", factor}}).output<Points>("points");
    double off = 0, sigma = 0;
    for (size_t i = 0; i < points.points.size(); ++i) {
      off += (points.points[i]->position - none.points[i]->position).squaredNorm();
      sigma += points.points[i]->sigma.squaredNorm();
    }
    return std::pair(std::sqrt(off), std::sqrt(sigma));
  };
  const auto [off, sigma] = of("1");
  const auto [far_off, same_sigma] = of("6");
  EXPECT_NEAR(same_sigma / sigma, 1, 0.02);
  EXPECT_NEAR(off / sigma, 1, 0.6);
  EXPECT_GT(far_off / off, 3);
  EXPECT_LT(far_off / off, 6.5);
}

TEST(SimulatedNoise, OfCornersIsStatedAsItIs) {
  const NodeHarness node = site({{"pixel_sigma", "0.25"}});
  for (size_t i = 0; i < node.output_count("observations"); ++i)
    for (const auto& tag : node.output<ImageTags>("observations", i).tags) {
      ASSERT_EQ(tag->corner_covariances.size(), 12u);
      for (size_t k = 0; k < 12; ++k) EXPECT_EQ(tag->corner_covariances[k], k % 3 == 1 ? 0 : 0.0625);
    }
  double sum = 0, count = 0;
  for (const auto& corners : corner_shifts({{"pixel_sigma", "0.25"}}))
    for (const Eigen::Vector2d& corner : corners) sum += corner.squaredNorm(), count += 2;
  EXPECT_NEAR(std::sqrt(sum / count), 0.25, 0.25 * 4 / std::sqrt(2 * count));
}

/// By the words of the parameter: the rest of control only ties the images together.
TEST(SimulatedControl, LayoutsHoldTheModelWithThePointsOfTheirName) {
  for (const std::string layout : {"all", "two_per_floor", "ground_floor", "one_column"}) {
    const NodeHarness node = site({{"control", layout}});
    const PointsT points = node.output<Points>("points"), truth = node.output<Points>("truth");
    std::map<std::string, std::string> surveyed, compared;
    for (const auto& point : points.points) surveyed[point->id] = point->role;
    for (const auto& point : truth.points) compared[point->id] = point->role;
    for (const auto& plate : node.output<Plates>("plates").plates) {
      const bool known = plate->row > 0, lower_left = plate->floor % 2 == 1;
      const bool holds =
          known && (layout == "all" || (layout == "ground_floor" && plate->floor == 1) ||
                    (layout == "one_column" && plate->column == 1) ||
                    (layout == "two_per_floor" && ((plate->column == 1 && plate->row == (lower_left ? 1 : 2)) ||
                                                   (plate->column == 4 && plate->row == (lower_left ? 2 : 1)))));
      EXPECT_EQ(plate->role, holds ? "control" : "check") << layout << " " << plate->anchor;
      EXPECT_EQ(surveyed.at(plate->anchor), plate->role) << layout << " " << plate->anchor;
      EXPECT_EQ(compared.at(plate->anchor), holds   ? "control"
                                            : known ? "tie"
                                                    : "check")
          << layout << ": errors are compared on the same anchors whatever the layout, " << plate->anchor;
    }
  }
}

TEST(SimulatedSite, PlatesComeFromAsManyBatchesAsTheyWerePrintedIn) {
  std::map<std::string, int> batches;
  for (const auto& plate : site({{"print_batches", "3"}}).output<Plates>("plates").plates) ++batches[plate->batch];
  EXPECT_EQ(batches.size(), 3u);
  for (const char* name : {"batch-1", "batch-2", "batch-3"}) EXPECT_GT(batches[name], 0) << name;
}

TEST(SimulateObservations, EveryParameterHasItsEffect) {
  const auto situation = [](const Settings& settings) -> Situation {
    return [=] {
      NodeHarness node = prepared(settings);
      node.set("floors", "2"), node.set("images_per_floor", "4");
      return node;
    };
  };
  // What only rendered photographs have is refused from a usual size on (test_nodes.cpp).
  EXPECT_EQ(parameters_at_fault(
                {situation({}), situation({{"survey", "readings"}}),
                 situation({{"control_blunders", "0.3"}, {"tag_blunders", "0.3"}, {"corner_blunders", "0.3"}}),
                 situation({{"scaffold_spacing", "2"}}), situation({{"shape", "set_back"}})},
                {"jpeg_quality"}),
            "");
}

}  // namespace test_observations
}  // namespace plumbline::test
