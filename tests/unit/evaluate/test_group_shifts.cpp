// Shifts of floors, facades, columns and batches: told as one sentence, and only where there is one.
#include <gtest/gtest.h>

#include <numbers>

#include "../bim/facing.hpp"
#include "building/judgement/common_shift.hpp"
#include "building/judgement/deviation.hpp"
#include "building/judgement/group_shifts.hpp"
#include "building/judgement/moderated_variance.hpp"
#include "building/judgement/place_statistics.hpp"
#include "small_building.hpp"

namespace plumbline::judgement {
namespace test_group_shifts {

using judgement::test::isotropic;
using judgement::test::mm;
using judgement::test::Normal;

/// Facades around a square, each with its own direction, as built as designed.
DeviationInputs block(int facades, int columns, int rows) {
  DeviationInputs inputs;
  inputs.design_file = "d.ifc";
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < facades * columns; ++column) {
      AnchorCase anchor;
      const Eigen::Vector3d out = ifc::facing(0.5 * std::numbers::pi * (column / columns));
      anchor.id = "A" + std::to_string(row) + "." + std::to_string(column), anchor.element.guid = "g" + anchor.id;
      anchor.element.batch = (row + column) % 2 ? "odd" : "even";
      anchor.floor = row + 1, anchor.column = column + 1, anchor.use = "check";
      anchor.facade = ifc::frame_facing(out, ifc::FacadeSource::rule, true);
      anchor.facade.facade = std::string(1, static_cast<char>('A' + column / columns));
      anchor.design = 10 * out + anchor.facade.right * (2.0 * (column % columns)) + Eigen::Vector3d(0, 0, 3.0 * row);
      anchor.tolerances = tolerances_of({}, {});
      inputs.model.ids.push_back(anchor.id), inputs.model.positions.push_back(anchor.design);
      inputs.anchors.push_back(anchor);
    }
  inputs.model.covariance = isotropic(inputs.model.ids.size(), 0.4 * mm);
  return inputs;
}

DeviationInputs grid(int columns, int rows) { return block(1, columns, rows); }

TEST(GroupShifts, AFloorThatHangsLowIsOneSentence) {
  DeviationInputs inputs = grid(5, 4);
  Normal normal(5);
  for (std::size_t i = 0; i < inputs.model.positions.size(); ++i) {
    inputs.model.positions[i] += Eigen::Vector3d(normal(), normal(), normal()) * 0.8 * mm;
    if (inputs.anchors[i].floor == 2) inputs.model.positions[i].z() -= 12 * mm;
  }
  const DeviationT result = judge_deviations(inputs, {});
  EXPECT_EQ(result.failed, 5);
  ASSERT_FALSE(result.group_shifts.empty());
  const GroupShiftT& floor = *result.group_shifts[0];
  ASSERT_TRUE(floor.significant);
  EXPECT_EQ(floor.name, "Floor 2");
  EXPECT_EQ(floor.facade, "") << "of all facades";
  EXPECT_EQ(floor.column, 0);
  EXPECT_NEAR(floor.shift.z(), -12 * mm, 1 * mm);
  EXPECT_EQ(floor.would_pass, 5);
  EXPECT_NE(floor.words.find("Floor 2 hangs 1"), std::string::npos) << floor.words;
  EXPECT_NE(floor.words.find(" low"), std::string::npos) << floor.words;
  EXPECT_EQ(floor.words.find(floor.finding + " (5 of its 5 anchors share it"), 0u) << floor.finding;
  ASSERT_EQ(floor.members.size(), 5u);
  for (const int member : floor.members) EXPECT_EQ(result.anchors.at(static_cast<std::size_t>(member))->floor, 2);
  for (std::size_t i = 1; i < result.group_shifts.size(); ++i) EXPECT_FALSE(result.group_shifts[i]->significant);
}

TEST(GroupShifts, AnchorsThatHappenToLieAlikeWereNotMeasuredBetter) {
  DeviationInputs inputs = grid(5, 4);
  for (std::size_t i = 0; i < inputs.model.positions.size(); ++i)
    if (inputs.anchors[i].floor == 2) inputs.model.positions[i].z() -= 12 * mm;
  const DeviationT result = judge_deviations(inputs, {});
  ASSERT_FALSE(result.group_shifts.empty());
  EXPECT_GT(result.group_shifts[0]->u.z(), 0.99 * 0.4 * mm / std::sqrt(5.0));  // of five anchors of 0.4 mm each
}

TEST(GroupShifts, ChanceIsNoShift) {
  int alarms = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    DeviationInputs inputs = grid(6, 6);
    Normal normal(seed);
    for (auto& p : inputs.model.positions) p += Eigen::Vector3d(normal(), normal(), normal()) * 3 * mm;
    for (const auto& group : judge_deviations(inputs, {}).group_shifts) alarms += group->significant;
  }
  EXPECT_LE(alarms, 1);  // 0.1 % of a hundred buildings
}

