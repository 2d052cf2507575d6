// Two epochs with a point that was moved by a known amount.
#include <Eigen/Dense>
#include <algorithm>

#include "simulated_network.hpp"
#include "survey/epochs/check_control.hpp"
#include "survey/epochs/epoch_mistakes.hpp"
#include "survey/epochs/epoch_scale.hpp"
#include "test_support.hpp"

namespace plumbline::survey {
namespace test_compare_epochs {

Epoch epoch(const SurveyObservations& survey) {
  AdjustOptions options;
  options.curvature = Switch::off;
  return epoch_of(adjust_network(survey, options));
}

/// Without stations: they stand elsewhere in every epoch.
Epoch markers(const Epoch& all) {
  Epoch e;
  std::vector<Eigen::Index> rows;
  for (size_t i = 0; i < all.ids.size(); ++i) {
    if (all.ids[i][0] != 'M') continue;
    e.ids.push_back(all.ids[i]);
    for (Eigen::Index c = 0; c < 3; ++c) rows.push_back(static_cast<Eigen::Index>(3 * i) + c);
  }
  e.coordinates = all.coordinates(rows);
  e.covariance = all.covariance(rows, rows);
  return e;
}

TEST(CompareEpochs, SameNetworkMeasuredTwiceIsCongruent) {
  const Comparison c =
      compare_epochs(markers(epoch(test::simulate({}, 21).survey)), markers(epoch(test::simulate({}, 22).survey)), {});
  EXPECT_TRUE(c.congruent) << c.statistic << " " << c.critical;
  EXPECT_EQ(c.rank, 3 * 12 - 4);
  EXPECT_TRUE(c.excluded.empty());
}

/// Half of a site settles by 4 mm: the half that stayed was said to have risen, with certainty.
TEST(CompareEpochs, WhichOfTwoBodiesStayedIsNotToldByAFreeNetwork) {
  const Epoch first = markers(epoch(test::simulate({}, 21).survey));
  Epoch second = markers(epoch(test::simulate({}, 22).survey));
  for (std::size_t i = 0; i < second.ids.size() / 2; ++i)
    second.coordinates[static_cast<Eigen::Index>(3 * i) + 2] -= 0.004;
  const Comparison c = compare_epochs(first, second, {});
  EXPECT_EQ(c.excluded.size() + c.other_body.size(), first.ids.size());
  EXPECT_GE(c.other_body.size(), 5u);
  EXPECT_NE(two_bodies_in_words(c).find("which of the two stayed"), std::string::npos);
  ComparisonOptions held;
  held.free_motions = 0;
  EXPECT_TRUE(compare_epochs(first, second, held).other_body.empty());
  EXPECT_TRUE(c.bodies_are_rivals());
  // Three of a settling corner are no rival of those that stayed; that they may be the references is said all the same.
  Epoch corner = markers(epoch(test::simulate({}, 22).survey));
  for (Eigen::Index i = 0; i < 3; ++i) corner.coordinates[3 * i + 2] -= 0.004;
  const Comparison few = compare_epochs(first, corner, {});
  EXPECT_EQ(few.excluded.size(), 3u);
  EXPECT_EQ(few.other_body.size(), first.ids.size() - 3);
  EXPECT_FALSE(few.bodies_are_rivals());
  EXPECT_NE(two_bodies_in_words(few).find("are the references, it was the others that moved"), std::string::npos)
      << two_bodies_in_words(few);
  // One that settles is no body.
  Epoch one = markers(epoch(test::simulate({}, 22).survey));
  one.coordinates[2] -= 0.004;
  EXPECT_EQ(two_bodies_in_words(compare_epochs(first, one, {})), "");
  // Points that move each by itself are no body.
  Epoch scattered = markers(epoch(test::simulate({}, 22).survey));
  for (Eigen::Index i = 0; i < 4; ++i) scattered.coordinates[3 * i + i % 3] += i % 2 == 0 ? 0.02 : -0.03;
  EXPECT_TRUE(compare_epochs(first, scattered, {}).other_body.empty());
}

/// An epoch in feet once gave movements of 18 m with sigmas of half a millimetre.
TEST(CompareEpochs, AnEpochOfAnotherSizeIsSeenAndANoisyOneIsNot) {
  const Epoch first = markers(epoch(test::simulate({}, 21).survey));
  EXPECT_FALSE(common_scale(first, first));
  for (std::uint64_t seed = 22; seed < 30; ++seed)
    EXPECT_FALSE(common_scale(first, markers(epoch(test::simulate({}, seed).survey)))) << seed;
  Epoch feet = markers(epoch(test::simulate({}, 22).survey));
  feet.coordinates /= 0.3048;
  ASSERT_TRUE(common_scale(first, feet));
  EXPECT_NEAR(*common_scale(first, feet), 3.28084, 1e-3);
  EXPECT_NE(scale_in_words(*common_scale(first, feet)).find("the second is in feet"), std::string::npos);
  EXPECT_NE(scale_in_words(*common_scale(feet, first)).find("the first is in feet"), std::string::npos);
  Epoch longer = first;
  longer.coordinates *= 1 + 387e-6;
  longer.coordinates[2] += 0.02;  // and one point that moved
  ASSERT_TRUE(common_scale(first, longer));
  EXPECT_NE(scale_in_words(*common_scale(first, longer)).find("387 ppm longer"), std::string::npos);
}

/// 10 K make 60 m of concrete 6 mm longer, which looks like movement; what the page says goes with the numbers.
TEST(CompareEpochs, WhatTheTemperatureMayDoIsSaidWhereItMatters) {
  const double nan = std::nan("");
  const std::vector<Eigen::Vector3d> tower = {{0, 0, 0}, {30, 0, 0}, {30, 0, 60}, {0, 0, 60}},
                                     marks = {{nan, nan, 3}, {nan, nan, 63}};
  const auto of = [](double sigma) { return std::vector<Eigen::Vector3d>(4, Eigen::Vector3d::Constant(sigma)); };
  ASSERT_EQ(size_notes(std::nullopt, tower, of(0.002)).size(), 1u);
  EXPECT_NE(size_notes(std::nullopt, tower, of(0.002))[0].find(
                "its 60.0 m of height 6.0 mm longer or shorter, and its 30.0 m of width 3.0 mm"),
            std::string::npos);
  EXPECT_TRUE(size_notes(std::nullopt, tower, of(0.0031)).empty());
  EXPECT_TRUE(size_notes(std::nullopt, tower, of(nan)).empty());
  ASSERT_EQ(size_notes(std::nullopt, marks, of(0.001)).size(), 1u);
  EXPECT_NE(size_notes(std::nullopt, marks, of(0.001))[0].find("60.0 m of height"), std::string::npos);
  ASSERT_EQ(size_notes(1 + 120e-6, tower, of(1)).size(), 1u);
  EXPECT_NE(size_notes(1 + 120e-6, tower, of(1))[0].find("120 ppm longer than those of the first: a ppm setting, a map "
                                                         "scale or the temperature"),
            std::string::npos);
}

EpochVariance variance(const SurveyObservations& survey) {
  AdjustOptions options;
  options.curvature = Switch::off;
  const NetworkResult r = adjust_network(survey, options);
  return {r.sigma0, r.degrees_of_freedom};
}

/// Readings twice as noisy as stated, nothing moved: at the stated accuracies most pairs name points.
TEST(CompareEpochs, ReadingsNoisierThanStatedAreNoMovements) {
  test::SimulationSettings noisy;
  noisy.noise = 2;
  int by_stated = 0, by_variance = 0;
  for (std::uint64_t pair = 0; pair < 8; ++pair) {
    const auto a = test::simulate(noisy, 100 + 2 * pair), b = test::simulate(noisy, 101 + 2 * pair);
    const Epoch first = markers(epoch(a.survey)), second = markers(epoch(b.survey));
    const auto names_any = [](const Comparison& c) {
      return std::any_of(c.movements.begin(), c.movements.end(), [](const Movement& m) { return m.moved; });
    };
    by_stated += names_any(compare_epochs(first, second, {}));
    ComparisonOptions options;
    options.first_variance = variance(a.survey), options.second_variance = variance(b.survey);
    const Comparison c = compare_epochs(first, second, options);
    by_variance += names_any(c) || !c.congruent;
    EXPECT_GT(c.variances.degrees_of_freedom, 0) << c.variances.text;
    EXPECT_NEAR(c.variances.first_factor, 4, 1.5);
    EXPECT_NE(c.variances.text.find("noisier than stated"), std::string::npos) << c.variances.text;
  }
  EXPECT_GE(by_stated, 5);
  EXPECT_LE(by_variance, 1);
}

/// As stated they are taken as stated; one epoch that is worse than the other counts with its own.
TEST(CompareEpochs, TheVarianceRatioIsTheFirstTest) {
  const VarianceTest good = test_variances({1.02, 80}, {0.97, 90}, 0.05);
  EXPECT_FALSE(good.differ);
  EXPECT_EQ(good.degrees_of_freedom, 0);
  EXPECT_EQ(good.first_factor, 1);
  const VarianceTest one = test_variances({1.0, 80}, {2.5, 60}, 0.05);
  EXPECT_TRUE(one.differ);
  EXPECT_NEAR(one.ratio, 6.25, 1e-12);
  EXPECT_EQ(one.first_factor, 1);
  EXPECT_NEAR(one.second_factor, 6.25, 1e-12);
  EXPECT_EQ(one.degrees_of_freedom, 60);
  // Scaled already: not twice.
  EXPECT_EQ(test_variances({2.0, 80, true}, {2.1, 80, true}, 0.05).first_factor, 1);
  EXPECT_NE(test_variances({1, 0}, {2, 50}, 0.05).text.find("cannot be tested"), std::string::npos);
}

TEST(CompareEpochs, FindsTheMovedMarkerAndItsMovement) {
  const auto first = test::simulate({}, 31);
  auto second = test::simulate({}, 32);
  // M12 has sunk by 6 mm: its zenith angles and distances are those of the lower point.
  const Eigen::Vector3d sunk(0, 0, -0.006);
  for (Observation& o : second.survey.observations) {
    if (o.to != "M12") continue;
    const Eigen::Vector3d& station = second.truth[12 + o.set_up];
    const Eigen::Vector3d before = second.truth[6] - station, after = before + sunk;
    if (o.kind == ObservationKind::slope_distance) o.value += after.norm() - before.norm();
    if (o.kind == ObservationKind::zenith_angle)
      o.value += std::atan2(after.head<2>().norm(), after.z()) - std::atan2(before.head<2>().norm(), before.z());
  }
  const Comparison c = compare_epochs(markers(epoch(first.survey)), markers(epoch(second.survey)), {});
  EXPECT_FALSE(c.congruent);
  ASSERT_EQ(c.excluded.size(), 1u);
  EXPECT_EQ(c.excluded[0].id, "M12");
  EXPECT_LE(c.excluded[0].statistic, c.excluded[0].critical);
  for (const Movement& m : c.movements) {
    EXPECT_EQ(m.moved, m.id == "M12") << m.id;
    if (m.id == "M12") {
      EXPECT_NEAR(m.movement.z(), -0.006, 3 * m.sigma.z());
    }
  }
}

/// A point of an epoch moved as if the building had.
void move(Epoch& e, const std::string& id, const Eigen::Vector3d& by) {
  const auto at = std::find(e.ids.begin(), e.ids.end(), id) - e.ids.begin();
  e.coordinates.segment<3>(3 * at) += by;
}

TEST(CompareEpochs, ShiftTurnAndOtherPointsDoNotMatter) {
  const Epoch first = markers(epoch(test::simulate({}, 51).survey));
  Epoch second = markers(epoch(test::simulate({}, 52).survey));
  const Comparison before = compare_epochs(first, second, {});
  const double angle = 2.1;
  Eigen::Matrix3d turn;
  turn << std::cos(angle), std::sin(angle), 0, -std::sin(angle), std::cos(angle), 0, 0, 0, 1;
  for (size_t i = 0; i < second.ids.size(); ++i) {
    auto p = second.coordinates.segment<3>(static_cast<Eigen::Index>(3 * i));
    p = (turn * p + Eigen::Vector3d(100, -250, 10)).eval();
  }
  const Epoch unturned = second;
  for (Eigen::Index i = 0; i < second.covariance.rows() / 3; ++i)
    for (Eigen::Index k = 0; k < second.covariance.rows() / 3; ++k)
      second.covariance.block<3, 3>(3 * i, 3 * k) =
          turn * unturned.covariance.block<3, 3>(3 * i, 3 * k) * turn.transpose();
  const Comparison after = compare_epochs(first, second, {});
  EXPECT_NEAR(after.statistic, before.statistic, 1e-6 * before.statistic);
  for (size_t i = 0; i < after.movements.size(); ++i)
    EXPECT_LT((after.movements[i].movement - before.movements[i].movement).norm(), 1e-8)
        << "in the first epoch's frame";
  ComparisonOptions fixed;
  fixed.free_motions = 0;
  EXPECT_FALSE(compare_epochs(first, second, fixed).congruent) << "a fixed frame sees the shift";
  std::vector<char> keep(second.ids.size(), 1);
  keep[3] = 0;
  Epoch part = part_of(second, keep);
  for (std::string& id : part.ids)
    if (id == "M00") id = "new";
  const Comparison fewer = compare_epochs(first, part, {});
  EXPECT_EQ(fewer.movements.size(), 10u);
  EXPECT_EQ(fewer.only_first, (std::vector<std::string>{"M00", "M03"}));
  EXPECT_EQ(fewer.only_second, std::vector<std::string>{"new"});
  EXPECT_EQ(fewer.rank, 3 * 10 - 4);
}

/// Two free networks compared as if both knew where they are: a statistic of 1e15 and all points moved, before.
TEST(CompareEpochs, FreeNetworksAreNotComparedAsFixedOnes) {
  ComparisonOptions fixed;
  fixed.free_motions = 0;
  const Epoch first = epoch(test::simulate({}, 51).survey), second = epoch(test::simulate({}, 52).survey);
  try {
    compare_epochs(first, second, fixed);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("datum=free"), std::string::npos) << error.what();
  }
}

TEST(CompareEpochs, TheStatisticIsThatOfTheSTransformedDifference) {
  // The same T through the pseudo-inverse of the covariance in the datum of all points.
  const Epoch first = markers(epoch(test::simulate({}, 61).survey)),
              second = markers(epoch(test::simulate({}, 62).survey));
  const Eigen::Index n = first.coordinates.size();
  Eigen::MatrixXd g = Eigen::MatrixXd::Zero(n, 4);
  for (Eigen::Index i = 0; i < n / 3; ++i) {
    g.block<3, 3>(3 * i, 0).setIdentity();
    g(3 * i, 3) = first.coordinates[3 * i + 1];
    g(3 * i + 1, 3) = -first.coordinates[3 * i];
  }
  const Eigen::MatrixXd s =
      Eigen::MatrixXd::Identity(n, n) - g * (g.transpose() * g).ldlt().solve(Eigen::MatrixXd(g.transpose()));
  const Eigen::VectorXd d = s * (second.coordinates - first.coordinates);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(s * (first.covariance + second.covariance) *
                                                             s.transpose());
  double statistic = 0;
  for (Eigen::Index k = 4; k < n; ++k)
    statistic += std::pow(eigen.eigenvectors().col(k).dot(d), 2) / eigen.eigenvalues()[k];
  EXPECT_LT(eigen.eigenvalues()[3], 1e-9 * eigen.eigenvalues()[4]);
  EXPECT_NEAR(compare_epochs(first, second, {}).statistic, statistic, 1e-6 * statistic);
}

/// Both epochs in one datum of the same errors: only the difference counts, so the rate of false alarms is alpha.
TEST(CompareEpochs, FalseAlarmsAreAsRareAsAlpha) {
  constexpr int kPairs = 200;
  int congruent = 0, clean = 0;
  for (std::uint64_t seed = 0; seed < kPairs; ++seed) {
    const Comparison c = compare_epochs(markers(epoch(test::simulate({}, 70000 + 2 * seed).survey)),
                                        markers(epoch(test::simulate({}, 70001 + 2 * seed).survey)), {});
    congruent += c.congruent;
    clean += std::none_of(c.movements.begin(), c.movements.end(), [](const Movement& m) { return m.moved; });
  }
  // Binomial with p = 0.05: mean 10, standard deviation 3.1; bounds of 0.1 % each side are 2 and 21.
  EXPECT_GE(kPairs - congruent, 2);
  EXPECT_LE(kPairs - congruent, 21);
  // The tests of twelve single points add 12 x 0.1 % at most.
  EXPECT_LE(kPairs - clean, 25);
}

TEST(CompareEpochs, OfThreePointsTheMovedOneIsNamedOrTheDoubtIsTold) {
  const Epoch all = markers(epoch(test::simulate({}, 81).survey)),
              again = markers(epoch(test::simulate({}, 82).survey));
  std::vector<char> keep(all.ids.size(), 0);
  keep[0] = keep[3] = keep[9] = 1;
  const Epoch first = part_of(all, keep);
  Epoch second = part_of(again, keep);
  move(second, "M21", {0, 0, 0.01});
  const Comparison c = compare_epochs(first, second, {});
  EXPECT_FALSE(c.congruent);
  ASSERT_EQ(c.excluded.size(), 1u);
  EXPECT_EQ(c.excluded[0].id, "M21");
  // Moved along the line to the other two, it could as well be one of them: with two points left only their distance
  // and height difference are tested.
  second = part_of(again, keep);
  move(second, "M03", {0, 0.0, 0.01});
  move(second, "M21", {0, 0.0, 0.01});
  const Comparison shifted = compare_epochs(first, second, {});
  ASSERT_EQ(shifted.excluded.size(), 1u);
  EXPECT_EQ(shifted.excluded[0].id, "M00") << "two against one";
}

TEST(CompareEpochs, TwoPointsStayToDefineTheDatumHoweverAllMoved) {
  const Epoch first = markers(epoch(test::simulate({}, 83).survey));
  Epoch second = first;
  for (size_t i = 0; i < first.ids.size(); ++i)
    move(second, first.ids[i],
         {0.02 * static_cast<double>(i * i), 0.05 * static_cast<double>(i % 3), 0.03 * static_cast<double>(i)});
  EXPECT_EQ(compare_epochs(first, second, {}).excluded.size(), first.ids.size() - 2);
  Epoch wrong = second;
  wrong.covariance.conservativeResize(wrong.covariance.rows(), wrong.covariance.cols() - 1);
  EXPECT_THROW(compare_epochs(first, wrong, {}), std::runtime_error);
}

TEST(CompareEpochs, RefusesWhatCannotBeCompared) {
  Epoch e = markers(epoch(test::simulate({}, 41).survey)), other = e;
  for (std::string& id : other.ids) id += "x";
  EXPECT_THROW(compare_epochs(e, other, {}), std::runtime_error);
  other = e;
  other.covariance.resize(0, 0);
  EXPECT_THROW(compare_epochs(e, other, {}), std::runtime_error);
}

/// Two levellings of one loop of bench marks; `sunk` has settled in between.
Epoch levelled(std::uint64_t seed, const std::string& sunk, double by) {
  test::Normal normal(seed);
  const std::vector<std::string> ids = {"A", "B", "C", "D", "E", "F"};
  SurveyObservations s;
  for (size_t i = 0; i < ids.size(); ++i)
    for (size_t k = i + 1; k < ids.size(); ++k) {
      if ((i + 2 * k) % 5 == 0) continue;
      const auto height = [&](size_t p) { return 10.0 + static_cast<double>(p * p) - (ids[p] == sunk ? by : 0); };
      Observation o;
      o.kind = ObservationKind::height_difference;
      o.from = ids[i], o.to = ids[k], o.sigma = 3e-4;
      o.value = height(k) - height(i) + o.sigma * normal();
      s.observations.push_back(o);
    }
  AdjustOptions options;
  options.datum = DatumMode::inner;
  return epoch_of(adjust_network(s, options));
}

TEST(CompareEpochs, SettlementOfABenchMarkByLevelling) {
  const Epoch first = levelled(1, "", 0), second = levelled(2, "D", 0.004);
  ComparisonOptions options;
  options.free_motions = merged_motions(1, 1, first);
  const Comparison c = compare_epochs(first, second, options);
  EXPECT_EQ(c.rank, 5) << "six heights, a common lift";
  EXPECT_FALSE(c.congruent);
  for (const Movement& m : c.movements) {
    EXPECT_EQ(m.moved, m.id == "D") << m.id;
    EXPECT_EQ(m.rank, 1);
    EXPECT_TRUE(std::isnan(m.movement.x()));
    if (m.id == "D") {
      EXPECT_NEAR(m.movement.z(), -0.004, 4 * m.sigma.z());
    }
  }
  const Comparison still = compare_epochs(first, levelled(3, "", 0), options);
  EXPECT_TRUE(still.congruent);
  for (const Movement& m : still.movements) EXPECT_FALSE(m.moved) << m.id;
}

TEST(CompareEpochs, PlaneNetworkHasNoHeightsToCompare) {
  const auto plane = [](std::uint64_t seed) {
    auto n = test::simulate({}, seed);
    for (Point& p : n.survey.points) p.roles[2] = CoordinateRole::unused;
    std::vector<Observation> kept;
    for (size_t i = 0; i + 2 < n.survey.observations.size(); i += 3) {
      Observation distance = n.survey.observations[i + 2];
      distance.kind = ObservationKind::horizontal_distance;
      distance.value *= std::sin(n.survey.observations[i + 1].value);
      kept.push_back(n.survey.observations[i]);
      kept.push_back(distance);
    }
    n.survey.observations = kept;
    return markers(epoch(n.survey));
  };
  Epoch first = plane(41), second = plane(42);
  ComparisonOptions options;
  options.free_motions = merged_motions(3, 3, first);
  EXPECT_EQ(options.free_motions, 4);
  const Comparison c = compare_epochs(first, second, options);
  EXPECT_EQ(c.rank, 2 * 12 - 3);
  EXPECT_TRUE(c.congruent) << c.statistic << " " << c.critical;
  const auto at =
      static_cast<Eigen::Index>(std::find(second.ids.begin(), second.ids.end(), "M12") - second.ids.begin());
  second.coordinates.segment<2>(3 * at) += Eigen::Vector2d(0.02, 0.01);
  for (const Movement& m : compare_epochs(first, second, options).movements) EXPECT_EQ(m.moved, m.id == "M12") << m.id;
}

std::string moved_in(const Comparison& c) {
  std::string ids;
  for (const Movement& m : c.movements)
    if (m.moved) ids += (ids.empty() ? "" : " ") + m.id;
  return ids;
}

/// 20 ppm over some hundred metres were three points that had moved, with both sigma0 as they should be.
TEST(CompareEpochs, OneScaleOfAWholeEpochIsNoMovementOfItsPoints) {
  const Epoch first = markers(epoch(test::simulate({}, 21).survey));
  Epoch longer = markers(epoch(test::simulate({}, 22).survey));
  EXPECT_FALSE(find_epoch_mistake(first, longer, {}, compare_epochs(first, longer, {})));
  longer.coordinates *= 1.0008;  // of 12 m
  const Comparison compared = compare_epochs(first, longer, {});
  ASSERT_NE(moved_in(compared), "");
  const auto mistake = find_epoch_mistake(first, longer, {}, compared);
  ASSERT_TRUE(mistake);
  EXPECT_NE(mistake->words.find("ppm longer than those of the first, which explains the difference"), std::string::npos)
      << mistake->words;
  EXPECT_EQ(moved_in(mistake->comparison), "");
  EXPECT_FALSE(mistake->is_undone) << "movements are told as they are";
  Epoch one = markers(epoch(test::simulate({}, 22).survey));
  one.coordinates[3 * 11] += 0.02;  // a corner
  const Comparison of_one = compare_epochs(first, one, {});
  EXPECT_EQ(moved_in(of_one), first.ids[11]);
  EXPECT_FALSE(find_epoch_mistake(first, one, {}, of_one)) << "one point that moved is no scale";
}

/// Of points with 1 mm a coordinate and epoch, not correlated.
Epoch of_places(const std::vector<Eigen::Vector3d>& places) {
  Epoch e;
  const auto n = static_cast<Eigen::Index>(places.size());
  e.coordinates.resize(3 * n);
  e.covariance = 1e-6 * Eigen::MatrixXd::Identity(3 * n, 3 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    e.ids.push_back("P" + std::to_string(i));
    e.coordinates.segment<3>(3 * i) = places[static_cast<size_t>(i)];
  }
  return e;
}

/// The tip of a tower that settled by 10 mm was "another scale", and no point had moved.
TEST(CompareEpochs, OnePointOfLeverageIsNoScale) {
  const Epoch first = of_places({{0, 0, 0}, {20, 0, 0}, {20, 20, 0}, {0, 20, 0}, {10, 3, 0}, {10, 10, 60}});
  Epoch second = first;
  second.coordinates[17] -= 0.01;
  const Comparison compared = compare_epochs(first, second, {});
  EXPECT_EQ(moved_in(compared), "P5");
  EXPECT_FALSE(find_epoch_mistake(first, second, {}, compared));
}

/// Settlements of bench marks were "nan times those of the first".
TEST(CompareEpochs, HeightsAloneHaveNoScale) {
  const double nan = std::nan("");
  std::vector<Eigen::Vector3d> places;
  for (int i = 0; i < 6; ++i) places.emplace_back(nan, nan, 20 * i);
  const Epoch first = of_places(places);
  Epoch second = first;
  second.coordinates *= 1 + 2e-4;
  const Comparison compared = compare_epochs(first, second, {});
  EXPECT_NE(moved_in(compared), "");
  EXPECT_FALSE(find_epoch_mistake(first, second, {}, compared));
}

TEST(CompareEpochs, ExchangedNamesAreNoMovementOfMetres) {
  const Epoch first = markers(epoch(test::simulate({}, 21).survey));
  Epoch second = markers(epoch(test::simulate({}, 22).survey));
  std::swap(second.ids[2], second.ids[7]);
  const Comparison compared = compare_epochs(first, second, {});
  EXPECT_EQ(moved_in(compared), first.ids[2] + " " + first.ids[7]);
  const auto mistake = find_epoch_mistake(first, second, {}, compared);
  ASSERT_TRUE(mistake);
  EXPECT_EQ(mistake->words.find(first.ids[2] + " and " + first.ids[7] + " have each other's name"), 0u)
      << mistake->words;
  EXPECT_EQ(moved_in(mistake->comparison), "");
}

TEST(CompareEpochs, WhatIsLeftOutOfTheDatumHasNotMovedUnlessItsOwnTestSaysSo) {
  // Small common errors: the global test fails, the points taken out one after another do not fail one by one.
  const Epoch first = markers(epoch(test::simulate({}, 21).survey));
  Epoch second = markers(epoch(test::simulate({}, 22).survey));
  test::Normal normal(5);
  for (Eigen::Index i = 0; i < second.coordinates.size(); ++i) second.coordinates[i] += 0.001 * normal();
  const Comparison c = compare_epochs(first, second, {});
  ASSERT_FALSE(c.congruent);
  ASSERT_FALSE(c.excluded.empty());
  for (const Movement& m : c.movements) EXPECT_EQ(m.moved, m.statistic > m.critical) << m.id;
}

}  // namespace test_compare_epochs
}  // namespace plumbline::survey
