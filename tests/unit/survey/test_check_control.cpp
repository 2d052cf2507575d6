// Control points with one wrong coordinate, and without.
#include "simulated_network.hpp"
#include "survey/adjust/adjust_network.hpp"
#include "survey/adjust/left_out_control.hpp"
#include "survey/epochs/check_control.hpp"
#include "survey/files/gama.hpp"
#include "test_support.hpp"

namespace plumbline::survey {
namespace test_check_control {

/// Four corners of the facade, known to 0.5 mm, with errors of that size.
ControlPoints corners(const test::SimulatedNetwork& network, std::uint64_t seed) {
  ControlPoints control;
  test::Normal normal(seed);
  control.coordinates.resize(12);
  int k = 0;
  for (size_t i : {size_t{0}, size_t{3}, size_t{8}, size_t{11}}) {
    control.ids.push_back(network.survey.points[i].id);
    for (int c = 0; c < 3; ++c) control.coordinates[k++] = network.truth[i][c] + 0.0005 * normal();
  }
  control.covariance = Eigen::MatrixXd::Identity(12, 12) * 0.0005 * 0.0005;
  return control;
}

const double kKnownSigma = AdjustOptions().known_sigma;

AdjustOptions without_curvature() {
  AdjustOptions options;
  options.curvature = Switch::off;
  return options;
}

TEST(CheckControl, SoundControlPasses) {
  int refused = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const auto network = test::simulate({}, 300 + seed);
    const ControlCheck c = check_control(network.survey, corners(network, 900 + seed), without_curvature(), {});
    ASSERT_EQ(c.problem, "");
    EXPECT_EQ(c.comparison.rank, 12 - 4);
    refused += !c.comparison.congruent;
  }
  EXPECT_LE(refused, 13);  // binomial, p = 0.05: 0.1 % above
}

TEST(CheckControl, TheWrongPointIsNamedAndNotTheObservations) {
  const auto network = test::simulate({}, 17);
  ControlPoints control = corners(network, 18);
  control.coordinates[3 * 2 + 2] += 0.008;  // height of the third
  const ControlCheck c = check_control(network.survey, control, without_curvature(), {});
  EXPECT_FALSE(c.comparison.congruent);
  ASSERT_EQ(c.comparison.excluded.size(), 1u);
  EXPECT_EQ(c.comparison.excluded[0].id, control.ids[2]);
  for (const Movement& m : c.comparison.movements) {
    EXPECT_EQ(m.moved, m.id == control.ids[2]) << m.id;
    if (m.moved) {
      EXPECT_NEAR(m.movement.z(), -0.008, 4 * m.sigma.z()) << "measured minus given";
    }
  }
}

TEST(CheckControl, ControlWithoutCovarianceCountsAsWithoutError) {
  const auto network = test::simulate({}, 19);
  ControlPoints control = corners(network, 20);
  for (int i = 0; i < 4; ++i)
    control.coordinates.segment<3>(3 * i) = network.truth[std::array<size_t, 4>{0, 3, 8, 11}[i]];
  control.covariance.resize(0, 0);
  EXPECT_TRUE(check_control(network.survey, control, without_curvature(), {}).comparison.congruent);
  control.coordinates[0] += 0.01;
  const ControlCheck c = check_control(network.survey, control, without_curvature(), {});
  ASSERT_FALSE(c.comparison.excluded.empty());
  EXPECT_EQ(c.comparison.excluded[0].id, control.ids[0]);
}

TEST(CheckControl, SaysWhyNothingCanBeTested) {
  const auto network = test::simulate({}, 21);
  EXPECT_NE(check_control(network.survey, {}, without_curvature(), {}).problem.find("no control points"),
            std::string::npos);
  ControlPoints control = corners(network, 22);
  control.ids = {"A", "B", "M22", "M23"};
  EXPECT_NE(check_control(network.survey, control, without_curvature(), {}).problem.find("2 of them are observed"),
            std::string::npos);
  SurveyObservations none = network.survey;
  none.observations[0].set_up = 99;
  EXPECT_NE(check_control(none, corners(network, 23), without_curvature(), {})
                .problem.find("free network is not determined: "),
            std::string::npos);
  SurveyObservations one = network.survey;
  std::erase_if(one.observations, [](const Observation& o) { return o.kind == ObservationKind::slope_distance; });
  EXPECT_NO_THROW(check_control(one, corners(network, 23), without_curvature(), {}));
}

/// Which points enter the search for the cause, and how exactly they must fit it.
TEST(CheckControl, TheCauseIsLookedForWithWhatIsComplete) {
  const auto network = test::simulate({}, 24);
  const auto cause = [&](double scale, bool exchanged, int without_east) {
    ControlPoints control;  // two markers and two stations: the facade alone is a line, which fits either way round
    control.coordinates.resize(12);
    for (const size_t i : {size_t{0}, size_t{3}, size_t{12}, size_t{13}}) {
      control.coordinates.segment<3>(static_cast<Eigen::Index>(3 * control.ids.size())) = network.truth[i];
      control.ids.push_back(network.survey.points[i].id);
    }
    control.covariance = 1e-4 * Eigen::MatrixXd::Identity(12, 12);
    control.coordinates *= scale;
    for (Eigen::Index i = 0; i < 4 && exchanged; ++i)
      std::swap(control.coordinates[3 * i], control.coordinates[3 * i + 1]);
    for (Eigen::Index i = 0; i < without_east; ++i) control.coordinates[3 * i] = kNotGiven;
    return check_control(network.survey, control, without_curvature(), {}).cause;
  };
  EXPECT_NE(cause(3.28084, false, 0).find("in feet"), std::string::npos);
  EXPECT_NE(cause(3.28084, false, 1).find("in feet"), std::string::npos) << "three points are left that have both";
  EXPECT_EQ(cause(3.28084, false, 2), "") << "two points fit any scale";
  EXPECT_NE(cause(1, true, 0).find("exchanged"), std::string::npos);
  EXPECT_EQ(cause(1.5, true, 0), "") << "exchanged and of another size is no known mistake";
}

TEST(CheckControl, APointThatIsGivenTwiceCountsOnceAsControl) {
  auto network = test::simulate({}, 26);
  const ControlPoints control = corners(network, 27);
  for (Point& p : network.survey.points)
    if (p.id == control.ids[1]) p.roles.fill(CoordinateRole::fixed);
  const ControlCheck c = check_control(network.survey, control, without_curvature(), {});
  EXPECT_EQ(c.problem, "");
  EXPECT_EQ(c.comparison.movements.size(), 4u);
}

/// The same comparison, from an adjustment on the control and from a free network of its own.
void expect_same(const SurveyObservations& survey, const ControlPoints& control, AdjustOptions options,
                 const std::string& what) {
  SCOPED_TRACE(what);
  const ControlCheck alone = check_control(survey, control, options, {});
  options.measure_control = true;
  const NetworkResult r = adjust_network(survey, options, control);
  ASSERT_GE(r.measured_control.ids.size(), 3u);
  const ControlCheck shared = check_control(survey, control, options, {}, r.measured_control);
  ASSERT_EQ(alone.problem, "");
  ASSERT_EQ(shared.problem, "");
  EXPECT_EQ(shared.free_motions, alone.free_motions);
  EXPECT_EQ(shared.comparison.rank, alone.comparison.rank);
  // Coordinates are those of the minimum; the covariance is that of where the network lies, by what its points moved
  // over the length of its sights.
  EXPECT_NEAR(shared.comparison.statistic, alone.comparison.statistic, 1e-3 * alone.comparison.statistic);
  ASSERT_EQ(shared.comparison.movements.size(), alone.comparison.movements.size());
  ASSERT_EQ(shared.comparison.excluded.size(), alone.comparison.excluded.size());
  for (size_t k = 0; k < alone.comparison.excluded.size(); ++k)
    EXPECT_EQ(shared.comparison.excluded[k].id, alone.comparison.excluded[k].id);
  for (size_t k = 0; k < alone.comparison.movements.size(); ++k) {
    const Movement &a = alone.comparison.movements[k], &b = shared.comparison.movements[k];
    EXPECT_EQ(b.id, a.id);
    EXPECT_LT((b.movement - a.movement).norm(), 1e-9) << a.id;
    EXPECT_LT((b.sigma - a.sigma).norm(), 1e-3 * a.sigma.norm()) << a.id;
    EXPECT_EQ(b.moved, a.moved) << a.id;
  }
}

TEST(CheckControl, FromTheNetworkOnControlItIsThatOfAFreeNetwork) {
  const auto network = test::simulate({}, 17);
  ControlPoints control = corners(network, 18);
  expect_same(network.survey, control, without_curvature(), "weighted");
  ControlPoints wrong = control;
  wrong.coordinates[3 * 2 + 2] += 0.008;
  expect_same(network.survey, wrong, without_curvature(), "one is wrong");
  wrong.covariance.resize(0, 0);
  expect_same(network.survey, wrong, without_curvature(), "held");
  SurveyObservations keyed = network.survey;
  for (const size_t i : {size_t{0}, size_t{3}, size_t{8}, size_t{11}}) keyed.points[i].known.fill(true);
  keyed.points[3].coordinates.x() += 0.004;
  expect_same(keyed, {}, without_curvature(), "keyed in");
  SurveyObservations fixed = network.survey;
  for (const size_t i : {size_t{0}, size_t{3}, size_t{8}, size_t{11}})
    fixed.points[i].roles.fill(CoordinateRole::fixed);
  expect_same(fixed, {}, without_curvature(), "fixed");
}

NetworkResult on_control(const SurveyObservations& survey, const ControlPoints& control,
                         const std::vector<ExcludedItem>& exclude = {}) {
  AdjustOptions options = without_curvature();
  options.measure_control = true, options.exclude = exclude;
  return adjust_network(survey, options, control);
}

bool stand(const std::vector<KnownPoint>& known) {
  return std::all_of(known.begin(), known.end(), [](const KnownPoint& k) { return k.stands(); });
}

/// Stated: one network in a hundred, over all its known points together.
TEST(CheckControl, SoundControlIsDoubtedInOneNetworkInAHundredAtMost) {
  int doubted = 0, of_held = 0, of_noisy = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    auto network = test::simulate({}, 1300 + seed);
    ControlPoints control = corners(network, 2900 + seed), held = control;
    doubted += !stand(on_control(network.survey, control).known_points);
    for (int i = 0; i < 4; ++i)
      held.coordinates.segment<3>(3 * i) = network.truth[std::array<size_t, 4>{0, 3, 8, 11}[i]];
    held.covariance.resize(0, 0);
    of_held += !stand(on_control(network.survey, held).known_points);
    if (seed >= 50) continue;
    for (Observation& o : network.survey.observations) o.sigma /= 2;  // the readings are worse than stated
    of_noisy += !stand(on_control(network.survey, control).known_points);
  }
  EXPECT_LE(doubted, 7) << "binomial, p = 0.01: 0.1 % above";
  EXPECT_LE(of_held, 7);
  EXPECT_LE(of_noisy, 4);
}