/// Facades that are rough out of their plane and true in height, or the other way round, share nothing for that: a test
/// that takes both for one scatter gives 3 alarms in 20 such buildings.
TEST(GroupShifts, UnequalScatterIsNoShift) {
  int common = 0, groups = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed)
    for (const bool outward : {true, false}) {
      const DeviationInputs inputs = seed % 2 ? block(4, 4, 6) : block(1, 5, 4);
      Normal normal(seed);
      std::vector<GroupMember> members;
      std::vector<Eigen::Vector3d> deviations;
      for (const AnchorCase& a : inputs.anchors) {
        const Eigen::Vector3d rough = outward ? a.facade.out : Eigen::Vector3d(0, 0, 1);
        deviations.push_back(Eigen::Vector3d(normal(), normal(), normal()) * mm + 8 * mm * normal() * rough);
        members.push_back({deviations.back(), a.floor, a.column, a.facade.facade, a.element.batch, a.axis, a.facade});
      }
      common += common_shift(inputs.model.positions, deviations, inputs.model.covariance, 5 * mm, {})->significant;
      for (const auto& group : group_shifts(members, inputs.model.covariance, 5 * mm, {})) groups += group->significant;
    }
  EXPECT_LE(common, 2);  // 0.1 % of 400 are 0.4
  EXPECT_LE(groups, 2);
}

/// A quarter of the building that stands out pulls the mean of all after it: that is one sentence, not two.
TEST(GroupShifts, OfWhatExplainsItThatWithFewerSentencesIsTold) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    DeviationInputs facade = block(4, 4, 6), building = block(4, 4, 6);
    Normal normal(seed);
    for (std::size_t i = 0; i < facade.anchors.size(); ++i) {
      const Eigen::Vector3d noise = Eigen::Vector3d(normal(), normal(), normal()) * 1.5 * mm;
      const ifc::FacadeFrame& frame = facade.anchors[i].facade;
      facade.model.positions[i] +=
          noise + (frame.facade == "B" ? Eigen::Vector3d(8 * mm * frame.out) : Eigen::Vector3d(0, 0, 0));
      building.model.positions[i] += noise + Eigen::Vector3d(9 * mm, 0, 0);
    }
    DeviationT result = judge_deviations(facade, {});
    EXPECT_FALSE(result.common_shift->significant) << result.common_shift->words;
    ASSERT_TRUE(result.group_shifts.at(0)->significant);
    EXPECT_EQ(result.group_shifts[0]->name, "Facade B");
    EXPECT_EQ(result.group_shifts[0]->facade, "B");
    EXPECT_NE(result.group_shifts[0]->words.find("too far out"), std::string::npos) << result.group_shifts[0]->words;
    EXPECT_FALSE(result.group_shifts.at(1)->significant) << result.group_shifts[1]->words;
    result = judge_deviations(building, {});
    EXPECT_TRUE(result.common_shift->significant);
    EXPECT_FALSE(result.group_shifts.at(0)->significant) << result.group_shifts[0]->words;
  }
}

/// A test of six motions at once does not see a shift of 1.5 mm that all share along one direction: that was told as
/// two sentences, one for each floor.
TEST(GroupShifts, ASmallShiftThatAllShareIsTheBuildings) {
  DeviationInputs inputs = grid(6, 2);
  for (std::size_t i = 0; i < inputs.anchors.size(); ++i) {
    inputs.model.positions[i] -= 1.5 * mm * inputs.anchors[i].facade.out;
    inputs.anchors[i].tolerances = tolerances_of({2 * mm, false, {}}, {});
  }
  inputs.model.covariance = isotropic(inputs.model.ids.size(), 0.9 * mm);
  const DeviationT result = judge_deviations(inputs, {});
  ASSERT_FALSE(result.common_shift->significant) << "else it is told already";
  std::string names;
  for (const auto& group : result.group_shifts)
    if (group->significant) names += (names.empty() ? "" : ", ") + group->name;
  EXPECT_EQ(names, "The building");
  EXPECT_EQ(result.group_shifts[0]->words.find("The building stands 1.5 mm ± "), 0u) << result.group_shifts[0]->words;
  for (const auto& group : judge_deviations(grid(6, 2), {}).group_shifts) EXPECT_NE(group->kind, "building");
}

TEST(GroupShifts, EachKindIsToldByItsName) {
  const auto told = [](const auto& shift) {
    DeviationInputs inputs = block(4, 4, 6);
    Normal normal(3);
    for (std::size_t i = 0; i < inputs.anchors.size(); ++i)
      inputs.model.positions[i] += Eigen::Vector3d(normal(), normal(), normal()) * mm + shift(inputs.anchors[i]);
    std::string names;
    for (const auto& group : judge_deviations(inputs, {}).group_shifts) {
      if (group->significant) names += (names.empty() ? "" : ", ") + group->name;
      EXPECT_EQ(group->kind == "column", group->column > 0) << group->name;
      EXPECT_EQ(group->kind.find("facade") != std::string::npos, !group->facade.empty()) << group->name;
    }
    return names;
  };
  const auto where = [](bool there, const Eigen::Vector3d& shift) -> Eigen::Vector3d {
    return there ? shift : Eigen::Vector3d(0, 0, 0);
  };
  const Eigen::Vector3d low(0, 0, -9 * mm);
  EXPECT_EQ(told([&](const AnchorCase& a) { return where(a.floor == 2, low); }), "Floor 2");
  EXPECT_EQ(told([&](const AnchorCase& a) { return where(a.column == 7, 9 * mm * a.facade.right); }), "Column 7");
  EXPECT_EQ(told([&](const AnchorCase& a) { return where(a.element.batch == "odd", low); }), "Print batch odd");
  EXPECT_EQ(
      told([&](const AnchorCase& a) { return where(a.floor == 3 && a.facade.facade == "D", 11 * mm * a.facade.out); }),
      "Floor 3 of facade D");
  EXPECT_EQ(told([&](const AnchorCase& a) { return where(a.floor == 1 || a.floor == 5, a.floor == 1 ? low : -low); }),
            "Floor 1, Floor 5");
}

