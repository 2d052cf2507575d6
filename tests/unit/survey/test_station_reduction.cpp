// From readings to what is adjusted: faces, sets, a turned circle, instrument errors, and the reading that is wrong.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "survey/model/circle_steps.hpp"
#include "survey/model/observation_equations.hpp"
#include "survey/model/reading_tests.hpp"
#include "survey/model/station_reduction.hpp"

namespace plumbline::survey {
namespace test_station_reduction {

constexpr double kPi = std::numbers::pi, kMgon = kPi / 200e3;

/// One set-up whose instrument has a collimation and an index error, without noise unless a test adds some.
class Readings {
 public:
  Readings() {
    survey_.files = {"job.gsi"};
    survey_.set_ups.push_back({"S", "S", 1.5, {}});
  }

  double direction(int target) const { return wrap_to_turn(0.5 * target + 0.1); }
  double zenith(int target) const { return kPi / 2 - 0.1 * (target - 3); }

  /// Sighting of `target`; `circle` is by how much the circle reads more than at first.
  void sight(int target, int face, int set, double circle = 0, double extra = 0) {
    const double z = zenith(target), c = collimation / std::sin(z);
    const double hz = direction(target) + circle + extra;
    add(ObservationKind::direction, target, face, set, face == 1 ? hz + c : hz + kPi - c);
    add(ObservationKind::zenith_angle, target, face, set, face == 1 ? z + index : 2 * kPi - (z - index));
    ++pointing_;
  }

  MeanResult reduce() const { return mean_observations(survey_); }
  SurveyObservations& survey() { return survey_; }

  double collimation = 0, index = 0;

 private:
  static double wrap_to_turn(double a) { return a - 2 * kPi * std::floor(a / (2 * kPi)); }

  void add(ObservationKind kind, int target, int face, int set, double value) {
    Observation o;
    o.kind = kind;
    o.set_up = 0, o.pointing = pointing_;
    o.from = "S", o.to = "T" + std::to_string(target);
    o.value = wrap_to_turn(value);
    o.face = face, o.set_number = set;
    o.source = {"job.gsi", static_cast<int>(survey_.observations.size()) + 1, 1};
    survey_.observations.push_back(o);
  }