/// What was left out is held against what came of it: sound points that were left out by mistake speak against it.
TEST(CheckControl, KnownPointsThatAreLeftOutAreHeldAgainstTheResult) {
  const auto network = test::simulate({}, 17);
  const ControlPoints control = corners(network, 18);
  AdjustOptions options = without_curvature();
  options.exclude = {parse_exclusion("control " + control.ids[2] + ": hit")};
  const auto held = [&](const ControlPoints& known) {
    const auto left_out =
        compare_with_left_out(network.survey, known, options, adjust_network(network.survey, options, known));
    EXPECT_EQ(left_out.size(), 1u);
    return left_out.at(0);
  };
  EXPECT_EQ(held(control).rank, 3);
  EXPECT_TRUE(held(control).stands()) << held(control).statistic;
  ControlPoints wrong = control;
  wrong.coordinates[3 * 2 + 2] += 0.02;
  EXPECT_FALSE(held(wrong).stands());
  EXPECT_NEAR(held(wrong).difference.z(), -0.02, 0.003);
  wrong.covariance.resize(0, 0);
  EXPECT_FALSE(held(wrong).stands()) << "without standard deviations, too";
}

/// Once one was named with w = 19 beside a global test of 120 readings that passed, and nothing followed.
TEST(CheckControl, OneThatIsWrongMakesANetworkDoubtfulThoughItsReadingsAgree) {
  const auto network = test::simulate({}, 17);
  ControlPoints control = corners(network, 18);
  EXPECT_EQ(on_control(network.survey, control).validity, Validity::sound);
  ControlPoints wrong = control;
  wrong.coordinates[3 * 2 + 2] += 0.004;
  const NetworkResult r = on_control(network.survey, wrong);
  EXPECT_EQ(r.validity, Validity::doubtful);
  EXPECT_EQ(r.verdict.find("doubtful: "), 0U) << r.verdict;
  EXPECT_FALSE(stand(r.known_points));
  const NetworkResult mended =
      on_control(network.survey, wrong, {parse_exclusion("control " + control.ids[2] + ": hit")});
  EXPECT_EQ(mended.validity, Validity::sound) << mended.verdict;
  EXPECT_EQ(mended.known_points.size(), 3u);
  EXPECT_NO_THROW(mended.point(control.ids[2])) << "its readings stay";
  EXPECT_NEAR(mended.point(control.ids[2]).position.z(), network.truth[8].z(), 0.002);
  EXPECT_EQ(mended.measured_control.ids.size(), 3u);
  EXPECT_THROW(on_control(network.survey, wrong, {parse_exclusion("control S99: hit")}), NetworkError);
  wrong.covariance.resize(0, 0);
  const auto held = on_control(network.survey, wrong).known_points;
  ASSERT_EQ(held.size(), 4u);
  EXPECT_EQ(held.front().id, control.ids[2]);
  EXPECT_FALSE(held.front().stands());
}

