// What was keyed in as known holds, what an instrument computed does not, and the difference is said first.
#include <gtest/gtest.h>

#include <algorithm>

#include "simulated_network.hpp"
#include "survey/adjust/adjust_network.hpp"
#include "survey/files/survey_format.hpp"
#include "survey/start/merge_surveys.hpp"

namespace plumbline::survey {
namespace test_known_points {

/// Station and backsight keyed in 100 m apart, the distance between them `millimetres` as read.
std::string polar_job(const std::string& millimetres) {
  return "*110001+000000000000S100 84..10+0000000005000000 85..10+0000000001000000 86..10+0000000000100000 "
         "88..10+0000000000001500 \n"
         "*110002+000000000000B101 81..10+0000000005000000 82..10+0000000001100000 83..10+0000000000100000 \n"
         "*110003+000000000000B101 21.322+0000000000000000 22.322+0000000010000000 31..00+0000000000" +
         millimetres +
         " 87..10+0000000000001500 \n"
         "*110004+0000000000000P01 21.322+0000000005000000 22.322+0000000010000000 31..00+0000000000050000 "
         "87..10+0000000000001500 \n";
}

NetworkResult adjust(const std::string& text, const std::string& name, AdjustOptions options = {}) {
  options.profile = built_in_profile("ics50_assumed");
  return adjust_network(read_survey(text, name), options);
}

const KnownPoint& known(const NetworkResult& r, const std::string& id) {
  for (const KnownPoint& k : r.known_points)
    if (k.id == id) return k;
  throw std::runtime_error("no known point " + id);
}

TEST(KnownPoints, HoldThoughADistanceBetweenThemIsTooLong) {
  const NetworkResult r = adjust(polar_job("100040"), "p.gsi");
  EXPECT_LT((r.point("S100").position - Eigen::Vector3d(5000, 1000, 100)).norm(), 1e-3);
  EXPECT_LT((r.point("B101").position - Eigen::Vector3d(5000, 1100, 100)).norm(), 1e-3);
  EXPECT_LT((r.point("P01").position - Eigen::Vector3d(5035.355, 1035.355, 100)).norm(), 1e-3);
  EXPECT_NE(r.validity, Validity::sound);
  EXPECT_NEAR(known(r, "B101").difference.y(), 0.040, 2e-4);
  EXPECT_NEAR(known(r, "S100").difference.y(), -0.040, 2e-4) << "either of them, or the distance";
  EXPECT_FALSE(known(r, "B101").stands());
  EXPECT_TRUE(r.findings.at(0).text.starts_with("2 known points, as measured minus as known: ")) << r.findings[0].text;
  EXPECT_NE(r.findings[0].text.find("B101 E +0.0, N +40.0, H +0.7 mm"), std::string::npos) << r.findings[0].text;
  EXPECT_EQ(r.findings[0].severity, Finding::Severity::warning);
}

TEST(KnownPoints, ThatFitAreSaidToo) {
  const NetworkResult r = adjust(polar_job("100001"), "p.gsi");
  EXPECT_EQ(r.validity, Validity::sound) << r.verdict;
  EXPECT_EQ(r.findings.at(0).severity, Finding::Severity::note);
  EXPECT_TRUE(known(r, "B101").stands());
}

/// Beside a control they do not hold; somebody is to know where they say something else, or more.
TEST(KnownPoints, BesideAControlThatSaysSomethingElseAreTold) {
  AdjustOptions options;
  options.profile = built_in_profile("ics50_assumed");
  ControlPoints control;
  control.ids = {"S100", "B101"};
  control.coordinates = Eigen::VectorXd(6);
  control.coordinates << 5000, 1000, 100, 5000, 1100, 100;
  control.covariance = 1e-6 * Eigen::MatrixXd::Identity(6, 6);
  const auto says = [&](const ControlPoints& with, const char* text) {
    const NetworkResult r = adjust_network(read_survey(polar_job("100001"), "p.gsi"), options, with);
    return std::any_of(r.findings.begin(), r.findings.end(),
                       [&](const Finding& f) { return f.text.find(text) != std::string::npos; });
  };
  EXPECT_FALSE(says(control, "keyed into the survey files")) << "the same";
  ControlPoints elsewhere = control;
  elsewhere.coordinates[4] += 0.05;
  EXPECT_TRUE(says(elsewhere, "B101 (N 1100.000 m, in the control 1100.050 m); those of the control count"));
  elsewhere.coordinates[5] = kNotGiven;
  elsewhere.coordinates[4] -= 0.05;
  EXPECT_TRUE(says(elsewhere, "the survey files have B101 as known, wholly or in part, and the control does not"));
}

/// A corrected copy of a file has the same readings and another known point: the readings count once, and it is told.
/// The control has one point: the turn is open that two keyed-in ones would hold.
TEST(KnownPoints, OfWhichTheControlHasOneAreNamedWhereItHoldsTooLittle) {
  ControlPoints control;
  control.ids = {"S100"};
  control.coordinates = Eigen::Vector3d(5000, 1000, 100);
  control.covariance = 1e-6 * Eigen::Matrix3d::Identity();
  AdjustOptions options;
  options.profile = built_in_profile("ics50_assumed");
  try {
    adjust_network(read_survey(polar_job("100000"), "p.gsi"), options, control);
    FAIL() << "nothing was refused";
  } catch (const NetworkError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("rotation about the vertical through S100"), std::string::npos) << text;
    EXPECT_NE(text.find("the survey files have B101 as known"), std::string::npos) << text;
  }
}

TEST(KnownPoints, OfACopyThatSaysSomethingElseAreTold) {
  std::string other = polar_job("100001");
  other.replace(other.find("0000000001100000"), 16, "0000000001100050");
  const MergedSurvey merged = merge_surveys({read_survey(polar_job("100001"), "a.gsi"), read_survey(other, "b.gsi")});
  EXPECT_EQ(merged.survey.observations.size(), 6u);
  EXPECT_TRUE(std::any_of(merged.findings.begin(), merged.findings.end(), [](const Finding& f) {
    return f.text.find("B101 (N 1100.000 m and 1100.050 m)") != std::string::npos;
  }));
}

TEST(KnownPoints, AreIgnoredInAFreeNetworkAndHoldByTheSigmaThatIsStated) {
  AdjustOptions free;
  free.datum = DatumMode::inner;
  EXPECT_GT(std::abs(adjust(polar_job("100040"), "p.gsi", free).point("S100").position.y() - 1000), 0.01);
  AdjustOptions loose;
  loose.known_sigma = 0.02;
  const NetworkResult r = adjust(polar_job("100040"), "p.gsi", loose);
  EXPECT_NEAR(r.point("S100").position.y(), 999.98, 2e-3);
  EXPECT_EQ(r.validity, Validity::sound) << r.verdict;
}

/// The instrument's own result (input mode 4) is no control: as such it would prove itself.
TEST(KnownPoints, AreNotWhatTheInstrumentComputed) {
  std::string job = polar_job("100040");
  for (const std::string word : {"81..10", "82..10", "83..10"})
    job.replace(job.find(word), 6, word.substr(0, 4) + "40");
  const SurveyObservations survey = read_survey(job, "p.gsi");
  for (const Point& p : survey.points) EXPECT_EQ(p.known[0], p.id == "S100") << p.id;
}

/// A loop of a digital level with a misclosure of 6.1 mm: its bench mark keeps its height.
TEST(KnownPoints, ABenchMarkKeepsItsHeightAndComputedHeightsAreNoDatum) {
  const NetworkResult r = adjust(
      "410001+?......1 \n110002+0000BM01 83...6+01000000 \n110003+0000BM01 32...6+00253400 331.06+00015230 \n"
      "110004+00000TP1 32...6+00248700 332.06+00012110 \n110005+00000TP1 573..6+00004700 574..6+00502100 "
      "83..06+01003120 \n110006+00000TP1 32...6+00301200 331.06+00009875 \n110007+00000TP2 32...6+00296500 "
      "332.06+00018842 \n110008+00000TP2 573..6+00009400 574..6+01099800 83..06+00994153 \n110009+00000TP2 "
      "32...6+00184000 331.06+00014021 \n110010+0000BM01 32...6+00189500 332.06+00008113 \n110011+0000BM01 "
      "573..6+00003900 574..6+01473300 83..06+01000061 \n",
      "loop.gsi");
  EXPECT_NEAR(r.point("BM01").position.z(), 100.0, 1e-6);
  EXPECT_EQ(r.datum_points, std::vector<std::string>{"BM01"});
  EXPECT_EQ(r.degrees_of_freedom, 1);
}

/// One known point holds the place, the file's other coordinates the turn about it.
TEST(KnownPoints, ASingleOneLeavesTheTurnToTheApproximateCoordinates) {
  std::string job = polar_job("100000");
  job.erase(job.find("*110002"), job.find("*110003") - job.find("*110002"));
  const NetworkResult r = adjust(job, "p.gsi");
  EXPECT_LT((r.point("S100").position - Eigen::Vector3d(5000, 1000, 100)).norm(), 1e-6);
  EXPECT_LT((r.point("B101").position - Eigen::Vector3d(5000, 1100, 100)).norm(), 1e-3) << "the circle's zero is north";
}

/// survey: "*.csv" takes the table of control as a survey file, too: every known point counted twice.
TEST(KnownPoints, ControlThatIsASurveyFileTooCountsOnce) {
  SurveyObservations survey = read_survey(polar_job("100000"), "job.gsi");
  ControlPoints control;
  control.ids = {"S100", "B101"};
  control.coordinates.resize(6);
  control.coordinates << 5000, 1000, 100, 5000, 1100, 100;
  control.covariance = 1e-6 * Eigen::MatrixXd::Identity(6, 6);
  AdjustOptions options;
  options.profile = built_in_profile("ics50_assumed");
  const NetworkResult once = adjust_network(survey, options, control);
  for (int p = 0; p < 2; ++p) {
    CoordinateGroup g;
    const std::string& id = control.ids[static_cast<size_t>(p)];
    g.components = {{id, 0}, {id, 1}, {id, 2}};
    g.values = control.coordinates.segment<3>(3 * p);
    g.covariance = 1e-6 * Eigen::Matrix3d::Identity();
    g.is_control = true;
    survey.coordinates.push_back(g);
  }
  const NetworkResult twice = adjust_network(survey, options, control);
  EXPECT_EQ(twice.known_points.size(), once.known_points.size());
  EXPECT_DOUBLE_EQ(twice.sigma0, once.sigma0);
  EXPECT_EQ(twice.degrees_of_freedom, once.degrees_of_freedom);
  bool said = false;
  for (const Finding& f : twice.findings)
    said = said || f.text.find("have the values of the control (S100, B101)") != std::string::npos;
  EXPECT_TRUE(said);
}

AdjustOptions without_curvature() {
  AdjustOptions options;
  options.curvature = Switch::off;
  return options;
}

/// Corners of the facade: the first two held by their file, the others weighted there. The second is `wrong` in height.
test::SimulatedNetwork held_beside_weighted(double wrong) {
  auto network = test::simulate({}, 31);
  for (const size_t i : {size_t{0}, size_t{3}}) network.survey.points[i].roles.fill(CoordinateRole::fixed);
  network.survey.points[3].coordinates.z() += wrong;
  for (const size_t i : {size_t{8}, size_t{11}}) {
    const std::string& id = network.survey.points[i].id;
    CoordinateGroup g;
    g.components = {{id, 0}, {id, 1}, {id, 2}};
    g.values = network.truth[i];
    g.covariance = 1e-6 * Eigen::Matrix3d::Identity();
    g.is_control = true;
    network.survey.coordinates.push_back(g);
  }
  return network;
}

/// The held ones were compared only where no weighted one was.
TEST(KnownPoints, HeldOnesAreTestedBesideWeightedOnes) {
  const NetworkResult right = adjust_network(held_beside_weighted(0).survey, without_curvature(), {});
  EXPECT_EQ(right.known_points.size(), 4U);
  EXPECT_EQ(right.validity, Validity::sound) << right.verdict;
  const NetworkResult r = adjust_network(held_beside_weighted(0.004).survey, without_curvature(), {});
  EXPECT_EQ(r.validity, Validity::doubtful) << r.verdict;
  EXPECT_FALSE(known(r, "M03").stands());
  EXPECT_NEAR(known(r, "M03").difference.z(), -0.004, 0.0015);
}

TEST(KnownPoints, HeldOnesAreTestedAfterRemovals) {
  auto network = held_beside_weighted(0.004);
  for (Observation& o : network.survey.observations)
    if (o.set_up == 1 && o.to == "M11" && o.kind == ObservationKind::slope_distance) o.value += 0.05;
  AdjustOptions options = without_curvature();
  options.remove_blunders = true;
  const NetworkResult r = adjust_network(network.survey, options, {});
  EXPECT_EQ(std::count_if(r.rows.begin(), r.rows.end(), [](const ResultRow& row) { return row.removed; }), 1);
  EXPECT_EQ(r.validity, Validity::doubtful) << r.verdict;
  EXPECT_FALSE(known(r, "M03").stands());
}

/// The difference is where the point would lie were it not held, over what it would take off v'Pv.
TEST(KnownPoints, TheDifferenceOfAHeldOneIsThatOfTheNetworkWithoutIt) {
  auto network = held_beside_weighted(0.004);
  const NetworkResult held = adjust_network(network.survey, without_curvature(), {});
  network.survey.points[3].roles.fill(CoordinateRole::free);
  const NetworkResult freed = adjust_network(network.survey, without_curvature(), {});
  const Eigen::Vector3d d = freed.point("M03").position - network.survey.points[3].coordinates;
  EXPECT_LT((known(held, "M03").difference - d).norm(), 1e-6);
  const Eigen::Vector3d rounded = Eigen::Vector3d::Constant(2 * 0.0005 * 0.0005 / 3);
  const Eigen::Matrix3d q = freed.covariance(freed.point("M03"), freed.point("M03"));
  EXPECT_NEAR(known(held, "M03").statistic, d.dot((q + Eigen::Matrix3d(rounded.asDiagonal())).inverse() * d), 1e-2);
}

/// Above 200 known points nothing was compared.
TEST(KnownPoints, TwoHundredAndFortyHeldOnesAreTested) {
  test::SimulationSettings settings;
  settings.columns = 10, settings.rows = 24, settings.set_ups = 2;
  auto network = test::simulate(settings, 33);
  for (size_t i = 0; i < 240; ++i) network.survey.points[i].roles.fill(CoordinateRole::fixed);
  EXPECT_EQ(adjust_network(network.survey, without_curvature(), {}).validity, Validity::sound);
  network.survey.points[100].coordinates.z() += 0.008;
  const NetworkResult r = adjust_network(network.survey, without_curvature(), {});
  EXPECT_EQ(r.known_points.size(), 240U);
  EXPECT_EQ(r.known_points.front().id, network.survey.points[100].id);
  EXPECT_FALSE(r.known_points.front().stands());
  EXPECT_EQ(r.validity, Validity::doubtful) << r.verdict;
}

}  // namespace test_known_points
}  // namespace plumbline::survey
