// Mistakes of the field, one planted in each network: they are named, mended without loss where that is possible, and
// no innocent reading is taken out. How often, over hundreds of networks: benchmarks/survey.
#include <algorithm>

#include "network_words.hpp"
#include "survey/adjust/adjust_network.hpp"
#include "survey/adjust/exclusions.hpp"
#include "survey/simulate/simulate_survey.hpp"
#include "survey/start/set_up_chain.hpp"
#include "test_support.hpp"

namespace plumbline::survey {
namespace test_field_mistakes {

using Kind = SurveyMistake::Kind;

struct Field {
  SurveyLayout layout = facade_layout(40, 4, 7);
  SurveyObservations survey;
  AdjustOptions options;

  Field() {
    SimulationOptions simulation;
    simulation.profile = options.profile = built_in_profile("total_station_2arcsec");
    survey = simulate_survey(layout, simulation, 7);
    options.datum = DatumMode::inner;
    options.remove_blunders = true;
  }
  std::vector<int> wrong(const SurveyMistake& mistake) { return plant(mistake, layout, survey); }
  NetworkResult adjust() const { return adjust_network(survey, options); }
};

void expect_words(const NetworkResult& r, std::initializer_list<const char*> words) {
  const std::string text = all_words(r);
  for (const char* word : words) EXPECT_NE(text.find(word), std::string::npos) << word << " in:\n" << text;
}

std::vector<int> removed_lines(const NetworkResult& r) {
  std::vector<int> lines;
  for (const ResultRow& row : r.rows)
    if (row.removed) lines.push_back(row.source.line);
  std::sort(lines.begin(), lines.end());
  return lines;
}

SurveyMistake mistake(Kind kind, int set_up, double size, int from_sight = 0) {
  SurveyMistake m;
  m.kind = kind, m.set_up = set_up, m.size = size, m.from_sight = from_sight;
  return m;
}

TEST(FieldMistakes, NothingWrongIsSound) {
  const NetworkResult r = Field().adjust();
  EXPECT_EQ(r.validity, Validity::sound) << r.verdict;
  EXPECT_TRUE(removed_lines(r).empty());
  EXPECT_TRUE(r.parameters.empty());
}

/// Stated ten times too cautious, nothing can fail: that is said, and the readings are tested against each other.
TEST(FieldMistakes, AccuraciesThatAreFarTooCautiousHideNothing) {
  Field field;
  field.options.remove_blunders = false;
  for (Observation& o : field.survey.observations) o.sigma *= 10;
  const NetworkResult clean = field.adjust();
  EXPECT_EQ(clean.validity, Validity::sound);
  EXPECT_NE(clean.verdict.find("agree far better than their accuracies say"), std::string::npos) << clean.verdict;
  EXPECT_NE(clean.verdict.find("by a factor of about"), std::string::npos) << clean.verdict;
  // 8 mm at 15 m: one standard deviation as stated, many of what the readings show.
  for (Observation& o : field.survey.observations)
    if (o.kind == ObservationKind::slope_distance) {
      o.value += 0.012;
      break;
    }
  const NetworkResult r = field.adjust();
  EXPECT_EQ(r.validity, Validity::doubtful) << r.verdict;
  EXPECT_NE(r.verdict.find("measured by their own agreement"), std::string::npos) << r.verdict;
}

/// A pole of 1.5 m used at 1.7: a zenith angle alone, or the target's height; of several sights with one height, that.
TEST(FieldMistakes, AWrongTargetHeightIsNamedAsSuch) {
  Field one;
  one.options.remove_blunders = false;
  const auto lower = [](Observation& o, double by) {
    if (o.kind == ObservationKind::zenith_angle || o.kind == ObservationKind::slope_distance) o.target_height = -by;
  };
  const std::string target = one.survey.observations.front().to;
  for (Observation& o : one.survey.observations)
    if (o.set_up == 0 && o.to == target && o.kind == ObservationKind::zenith_angle) lower(o, 0.02);
  expect_words(one.adjust(), {"zenith angle", "or its target height noted too small by 20 mm"});
  Field pole;
  int sights = 0;
  for (Observation& o : pole.survey.observations)
    if (o.set_up == 0 && o.kind == ObservationKind::zenith_angle && sights < 8)
      lower(o, 0.02), ++sights;
    else if (o.set_up == 0 && o.kind == ObservationKind::slope_distance && sights <= 8 && o.pointing < 8)
      lower(o, 0.02);
  const NetworkResult r = pole.adjust();
  expect_words(r, {"the target height of -0.020 m noted", "looks too small by", "it was estimated with the network"});
  EXPECT_TRUE(removed_lines(r).empty());
}

TEST(FieldMistakes, AUnitIsNamedAndConverted) {
  Field field;
  field.wrong(mistake(Kind::unit, 2, 0.3048));
  const NetworkResult r = field.adjust();
  expect_words(r, {"set-up S3 are 3.2808 times", "feet", "converted"});
  EXPECT_EQ(r.validity, Validity::sound) << r.verdict;
  EXPECT_TRUE(removed_lines(r).empty());
}

TEST(FieldMistakes, WithoutMendingFeetAreNoResult) {
  Field field;
  field.wrong(mistake(Kind::unit, 2, 0.3048));
  field.options.remove_blunders = false;
  try {  // sights three times too long do not converge
    ADD_FAILURE() << field.adjust().verdict;
  } catch (const NetworkError& error) {
    EXPECT_EQ(std::string(error.what()).find("the distances of set-up S3 are 3.2808 times"), 0u) << error.what();
  }
  Field slow;  // half a metre in 15 m: it converges, and is no result either
  slow.wrong(mistake(Kind::scale, 2, 0.03));
  slow.options.remove_blunders = false;
  const NetworkResult r = slow.adjust();
  EXPECT_EQ(r.validity, Validity::invalid);
  EXPECT_EQ(r.verdict.find("not a result"), 0u) << r.verdict;
  EXPECT_GT(r.sigma0, 10);
  EXPECT_NEAR(r.variance_factor / (r.sigma0 * r.sigma0), 1, 1e-9);
}

TEST(FieldMistakes, SwappedNamesAreNamedAndLeftOut) {
  Field field;
  SurveyMistake m = mistake(Kind::swapped_names, 1, 0);
  const auto& sees = field.layout.set_ups[1].sees;
  m.first = sees[3], m.second = sees[4];
  std::vector<int> wrong = field.wrong(m);
  for (int& i : wrong) ++i;
  std::sort(wrong.begin(), wrong.end());
  const NetworkResult r = field.adjust();
  expect_words(r, {"set-up S2", "have each other's name"});
  EXPECT_EQ(removed_lines(r), wrong);
  EXPECT_EQ(r.validity, Validity::sound) << r.verdict;
}

TEST(FieldMistakes, ATurnedCircleGetsAnOrientationOfItsOwn) {
  for (const double turn : {0.5, 0.001}) {  // far beyond all noise, and hardly more than it
    Field field;
    field.wrong(mistake(Kind::turned_circle, 0, turn, 20));
    const NetworkResult r = field.adjust();
    expect_words(r, {"S1", "turned"});
    EXPECT_EQ(r.validity, Validity::sound) << r.verdict << all_words(r);
    EXPECT_TRUE(removed_lines(r).empty());
    ASSERT_EQ(r.set_ups.size(), 5u);
    const double step = std::remainder(r.set_ups[4].orientation - r.set_ups[0].orientation, 2 * 3.14159265358979);
    EXPECT_NEAR(step, -turn, 5e-5) << "readings too large by the turn: the zero lies behind by it";
  }
}

TEST(FieldMistakes, APrismConstantIsEstimatedAndTakenOff) {
  Field field;
  field.wrong(mistake(Kind::prism, 3, 0.0344));
  const NetworkResult r = field.adjust();
  expect_words(r,
               {"distances of set-up S4 look too long by 33.9 mm", "34.4 mm lie between a round prism", "taken off"});
  EXPECT_EQ(r.validity, Validity::sound) << r.verdict;
  EXPECT_TRUE(removed_lines(r).empty());
  ASSERT_EQ(r.parameters.size(), 1u);
  EXPECT_NEAR(r.parameters[0].value, 0.0344, 5 * r.parameters[0].sigma);
  EXPECT_NEAR(r.set_ups[3].constant.value, 0.0344, 5 * r.set_ups[3].constant.sigma);
}

TEST(FieldMistakes, AnInstrumentHeightIsEstimated) {
  for (const int set_up : {0, 1}) {
    Field field;
    field.wrong(mistake(Kind::instrument_height, set_up, 0.1));
    const NetworkResult r = field.adjust();
    expect_words(r, {set_up == 0 ? "instrument height of set-up S1" : "instrument height of set-up S2"});
    EXPECT_EQ(r.validity, Validity::sound) << r.verdict;
    EXPECT_TRUE(removed_lines(r).empty());
    EXPECT_NEAR(r.set_ups[set_up].instrument_height_correction, -0.1, 0.003);
  }
}

TEST(FieldMistakes, AMovedInstrumentBecomesAnotherSetUp) {
  Field field;
  field.wrong(mistake(Kind::moved_instrument, 2, 0.15, 20));
  const NetworkResult r = field.adjust();
  expect_words(r, {"set-up S3: the instrument stood elsewhere", "150 mm in plan"});
  EXPECT_EQ(r.validity, Validity::sound) << r.verdict;
  EXPECT_TRUE(removed_lines(r).empty());
}

TEST(FieldMistakes, AScaleIsNotFoundInAFreeNetwork) {
  Field field;
  for (int s = 0; s < 4; ++s) field.wrong(mistake(Kind::scale, s, 2e-4));
  const NetworkResult r = field.adjust();
  EXPECT_EQ(all_words(r).find("ppm"), std::string::npos) << all_words(r);
  EXPECT_EQ(r.validity, Validity::sound) << "all set-ups alike: nothing in a free network can tell";
}

TEST(FieldMistakes, WhatNoMistakeExplainsIsNotClaimed) {
  Field field;  // half a metre is no prism constant
  field.wrong(mistake(Kind::prism, 3, 0.5));
  EXPECT_EQ(all_words(field.adjust()).find("check the prism constant"), std::string::npos);
}

TEST(FieldMistakes, GrossReadingsAreRemovedAndNothingElse) {
  Field field;
  std::vector<int> wrong;
  for (const auto& [observation, size] : {std::pair{20, 0.4}, {137, 3.0}, {300, -0.02}}) {
    SurveyMistake m = mistake(Kind::reading, 0, size);
    m.observation = observation;
    field.wrong(m);
    wrong.push_back(observation + 1);
  }
  const NetworkResult r = field.adjust();
  EXPECT_EQ(removed_lines(r), wrong);
  EXPECT_EQ(r.validity, Validity::sound) << r.verdict;
}

TEST(FieldMistakes, TheEstimatedBlunderHasItsSign) {
  for (const double size : {0.03, -0.03}) {
    Field field;
    SurveyMistake m = mistake(Kind::reading, 0, size);
    m.observation = 20;
    field.wrong(m);
    for (const bool remove : {false, true}) {
      field.options.remove_blunders = remove;
      const NetworkResult r = field.adjust();
      const auto row =
          std::find_if(r.rows.begin(), r.rows.end(), [](const ResultRow& o) { return o.source.line == 21; });
      EXPECT_NEAR(row->statistics.estimated_blunder, size, 0.005) << remove;
      // A reading too long has a residual (adjusted minus observed) that is negative.
      EXPECT_LT(row->statistics.w * size, 0);
    }
  }
}

TEST(Undetermined, APointSightedWithoutDistanceIsLeftOutAndNamed) {
  Field field;
  Observation o = field.survey.observations[0];
  o.to = "X1";
  o.pointing = 9999;
  field.survey.observations.push_back(o);  // a direction from one set-up
  const NetworkResult r = field.adjust();
  EXPECT_EQ(r.left_out, std::vector<std::string>{"X1"});
  expect_words(r, {"left out, the rest is adjusted: X1"});
  EXPECT_EQ(r.validity, Validity::sound) << r.verdict;
  EXPECT_NE(r.verdict.find("1 point left out as not determined"), std::string::npos) << r.verdict;
  EXPECT_EQ(r.points.size(), 44u);
}

TEST(Exclusions, PointsSetUpsAndLinesWithTheirReason) {
  Field field;
  field.options.exclude = {parse_exclusion("point M1: knocked over"), parse_exclusion("set-up S4: on a moving slab"),
                           parse_exclusion("line 21: read twice")};
  const NetworkResult r = field.adjust();
  expect_words(r, {"excluded: point M1 (", "knocked over", "excluded: set-up S4 (", "on a moving slab",
                   "excluded: line 21 (1 reading): read twice"});
  for (const ResultRow& row : r.rows) {
    EXPECT_NE(row.to, "M1");
    EXPECT_NE(row.set_up, "S4");
    EXPECT_NE(row.source.line, 21);
  }
  field.options.exclude = {parse_exclusion("point Q: is not there")};
  EXPECT_THROW(field.adjust(), NetworkError);
  EXPECT_THROW(parse_exclusion("M1"), std::invalid_argument);
  EXPECT_THROW(parse_exclusion("point M1"), std::invalid_argument);
  EXPECT_THROW(parse_exclusion("point M1:  "), std::invalid_argument);
}

/// Each face and set is a reading, whatever mean it went into; what was excluded, and what tests took out, is none.
TEST(Exclusions, ReadingsThatTakePartAreCounted) {
  Field field;
  const auto all = static_cast<int>(field.survey.observations.size());
  EXPECT_EQ(field.adjust().readings, all);
  std::vector<Finding> said;
  field.options.exclude = {parse_exclusion("point M1: knocked over"), parse_exclusion("line 21: read twice")};
  const auto rest = without_excluded(field.survey, field.options.exclude, {}, said).observations.size();
  EXPECT_EQ(field.adjust().readings, static_cast<int>(rest));
  Field mistaken;
  mistaken.options.remove_blunders = true;
  for (Observation& o : mistaken.survey.observations)
    if (o.kind == ObservationKind::slope_distance && o.to == "M1") {
      o.value += 0.1;
      break;
    }
  EXPECT_EQ(mistaken.adjust().readings, all - 1);
}

TEST(Exclusions, CoordinatesVectorsAndLocalCoordinatesGoWithTheirPointAndSetUp) {
  SurveyObservations s = Field().survey;
  CoordinateGroup given;
  given.components = {{"M1", 0}, {"M2", 0}, {"M2", 2}};
  given.values = Eigen::Vector3d(1, 2, 3);
  given.covariance = Eigen::Vector3d(1, 4, 9).asDiagonal();
  s.coordinates.push_back(given);
  VectorGroup vectors;
  vectors.vectors = {{"M1", "M3"}, {"M3", "M4"}, {"M4", "M1"}};
  vectors.values = Eigen::VectorXd::LinSpaced(9, 1, 9);
  vectors.covariance = Eigen::MatrixXd::Identity(9, 9);
  s.vectors.push_back(vectors);
  for (const int set_up : {0, 1}) {
    LocalCoordinate local;
    local.set_up = set_up;
    local.point = "M5";
    s.local_coordinates.push_back(local);
  }
  std::vector<Finding> said;
  const SurveyObservations rest =
      without_excluded(s, {parse_exclusion("point M1: loose"), parse_exclusion("set-up S1: moved")}, {}, said);
  ASSERT_EQ(rest.coordinates.size(), 1u);
  EXPECT_EQ(rest.coordinates[0].values, Eigen::Vector2d(2, 3));
  EXPECT_EQ(rest.coordinates[0].covariance(1, 1), 9);
  ASSERT_EQ(rest.vectors.size(), 1u);
  EXPECT_EQ(rest.vectors[0].values, Eigen::Vector3d(4, 5, 6));
  ASSERT_EQ(rest.local_coordinates.size(), 1u);
  EXPECT_EQ(rest.local_coordinates[0].set_up, 1);
  EXPECT_EQ(said.size(), 2u);
}

TEST(Exclusions, TheRestOfACovarianceStaysWithItsReadings) {
  SurveyObservations s = Field().survey;
  for (size_t i = 0; i < 9; ++i) s.observations[i].source = {"job.gsi", static_cast<int>(i) + 1, 0};
  s.covariances.push_back({{0, 3, 7}, Eigen::Vector3d(1, 4, 9).asDiagonal()});
  s.covariances.push_back({{3}, Eigen::MatrixXd::Identity(1, 1)});
  std::vector<Finding> said;
  const SurveyObservations rest = without_excluded(s, {parse_exclusion("line job.gsi:4: read twice")}, {}, said);
  ASSERT_EQ(rest.observations.size() + 1, s.observations.size());
  ASSERT_EQ(rest.covariances.size(), 1u) << "nothing is left of the second";
  EXPECT_EQ(rest.covariances[0].indices, (std::vector<int>{0, 6}));
  EXPECT_EQ(rest.covariances[0].covariance.diagonal(), Eigen::Vector2d(1, 9));
  SurveyObservations angles;
  for (const char* second : {"M1", "M2"}) {
    Observation o;
    o.kind = ObservationKind::angle, o.from = "S1", o.to = "M3", o.second_to = second;
    angles.observations.push_back(o);
  }
  EXPECT_EQ(without_points(angles, {"M1"}).observations.size(), 1u) << "an angle has two arms";
  ASSERT_EQ(said.size(), 1u);
  EXPECT_EQ(said[0].text, "excluded: line job.gsi:4 (1 reading): read twice");
}

TEST(SetUpChain, OneGrossSightInFiveDoesNotTurnTheFigure) {
  std::vector<LocalSight> sights(5);
  std::vector<FigurePair> pairs;
  const double turn = 0.8;
  for (size_t i = 0; i < sights.size(); ++i) {
    sights[i].ray = {3.0 * static_cast<double>(i), 10.0 + static_cast<double>(i * i), 1};
    const Eigen::Vector3d& p = sights[i].ray;
    Eigen::Vector3d target(p.x() * std::cos(turn) + p.y() * std::sin(turn) + 100,
                           -p.x() * std::sin(turn) + p.y() * std::cos(turn) + 200, 51);
    if (i == 2) target.x() += 4;
    pairs.push_back({&sights[i], target, 0.01});
  }
  const auto fit = fit_robustly(pairs, 1);
  ASSERT_TRUE(fit);
  EXPECT_EQ(fit->agree, 4);
  EXPECT_NEAR(fit->rotation, turn, 1e-9);
  EXPECT_NEAR((fit->shift - Eigen::Vector3d(100, 200, 50)).norm(), 0, 1e-9);
}

TEST(FieldMistakes, AReadingThatDoesNotExistIsRefused) {
  Field site;
  SurveyMistake m;
  m.kind = SurveyMistake::Kind::reading, m.set_up = 0, m.size = 0.02;
  for (const int none : {-1, static_cast<int>(site.survey.observations.size())}) {
    m.observation = none;
    EXPECT_THROW(site.wrong(m), std::invalid_argument) << none;
  }
}

}  // namespace test_field_mistakes
}  // namespace plumbline::survey