/// No point by itself, all of them a little: the check said so, and the verdict said "Sound".
TEST(CheckControl, OneThatFailsAsAWholeTakesSoundAway) {
  const auto network = test::simulate({}, 17);
  ControlPoints control = corners(network, 18);
  EXPECT_FALSE(doubt_failed_control(network.survey, control, kKnownSigma,
                                    *std::make_unique<NetworkResult>(on_control(network.survey, control))));
  bool found = false;
  for (double size = 0.0004; !found && size < 0.004; size += 0.0001) {
    ControlPoints bent = control;
    for (int i = 0; i < 4; ++i) bent.coordinates[3 * i + 2] += (i % 2 == 0) == (i < 2) ? size : -size;
    NetworkResult r = on_control(network.survey, bent);
    if (r.validity != Validity::sound) continue;
    if (!(found = doubt_failed_control(network.survey, bent, kKnownSigma, r))) continue;
    EXPECT_EQ(r.validity, Validity::doubtful);
    EXPECT_EQ(r.verdict.find("doubtful: the control does not fit the readings; of the readings: sound"), 0U)
        << r.verdict;
    EXPECT_EQ(r.findings.back().subject, Finding::Subject::control);
  }
  EXPECT_TRUE(found);
}

/// A wrong reading that was taken out contradicts no control, and is not compared with it any more.
TEST(CheckControl, AfterRemovalsItIsThatOfTheReadingsThatStay) {
  auto network = test::simulate({}, 17);
  const ControlPoints control = corners(network, 18);
  for (Observation& o : network.survey.observations)
    if (o.set_up == 1 && o.to == control.ids[1] && o.kind == ObservationKind::slope_distance) o.value += 0.05;
  AdjustOptions options = without_curvature();
  options.measure_control = true;
  const NetworkResult with = adjust_network(network.survey, options, control);
  options.remove_blunders = true;
  NetworkResult without = adjust_network(network.survey, options, control);
  ASSERT_EQ(without.snooping.size(), 1U);
  ASSERT_EQ(without.measured_control.ids.size(), 4U);
  EXPECT_LT(without.measured_control.sum_of_squares, with.measured_control.sum_of_squares - 100);
  EXPECT_FALSE(doubt_failed_control(network.survey, control, kKnownSigma, without));
  EXPECT_EQ(without.validity, Validity::sound) << without.verdict;
}