  SurveyObservations survey_;
  int pointing_ = 0;
};

const MeanObservation& mean_of(const MeanResult& result, ObservationKind kind, int target) {
  for (const MeanObservation& m : result.observations)
    if (m.observation.kind == kind && m.observation.to == "T" + std::to_string(target)) return m;
  throw std::runtime_error("no mean of T" + std::to_string(target));
}

/// To 1e-8: the zenith angle that a collimation is reduced with has the index in it, which is worth c * i * cot z.
void expect_true_values(const Readings& readings, const MeanResult& result, std::initializer_list<int> targets) {
  for (const int t : targets) {
    EXPECT_NEAR(wrap_angle(mean_of(result, ObservationKind::direction, t).observation.value - readings.direction(t)), 0,
                1e-8)
        << "T" << t;
    EXPECT_NEAR(mean_of(result, ObservationKind::zenith_angle, t).observation.value, readings.zenith(t), 1e-8)
        << "T" << t;
  }
}

void expect_true_direction(const Readings& readings, const Observation& o) {
  if (o.kind != ObservationKind::direction) return;
  EXPECT_NEAR(wrap_angle(o.value - readings.direction(std::stoi(o.to.substr(1)))), 0, 1e-9) << o.to;
}

// Once blamed on one collimation of -143 mgon over all pairs: 9 readings went, a marker was 130 mm off and "sound".
TEST(StationReduction, ATurnOfTheCircleWithinAFaceIsFoundAndTurnedBack) {
  for (const int before : {5, 0, 2}) {  // readings of the second face before the turn; 0, 2: nothing tells it apart
    Readings readings;
    readings.collimation = 2 * kMgon;
    const double turn = 300 * kMgon;
    for (int t = 0; t < 12; ++t) readings.sight(t, 1, 1);
    for (int t = 0; t < 12; ++t) readings.sight(t, 2, 1, t < before ? 0 : turn);
    const MeanResult result = readings.reduce();
    const bool found = std::any_of(result.warnings.begin(), result.warnings.end(), [](const std::string& w) {
      return w.find("the circle of set-up S was turned by 300.0 mgon before T5 was sighted in face 2") == 0;
    });
    EXPECT_EQ(found, before == 5) << before;
    if (before != 5) continue;
    EXPECT_EQ(result.warnings.size(), 1u) << result.warnings.back();
    for (const MeanObservation& m : result.observations) expect_true_direction(readings, m.observation);
    EXPECT_NEAR(result.instrument[0].collimation, readings.collimation, 1e-9);
  }
}

TEST(StationReduction, ATurnInTheFirstFaceIsFoundToo) {
  Readings readings;
  for (int t = 0; t < 12; ++t) readings.sight(t, 1, 1, t < 6 ? 0 : 50 * kMgon);
  for (int t = 11; t >= 0; --t) readings.sight(t, 2, 1, 50 * kMgon);
  const MeanResult result = readings.reduce();
  for (const MeanObservation& m : result.observations) expect_true_direction(readings, m.observation);
}

TEST(StationReduction, BothFacesAreFreeOfCollimationAndIndexAndTellThem) {
  Readings r;
  r.collimation = 4 * kMgon, r.index = -3 * kMgon;
  for (int t = 1; t <= 5; ++t) r.sight(t, 1, 1), r.sight(t, 2, 1);
  const MeanResult result = r.reduce();
  expect_true_values(r, result, {1, 2, 3, 4, 5});
  ASSERT_EQ(result.instrument.size(), 1u);
  EXPECT_NEAR(result.instrument[0].collimation, r.collimation, 1e-9);
  EXPECT_NEAR(result.instrument[0].index, r.index, 1e-9);
  EXPECT_EQ(mean_of(result, ObservationKind::direction, 2).sets, 1);
  EXPECT_FALSE(mean_of(result, ObservationKind::direction, 2).single_face);
  EXPECT_TRUE(result.warnings.empty());
}

TEST(StationReduction, CollimationHasTheSigmaOfAMedian) {
  Readings r;
  for (int t = 1; t <= 5; ++t) {  // errors of -2, -1, 0, 1, 2 mgon in the index: the median deviation is 1 mgon
    r.index = (t - 3) * kMgon;
    r.sight(t, 1, 1), r.sight(t, 2, 1);
  }
  const MeanResult result = r.reduce();
  EXPECT_NEAR(result.instrument.at(0).index, 0, 1e-9);
  EXPECT_NEAR(result.instrument.at(0).index_sigma, 1.2533 * 1.4826 * kMgon / std::sqrt(5), 1e-9);
}

TEST(StationReduction, ReadingsInOneFaceGetTheSetUpsErrorsTakenOut) {
  Readings r;
  r.collimation = 4 * kMgon, r.index = -3 * kMgon;
  for (int t = 1; t <= 5; ++t) r.sight(t, 1, 1), r.sight(t, 2, 1);
  r.sight(6, 1, 1);
  r.sight(7, 2, 1);
  const MeanResult result = r.reduce();
  expect_true_values(r, result, {6, 7});
  EXPECT_TRUE(mean_of(result, ObservationKind::direction, 6).single_face);
  EXPECT_TRUE(mean_of(result, ObservationKind::zenith_angle, 7).single_face);
}

TEST(StationReduction, ACircleTurnedBetweenSetsIsTurnedBack) {
  for (const double turn : {0.7, -0.7, 3.5}) {
    Readings r;
    for (int t = 1; t <= 5; ++t) r.sight(t, 1, 1), r.sight(t, 2, 1);
    for (int t = 1; t <= 5; ++t) r.sight(t, 1, 2, turn), r.sight(t, 2, 2, turn);
    const MeanResult result = r.reduce();
    expect_true_values(r, result, {1, 2, 3, 4, 5});
    EXPECT_EQ(mean_of(result, ObservationKind::direction, 3).sets, 2);
    EXPECT_TRUE(result.removed.empty());
    EXPECT_TRUE(result.warnings.empty()) << result.warnings.front();
  }
}

TEST(StationReduction, SecondsBetweenSetsAreNoiseAndStayInTheMean) {
  Readings r;
  for (int t = 1; t <= 5; ++t) r.sight(t, 1, 1), r.sight(t, 2, 1);
  for (int t = 1; t <= 5; ++t) r.sight(t, 1, 2, 1 * kMgon), r.sight(t, 2, 2, 1 * kMgon);
  const MeanResult result = r.reduce();
  EXPECT_NEAR(mean_of(result, ObservationKind::direction, 2).observation.value - r.direction(2), 0.5 * kMgon, 1e-9);
  EXPECT_NEAR(mean_of(result, ObservationKind::direction, 2).spread, kMgon / std::numbers::sqrt2, 1e-9);
}

TEST(StationReduction, AWrongReadingOfManyIsLeftOutByItsLine) {
  Readings r;
  int wrong = -1;
  for (int set = 1; set <= 6; ++set)
    for (int t = 1; t <= 4; ++t) {
      if (set == 4 && t == 2) wrong = static_cast<int>(r.survey().observations.size());
      r.sight(t, 1, set, 0, set == 4 && t == 2 ? 0.004 : (set % 2 ? 1 : -1) * 0.3 * kMgon);
    }
  const MeanResult result = r.reduce();
  ASSERT_EQ(result.removed.size(), 1u);
  EXPECT_EQ(result.removed[0].observation, wrong);
  EXPECT_NEAR(result.removed[0].difference, 0.004, kMgon);
  ASSERT_FALSE(result.warnings.empty());
  EXPECT_NE(result.warnings[0].find("job.gsi:" + std::to_string(wrong + 1) + ":1"), std::string::npos)
      << result.warnings[0];
  EXPECT_EQ(mean_of(result, ObservationKind::direction, 2).sets, 5);
}

TEST(StationReduction, TwoThatContradictEachOtherAreNotAveraged) {
  Readings r;
  for (int t = 1; t <= 5; ++t) r.sight(t, 1, 1), r.sight(t, 2, 1, 0, t == 3 ? 200 * kMgon : 0);
  const MeanResult result = r.reduce();
  int of_3 = 0;
  for (const MeanObservation& m : result.observations)
    of_3 += m.observation.kind == ObservationKind::direction && m.observation.to == "T3";
  EXPECT_EQ(of_3, 2);
  ASSERT_FALSE(result.warnings.empty());
  EXPECT_NE(result.warnings[0].find("differ by 200"), std::string::npos) << result.warnings[0];
}

TEST(StationReduction, ReadingsWithTheirOwnSigmaStayAsTheyAre) {
  Readings r;
  r.sight(1, 1, 1);
  r.sight(1, 1, 2);
  for (Observation& o : r.survey().observations) o.sigma = 1e-5;
  EXPECT_EQ(r.reduce().observations.size(), 4u);
}

/// 300 targets with four distances each, normal, of 3 mm; the first reading of the first lies `off` [m] from its truth.
std::vector<ReadingGroup> distances_with_one_off(double off) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise(0, 0.003);
  std::vector<ReadingGroup> groups(300);
  for (auto& group : groups) {
    group.kind = ObservationKind::slope_distance, group.set_up = 0, group.length = 20;
    for (int k = 0; k < 4; ++k) group.readings.push_back({k, 0, noise(random)});
  }
  for (size_t k = 1; k < 4; ++k) groups[0].readings[k].value = 1e-4 * static_cast<double>(k);
  groups[0].readings[0].value = off;
  return groups;
}

// The scatter of small groups is not taken for smaller than it is: 4.3 standard deviations are no blunder among 1 200.
TEST(ReadingTests, OneIsRemovedBeyondFiveStandardDeviations) {
  const std::vector<InstrumentErrors> errors(1);
  const auto removed = [&](double off) {
    std::vector<std::pair<size_t, size_t>> result;
    const auto verdicts = test_readings(distances_with_one_off(off), errors);
    for (size_t g = 0; g < verdicts.size(); ++g)
      for (size_t k = 0; k < verdicts[g].removed.size(); ++k)
        if (verdicts[g].removed[k]) result.emplace_back(g, k);
    return result;
  };
  EXPECT_TRUE(removed(0.013).empty());
  EXPECT_EQ(removed(-0.018), (std::vector<std::pair<size_t, size_t>>{{0, 0}}));
}

/// A zenith angle that belongs to no pointing says nothing about readings that belong to none: were a steep sight taken
/// for theirs, the collimation of 5 mgon would look like a turn of the circle before them.
TEST(CircleSteps, TakeNoZenithAngleOfAnotherPointing) {
  Readings r;
  r.collimation = 5 * kMgon;
  for (const int face : {1, 2})
    for (int t = 0; t < 8; ++t) r.sight(t, face, 1);
  for (Observation& o : r.survey().observations) {
    if (o.to < "T4") continue;
    o.pointing = -1;
    if (o.kind == ObservationKind::zenith_angle) o.value = 0.1;
  }
  EXPECT_TRUE(circle_steps(r.survey()).empty());
}

/// What looks like a turned circle and is none: a turn at the change of face, where every pair is across it, readings
/// that differ each by something else, and single readings, which show nothing.
TEST(CircleSteps, AreToldOnlyWhereTheReadingsShowOne) {
  Readings at_the_change;
  for (int t = 0; t < 8; ++t) at_the_change.sight(t, 1, 1);
  for (int t = 0; t < 8; ++t) at_the_change.sight(t, 2, 1, 0.01);
  EXPECT_TRUE(circle_steps(at_the_change.survey()).empty());
  Readings scattered;
  for (int t = 0; t < 8; ++t) scattered.sight(t, 1, 1);
  for (int t = 0; t < 8; ++t) scattered.sight(t, 1, 1, 0, t < 4 ? 0 : 0.003 * (t - 3));
  EXPECT_TRUE(circle_steps(scattered.survey()).empty());
  Readings single;
  for (int t = 0; t < 8; ++t) single.sight(t, 1, 1);
  EXPECT_TRUE(circle_steps(single.survey()).empty());
  Readings turned;  // one that is
  for (int t = 0; t < 8; ++t) turned.sight(t, 1, 1);
  for (int t = 0; t < 8; ++t) turned.sight(t, 2, 1, t < 4 ? 0 : 0.01);
  const auto steps = circle_steps(turned.survey());
  ASSERT_EQ(steps.size(), 1u);
  EXPECT_NEAR(steps[0].turn, 0.01, 1e-9);
  EXPECT_EQ(turned.survey().observations[steps[0].first].to, "T4");
  EXPECT_EQ(steps[0].with, 4);
  EXPECT_EQ(steps[0].without, 4);
}

/// Distances have faces too; what they differ by is no index.
TEST(InstrumentErrors, DistancesSayNothingOfTheIndex) {
  Readings r;
  r.index = 3 * kMgon;
  for (const int face : {1, 2})
    for (int t = 0; t < 5; ++t) {
      r.sight(t, face, 1);
      Observation o = r.survey().observations.back();
      o.kind = ObservationKind::slope_distance, o.value = 20 + 0.002 * face;
      r.survey().observations.push_back(o);
    }
  const MeanResult m = r.reduce();
  ASSERT_EQ(m.instrument.size(), 1u);
  EXPECT_NEAR(m.instrument[0].index, 3 * kMgon, 1e-9);
  EXPECT_NEAR(m.instrument[0].collimation, 0, 1e-9);
}

}  // namespace test_station_reduction
}  // namespace plumbline::survey