/// People on site know axes: the same anchors are told by the axis and not by the marker column.
TEST(GroupShifts, WhatStandsAtAnAxisIsToldByIt) {
  DeviationInputs inputs = grid(5, 6);
  Normal normal(3);
  for (std::size_t i = 0; i < inputs.anchors.size(); ++i) {
    inputs.anchors[i].axis = "1" + std::to_string(inputs.anchors[i].column);
    inputs.model.positions[i] += Eigen::Vector3d(normal(), normal(), normal()) * mm;
    if (inputs.anchors[i].column == 4) inputs.model.positions[i] += 9 * mm * inputs.anchors[i].facade.right;
  }
  const DeviationT result = judge_deviations(inputs, {});
  ASSERT_TRUE(result.group_shifts.at(0)->significant);
  EXPECT_EQ(result.group_shifts[0]->kind + ": " + result.group_shifts[0]->name, "axis: Axis 14");
  for (const auto& group : result.group_shifts) EXPECT_NE(group->kind, "column");
}

TEST(PlaceStatistics, FloorsFromBelowThenAxesFromTheLeftInTheFrameOfTheFacade) {
  DeviationInputs inputs = block(2, 3, 2);
  for (std::size_t i = 0; i < inputs.anchors.size(); ++i) {
    const auto& frame = inputs.anchors[i].facade;
    const double away = inputs.anchors[i].column == 2 ? 3 * mm : 1 * mm;
    inputs.model.positions[i] += away * frame.right + 2.0 * inputs.anchors[i].floor * mm * frame.out;
  }
  const DeviationT judged = judge_deviations(inputs, {});
  const auto rows = place_statistics(judged, [](const AnchorDeviationT& anchor) {
    return std::string(1, static_cast<char>('Z' - (anchor.column - 1) % 3));  // tags run against the places
  });
  std::string names;
  for (const PlaceStatistics& row : rows) names += row.facade + row.kind[0] + row.name + " ";
  EXPECT_EQ(names, "Af1 Af2 AaZ AaY AaX Bf1 Bf2 BaZ BaY BaX ");
  EXPECT_NEAR(rows[0].mean.x(), 5 * mm / 3, 1e-12);
  EXPECT_NEAR(rows[1].mean.z(), 4 * mm, 1e-12);
  EXPECT_NEAR(rows[0].spread.x(), std::sqrt(4.0 / 3) * mm, 1e-12) << "1, 3 and 1 mm";
  EXPECT_NEAR(rows[3].mean.x(), 3 * mm, 1e-12);
  EXPECT_NEAR(rows[8].mean.x(), 1 * mm, 1e-12);
  EXPECT_EQ(rows[3].measured, 2);
}

/// Against what the method promises: variances that are equal give all of their freedom, others give little.
TEST(ModeratedVariance, TakesFromTheOthersAsMuchAsTheyAreAlike) {
  Normal normal(11);
  const auto sample = [&](double sigma) {
    double squares = 0;
    for (int i = 0; i < 5; ++i) squares += std::pow(sigma * normal(), 2);
    return SampleVariance{squares / 5, 5};
  };
  std::vector<SampleVariance> equal, unequal;
  for (int i = 0; i < 400; ++i) {
    equal.push_back(sample(2));
    double inverse = 0;  // true variances: 6 · 4 / χ² of 6
    for (int k = 0; k < 6; ++k) inverse += std::pow(normal(), 2);
    unequal.push_back(sample(std::sqrt(6 * 4 / inverse)));
  }
  const SampleVariance one = variance_prior(equal), many = variance_prior(unequal);
  EXPECT_NEAR(one.variance, 4, 0.5);
  EXPECT_GT(one.freedom, 50);
  EXPECT_NEAR(many.variance, 4, 0.8);
  EXPECT_NEAR(many.freedom, 6, 2);
  EXPECT_EQ(variance_prior({{3, 5}}).freedom, 0);
  EXPECT_EQ(moderated({3, 5}, {}).variance, 3);
  EXPECT_NEAR(moderated({3, 5}, {4, 5}).variance, 3.5, 1e-12);
}

}  // namespace test_group_shifts
}  // namespace plumbline::judgement