/// Keyed in to half a centimetre, as the user states: as a whole they were held to a third of a millimetre.
TEST(CheckControl, WhatWasKeyedInIsAsGoodAsIsStated) {
  auto network = test::simulate({}, 17);
  test::Normal normal(5);
  for (const size_t i : {size_t{0}, size_t{3}, size_t{8}, size_t{11}}) {
    network.survey.points[i].known.fill(true);
    network.survey.points[i].coordinates = network.truth[i];
    for (int c = 0; c < 3; ++c)
      network.survey.points[i].coordinates[c] = std::round(1e3 * (network.truth[i][c] + 0.004 * normal())) / 1e3;
  }
  AdjustOptions options = without_curvature();
  options.measure_control = true, options.known_sigma = 0.005;
  NetworkResult r = adjust_network(network.survey, options, {});
  EXPECT_FALSE(doubt_failed_control(network.survey, {}, 0.005, r)) << r.verdict;
  EXPECT_TRUE(doubt_failed_control(network.survey, {}, kKnownSigma, r)) << "the test would see them";
}

/// The variance is estimated of few readings: against chi-squared one sound network in eight was doubted.
TEST(CheckControl, FewReadingsThatTellTheirOwnVarianceDoubtNoSoundControl) {
  int doubted = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const auto network = test::simulate({}, 5000 + seed);
    const ControlPoints control = corners(network, 6000 + seed);
    AdjustOptions options = without_curvature();
    options.measure_control = true, options.scale_with_sigma0 = Switch::on;
    NetworkResult r = adjust_network(network.survey, options, control);
    doubted += doubt_failed_control(network.survey, control, kKnownSigma, r);
  }
  EXPECT_LE(doubted, 1);
}

