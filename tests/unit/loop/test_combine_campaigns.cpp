// All campaigns as one estimate: beside the adjustment of all of them at once, and what it says moved.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "geometry/random.hpp"
#include "geometry/statistics.hpp"
#include "loop/estimate/combine_campaigns.hpp"

namespace plumbline::loop {
namespace test_combine_campaigns {

constexpr CombineOptions kNoDrift{0, 1e-3, 1e-6};

/// `n` anchors, five to a floor, a metre apart.
Eigen::VectorXd truth_of(int n) {
  Eigen::VectorXd places(3 * n);
  for (int i = 0; i < n; ++i) places.segment<3>(3 * i) = Eigen::Vector3d(i % 5, 0, 4.0 * (i / 5));
  return places;
}

/// `single` of each coordinate, `set_up` common to the anchors of a floor.
Eigen::MatrixXd own_of(int n, double single, double set_up) {
  Eigen::MatrixXd own = Eigen::MatrixXd::Zero(3 * n, 3 * n);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      if (i / 5 == j / 5)
        own.block<3, 3>(3 * i, 3 * j).diagonal().setConstant(set_up * set_up + (i == j ? single * single : 0));
  return own;
}

AnchorPlaces campaign(const std::string& name, const Eigen::VectorXd& truth, const Eigen::MatrixXd& own,
                      std::uint64_t seed) {
  Random random(seed, "campaign " + name);
  AnchorPlaces places;
  const auto n = static_cast<int>(truth.size() / 3);
  for (int i = 0; i < n; ++i)
    places.ids.push_back("a" + std::to_string(i)), places.floors.push_back(1 + i / 5),
        places.campaigns.push_back(name + " ");
  Eigen::VectorXd z(truth.size());
  for (double& value : z) value = random.normal();
  places.places = truth + Eigen::MatrixXd(own.llt().matrixL()) * z, places.own = own;
  return places;
}

AnchorPlaces without(AnchorPlaces places, std::size_t anchor) {
  std::vector<Eigen::Index> rows;
  for (std::size_t i = 0; i < places.size(); ++i)
    for (Eigen::Index k = 0; k < 3; ++k)
      if (i != anchor) rows.push_back(3 * static_cast<Eigen::Index>(i) + k);
  places.places = Eigen::VectorXd(places.places(rows)), places.own = Eigen::MatrixXd(places.own(rows, rows));
  const auto at = static_cast<std::ptrdiff_t>(anchor);
  places.ids.erase(places.ids.begin() + at), places.floors.erase(places.floors.begin() + at);
  places.campaigns.erase(places.campaigns.begin() + at);
  return places;
}

Eigen::Index row_of(const AnchorPlaces& places, const std::string& id) {
  return 3 * (std::find(places.ids.begin(), places.ids.end(), id) - places.ids.begin());
}

/// Four campaigns; anchor 2 is worked on after the second, anchor 4 is not in the third. Beside it the normal equations
/// of all four at once, in which anchor 2 is another unknown since it was worked on.
TEST(CombineCampaigns, IsTheAdjustmentOfAllCampaignsAtOnce) {
  constexpr int n = 5;
  const Eigen::VectorXd before = truth_of(n);
  Eigen::VectorXd after = before;
  after.segment<3>(6) += Eigen::Vector3d(0.01, -0.02, 0.03);
  std::vector<AnchorPlaces> campaigns;
  for (int r = 0; r < 4; ++r)
    campaigns.push_back(campaign("c" + std::to_string(r), r < 2 ? before : after,
                                 own_of(n, 0.0003 + 0.0001 * r, 0.0008 - 0.0001 * r), 3));
  campaigns[2] = without(campaigns[2], 4);
  AnchorPlaces estimate;
  for (int r = 0; r < 4; ++r)
    estimate = combine_campaigns(estimate, campaigns[r], r == 2 ? std::set<std::string>{"a2"} : std::set<std::string>{},
                                 kNoDrift)
                   .estimate;
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(3 * n + 3, 3 * n + 3);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(3 * n + 3);
  for (int r = 0; r < 4; ++r) {
    const AnchorPlaces& c = campaigns[r];
    std::vector<Eigen::Index> unknowns;
    for (const std::string& id : c.ids) {
      const Eigen::Index anchor = id == "a2" && r >= 2 ? n : std::stoi(id.substr(1));
      for (Eigen::Index k = 0; k < 3; ++k) unknowns.push_back(3 * anchor + k);
    }
    const Eigen::MatrixXd weight = c.own.inverse();
    const Eigen::VectorXd weighted = weight * c.places;
    for (std::size_t i = 0; i < unknowns.size(); ++i) {
      right[unknowns[i]] += weighted[static_cast<Eigen::Index>(i)];
      for (std::size_t j = 0; j < unknowns.size(); ++j)
        normal(unknowns[i], unknowns[j]) += weight(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
    }
  }
  const Eigen::MatrixXd cofactor = normal.inverse();
  const Eigen::VectorXd solution = cofactor * right;
  ASSERT_EQ(estimate.size(), 5u);
  for (const std::string& i : estimate.ids)
    for (const std::string& j : estimate.ids) {
      const auto at = [&](const std::string& id) { return id == "a2" ? 3 * n : 3 * std::stoi(id.substr(1)); };
      const Eigen::Index a = row_of(estimate, i), b = row_of(estimate, j);
      EXPECT_LT((estimate.places.segment<3>(a) - solution.segment<3>(at(i))).norm(), 1e-12) << i;
      EXPECT_LT((estimate.own.block<3, 3>(a, b) - cofactor.block<3, 3>(at(i), at(j))).norm(), 1e-15) << i << " " << j;
    }
  EXPECT_EQ(estimate.campaigns[0], "c0 c1 c2 c3 ");
  EXPECT_EQ(estimate.campaigns[row_of(estimate, "a2") / 3], "c2 c3 ");
}

TEST(CombineCampaigns, ACampaignCountsOnce) {
  const AnchorPlaces first = campaign("first", truth_of(5), own_of(5, 0.0003, 0.0004), 1);
  const AnchorPlaces once = combine_campaigns({}, first, {}).estimate;
  const CombinedCampaigns twice = combine_campaigns(once, first, {});
  EXPECT_EQ(twice.compared, 0);
  EXPECT_LT((twice.estimate.own - once.own).norm(), 1e-18);
  EXPECT_EQ(twice.estimate.campaigns, once.campaigns);
}

TEST(CombineCampaigns, WhatMovedIsNamedAndStartsAnew) {
  const Eigen::VectorXd truth = truth_of(10);
  const Eigen::MatrixXd own = own_of(10, 0.0003, 0.0004);
  const AnchorPlaces before = combine_campaigns({}, campaign("first", truth, own, 1), {}).estimate;
  Eigen::VectorXd moved = truth;
  moved[3 * 7 + 2] -= 0.003;
  const AnchorPlaces second = campaign("second", moved, own, 1);
  const CombinedCampaigns one = combine_campaigns(before, second, {});
  ASSERT_EQ(one.moved.size(), 1u);
  EXPECT_EQ(one.moved[0].id, "a7");
  EXPECT_NEAR(one.moved[0].shift.z(), -0.003, 0.001);
  EXPECT_EQ(one.estimate.campaigns[row_of(one.estimate, "a7") / 3], "second ");
  EXPECT_EQ(one.estimate.campaigns[row_of(one.estimate, "a6") / 3], "first second ");
  // The set-up is known by the four anchors that stayed: better than by this campaign alone.
  const Eigen::Index a7 = row_of(one.estimate, "a7");
  EXPECT_LT(one.estimate.own(a7, a7), 0.85 * own(21, 21));
  EXPECT_NE(words_of(one)[0].find("a7 is 3."), std::string::npos) << words_of(one)[0];

  moved = truth;
  for (int i = 5; i < 10; ++i) moved[3 * i + 2] += 0.006;
  const CombinedCampaigns floor = combine_campaigns(before, campaign("third", moved, own, 1), {});
  ASSERT_EQ(floor.moved.size(), 1u);
  EXPECT_EQ(floor.moved[0].id, "");
  EXPECT_EQ(floor.moved[0].floor, 2);
  EXPECT_NE(words_of(floor)[0].find("the anchors of floor 2 are together"), std::string::npos) << words_of(floor)[0];
}

/// Towers on which nothing moves, six campaigns each: alarms are as rare as is said, and the estimate is as good as it
/// says.
/// Many at once: those and no others, and what is left is the estimate without them.
TEST(CombineCampaigns, ManyThatMovedAreAllNamedAndLeaveTheEstimateOfTheOthers) {
  constexpr int n = 40;
  const Eigen::VectorXd before = truth_of(n);
  Eigen::VectorXd after = before;
  std::set<std::string> moved;
  for (int i = 0; i < n; i += 2)
    after.segment<3>(3 * i) += 0.01 * Eigen::Vector3d(i % 4 == 0 ? 1 : -1, 0.5, 0.1 * (i % 7)),
        moved.insert("a" + std::to_string(i));
  const Eigen::MatrixXd own = own_of(n, 0.0003, 0.0008);
  const AnchorPlaces first = campaign("c1", before, own, 8), second = campaign("c2", after, own, 8);
  const CombinedCampaigns combined = combine_campaigns(first, second, {}, kNoDrift);
  std::set<std::string> named;
  for (const MovedAnchor& one : combined.moved) named.insert(one.id);
  EXPECT_EQ(named, moved);
  EXPECT_EQ(combined.compared, n / 2);
  const AnchorPlaces told = combine_campaigns(first, second, moved, kNoDrift).estimate;
  ASSERT_EQ(told.size(), combined.estimate.size());
  for (const std::string& i : told.ids)
    for (const std::string& j : told.ids) {
      const Eigen::Index a = row_of(told, i), b = row_of(told, j);
      const Eigen::Index c = row_of(combined.estimate, i), d = row_of(combined.estimate, j);
      EXPECT_LT((told.places.segment<3>(a) - combined.estimate.places.segment<3>(c)).norm(), 1e-12) << i;
      EXPECT_LT((told.own.block<3, 3>(a, b) - combined.estimate.own.block<3, 3>(c, d)).norm(), 1e-15) << i << " " << j;
    }
}

TEST(CombineCampaigns, FalseAlarmsAndCovarianceAreTrue) {
  const Eigen::VectorXd truth = truth_of(20);
  const Eigen::MatrixXd own = own_of(20, 0.0003, 0.0004);
  CombineOptions options = kNoDrift;
  options.false_alarm = 0.02;
  int alarms = 0, campaigns = 0, repeats = 0;
  double squares = 0;
  constexpr int kTowers = 200;
  for (std::uint64_t seed = 1; seed <= kTowers; ++seed) {
    AnchorPlaces estimate;
    for (int r = 0; r < 6; ++r) {
      const CombinedCampaigns c =
          combine_campaigns(estimate, campaign("c" + std::to_string(r), truth, own, seed), {}, options);
      alarms += !c.moved.empty(), campaigns += r > 0, repeats += c.repeats;
      estimate = c.estimate;
    }
    for (std::size_t i = 0; i < estimate.size(); ++i) {
      const Eigen::Index at = 3 * static_cast<Eigen::Index>(i), of_truth = 3 * std::stoi(estimate.ids[i].substr(1));
      const Eigen::Vector3d off = estimate.places.segment<3>(at) - truth.segment<3>(of_truth);
      squares += off.dot(estimate.own.block<3, 3>(at, at).inverse() * off);
    }
  }
  const Interval share = wilson_interval(alarms, campaigns, 0.99);
  // Anchors and floors are tested, and a group of anchors shares the campaign's error: at most what was asked for and
  // a quarter for the floors.
  EXPECT_LT(share.lower, 0.025) << alarms;
  EXPECT_GT(share.upper, 0.008) << alarms;
  EXPECT_EQ(repeats, 0);
  EXPECT_NEAR(squares / (3 * 20 * kTowers), 1, 0.08);
}

TEST(CombineCampaigns, AFolderThatHoldsTheReadingsOfTheOneBeforeCountsAlone) {
  const Eigen::MatrixXd own = own_of(10, 0.0003, 0.0004);
  const AnchorPlaces first = campaign("first", truth_of(10), own, 1);
  AnchorPlaces again = campaign("again", truth_of(10), own, 1);
  again.places = first.places + 0.02 * (again.places - truth_of(10));  // a few readings more
  const CombinedCampaigns combined = combine_campaigns(first, again, {});
  EXPECT_TRUE(combined.repeats);
  EXPECT_EQ(combined.estimate.campaigns, again.campaigns);
  EXPECT_LT((combined.estimate.own - own).norm(), 1e-18);
  ASSERT_EQ(words_of(combined).size(), 1u);
  EXPECT_NE(words_of(combined)[0].find("does it hold readings of theirs"), std::string::npos);
}

/// One more reading of one anchor, from the same set-up: the set-up's error is no other one by that.
TEST(CombineCampaigns, AFolderThatGotAReadingMoreIsNoOtherCampaign) {
  const Eigen::MatrixXd own = own_of(5, 0.0003, 0.0008);
  const AnchorPlaces first = campaign("first", truth_of(5), own, 1);
  const AnchorPlaces once = combine_campaigns({}, first, {}, kNoDrift).estimate;
  AnchorPlaces again = first;
  again.places[7] += 0.0002, again.campaigns[2] = "again ";
  const CombinedCampaigns combined = combine_campaigns(once, again, {}, kNoDrift);
  EXPECT_EQ(combined.known, 4);
  EXPECT_TRUE(combined.repeats);
  EXPECT_LT((combined.estimate.own - own).norm(), 1e-18);
  ASSERT_EQ(words_of(combined).size(), 1u);
  EXPECT_NE(words_of(combined)[0].find("holds readings of that one"), std::string::npos) << words_of(combined)[0];
}

/// Anchors that sink slowly: the estimate follows, because a storey may drift from campaign to campaign.
TEST(CombineCampaigns, FollowsABuildingThatSinks) {
  const Eigen::MatrixXd own = own_of(5, 0.0003, 0.0004);
  for (const double drift : {0.0, 0.0002}) {
    AnchorPlaces estimate;
    Eigen::VectorXd truth = truth_of(5);
    CombineOptions options = kNoDrift;
    options.drift_per_storey = drift;
    for (int r = 0; r < 20; ++r) {
      estimate = combine_campaigns(estimate, campaign("c" + std::to_string(r), truth, own, 5), {}, options).estimate;
      for (int i = 0; i < 5; ++i) truth[3 * i + 2] -= 0.0001;
    }
    const double off = estimate.places[row_of(estimate, "a0") + 2] - truth[2];
    if (drift == 0)
      EXPECT_GT(std::abs(off), 4 * std::sqrt(estimate.own(2, 2)));
    else
      EXPECT_LT(std::abs(off), 3 * std::sqrt(estimate.own(2, 2)));
  }
}

}  // namespace test_combine_campaigns
}  // namespace plumbline::loop