/// What a file itself has as known is left out likewise.
TEST(CheckControl, WhatTheFilesKnowIsLeftOutAsControlToo) {
  auto network = test::simulate({}, 17);
  for (const size_t i : {size_t{0}, size_t{3}, size_t{8}, size_t{11}}) network.survey.points[i].known.fill(true);
  const NetworkResult r =
      on_control(network.survey, {}, {parse_exclusion("control " + network.survey.points[3].id + ": keyed in twice")});
  EXPECT_EQ(r.known_points.size(), 3u);
}

/// Two parts that share nothing but control are no free network: what the network with control has is not compared.
TEST(CheckControl, PartsThatShareOnlyControlAreNotCompared) {
  const auto network = test::simulate({}, 17);
  const ControlPoints control = corners(network, 18);
  SurveyObservations apart = network.survey;
  std::erase_if(apart.observations, [](const Observation& o) {
    return !(o.from == "S1" ? o.to == "M00" || o.to == "M03" : o.to == "M20" || o.to == "M23");
  });
  AdjustOptions options = without_curvature();
  options.measure_control = true;
  EXPECT_TRUE(adjust_network(apart, options, control).measured_control.ids.empty());
}

TEST(CheckControl, PointsThatAFileHoldsFixedAreControl) {
  PLUMBLINE_REQUIRE_DATA("survey/gama/2020-barta-phase_1-2TK.gkf");
  SurveyObservations survey = read_gama_xml(
      plumbline::test::read_file(plumbline::test::data_file("survey/gama/2020-barta-phase_1-2TK.gkf")), "barta.gkf");
  const ControlCheck c = check_control(survey, {}, {}, {});
  ASSERT_EQ(c.problem, "");
  EXPECT_EQ(c.comparison.movements.size(), 8u);
  EXPECT_EQ(c.comparison.rank, 8 * 3 - 4);
  expect_same(survey, {}, {}, "barta");
  for (Point& p : survey.points)
    if (p.id == "103") p.coordinates.z() += 0.01;
  const ControlCheck wrong = check_control(survey, {}, {}, {});
  EXPECT_TRUE(std::any_of(wrong.comparison.excluded.begin(), wrong.comparison.excluded.end(),
                          [](const Exclusion& e) { return e.id == "103"; }));
}

}  // namespace test_check_control
}  // namespace plumbline::survey
