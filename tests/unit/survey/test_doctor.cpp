// What the network doctor says of sick networks.
#include "simulated_network.hpp"
#include "survey/adjust/adjust_network.hpp"
#include "survey/doctor/network_doctor.hpp"
#include "survey/network/network_model.hpp"
#include "test_support.hpp"

namespace plumbline::survey {
namespace test_doctor {

using test::simulate;

std::string message_of(const SurveyObservations& survey, const AdjustOptions& options,
                       const ControlPoints& control = {}) {
  try {
    // What is little beside the rest is left out with the same words.
    for (const Finding& f : adjust_network(survey, options, control).findings)
      if (f.text.starts_with("left out")) return f.text;
  } catch (const NetworkError& error) {
    return error.what();
  }
  return "";
}

AdjustOptions with_datum(DatumMode mode) {
  AdjustOptions options;
  options.datum = mode;
  options.curvature = Switch::off;
  return options;
}

void expect_words(const std::string& message, std::initializer_list<const char*> words) {
  for (const char* word : words) EXPECT_NE(message.find(word), std::string::npos) << word << " in: " << message;
}

TEST(NetworkDoctor, NamesAllFourDefectsOfALevelledNetwork) {
  const auto n = simulate({}, 1);
  expect_words(message_of(n.survey, with_datum(DatumMode::file)),
               {"rank defect", "translation in east", "translation in north", "translation in height",
                "rotation about the vertical through"});
}

TEST(NetworkDoctor, NamesTheRotationAboutTheOnlyFixedPoint) {
  auto n = simulate({}, 2);
  n.survey.points[0].roles.fill(CoordinateRole::fixed);
  const std::string message = message_of(n.survey, with_datum(DatumMode::file));
  expect_words(message, {"rotation about the vertical through M00"});
  EXPECT_EQ(message.find("translation"), std::string::npos) << message;
}

TEST(NetworkDoctor, OneColumnOfControlLeavesTheRotationAboutIt) {
  auto n = simulate({}, 3);
  for (size_t i : {0u, 4u, 8u}) n.survey.points[i].roles.fill(CoordinateRole::fixed);  // M00, M10, M20
  expect_words(message_of(n.survey, with_datum(DatumMode::file)),
               {"rotation about the vertical through M00, M10, M20"});
}

TEST(NetworkDoctor, NamesTheMissingScale) {
  auto n = simulate({}, 4);
  std::erase_if(n.survey.observations, [](const Observation& o) { return o.kind == ObservationKind::slope_distance; });
  AdjustOptions options = with_datum(DatumMode::fixed);
  options.datum_points = {"M00"};
  expect_words(message_of(n.survey, options), {"scale", "no distance"});
}

TEST(NetworkDoctor, NamesAPointThatIsNotDetermined) {
  auto n = simulate({}, 5);
  int seen = 0;
  std::erase_if(n.survey.observations, [&](const Observation& o) {
    return o.to == "M12" && !(o.kind == ObservationKind::direction && seen++ == 0);
  });
  for (Point& p : n.survey.points)
    if (p.id == "M12") p.coordinates.setConstant(kNotGiven);
  expect_words(message_of(n.survey, with_datum(DatumMode::inner)), {"M12", "1 direction"});
  for (size_t i = 0; i < n.truth.size(); ++i) n.survey.points[i].coordinates = n.truth[i];
  expect_words(message_of(n.survey, with_datum(DatumMode::inner)), {"not determined", "M12"});
}

TEST(NetworkDoctor, NamesSeparateParts) {
  auto n = simulate({}, 6);
  // The first set-up sees only M00..M03, the others only the rest.
  std::erase_if(n.survey.observations, [](const Observation& o) {
    const bool lowest = o.to[1] == '0';
    return lowest != (o.set_up == 0);
  });
  AdjustOptions options = with_datum(DatumMode::fixed);
  options.datum_points = {"M10", "M13"};
  expect_words(message_of(n.survey, options), {"of the part with", "M00"});
}

/// Of some markers, each with the components named (0 E, 1 N, 2 H).
ControlPoints control_of(const test::SimulatedNetwork& n, const std::vector<size_t>& markers, bool heights_only,
                         bool weighted) {
  ControlPoints c;
  c.coordinates.resize(static_cast<Eigen::Index>(3 * markers.size()));
  for (size_t i = 0; i < markers.size(); ++i) {
    c.ids.push_back(n.survey.points[markers[i]].id);
    auto p = c.coordinates.segment<3>(static_cast<Eigen::Index>(3 * i));
    p = n.truth[markers[i]];
    if (heights_only) p.head<2>().setConstant(kNotGiven);
  }
  if (weighted) c.covariance = 1e-6 * Eigen::MatrixXd::Identity(c.coordinates.size(), c.coordinates.size());
  return c;
}

/// What control leaves open has a name, whether it is held or weighted, with approximate coordinates or without any.
TEST(NetworkDoctor, NamesWhatTooLittleControlLeavesOpen) {
  for (const bool coordinates : {true, false})
    for (const bool weighted : {true, false}) {
      const auto n = simulate({.coordinates = coordinates}, 10);
      const auto say = [&](const std::vector<size_t>& markers, bool heights_only) {
        return message_of(n.survey, with_datum(weighted ? DatumMode::weighted : DatumMode::fixed),
                          control_of(n, markers, heights_only, weighted));
      };
      const std::string one = say({0}, false);
      expect_words(one, {"rotation about the vertical through M00 of the network is open",
                         "give a second control point or an azimuth"});
      EXPECT_EQ(one.find("not determined by"), std::string::npos) << one;
      expect_words(say({0, 4, 8}, false), {"rotation about the vertical through M00, M10, M20", "off this line"});
      const std::string heights = say({0, 3}, true);
      expect_words(heights, {"translation in east", "translation in north", "rotation about the vertical"});
      EXPECT_EQ(heights.find("translation in height"), std::string::npos) << heights;
      EXPECT_EQ(say({0, 3}, false), "");
    }
}

/// A control point that one direction ties to the network.
TEST(NetworkDoctor, NamesMovementsThatAreOpenTogether) {
  for (const bool coordinates : {true, false}) {
    auto n = simulate({.coordinates = coordinates}, 11);
    std::erase_if(n.survey.observations, [](const Observation& o) {
      return o.to == "M00" && !(o.set_up == 0 && o.kind == ObservationKind::direction);
    });
    expect_words(message_of(n.survey, with_datum(DatumMode::fixed), control_of(n, {0}, false, false)),
                 {"translation in height", "rotation about the vertical through M00", "1 further movement"});
  }
}

TEST(NetworkDoctor, NamesASetUpThatSharesOneMarkerOrNone) {
  for (const bool coordinates : {true, false}) {
    auto n = simulate({.coordinates = coordinates}, 12);
    std::erase_if(n.survey.observations, [](const Observation& o) { return o.set_up == 2 && o.to != "M01"; });
    for (const bool is_free : {true, false}) {
      const std::string message = message_of(n.survey, with_datum(is_free ? DatumMode::inner : DatumMode::fixed),
                                             is_free ? ControlPoints{} : control_of(n, {0, 3}, false, false));
      expect_words(message, {"set-up S3 shares only 1 point (M01)", "2 shared points are needed"});
      EXPECT_EQ(message.find("not determined by"), std::string::npos) << message;
    }
    auto parts = simulate({.set_ups = 2, .coordinates = coordinates}, 13);
    std::erase_if(parts.survey.observations, [](const Observation& o) { return (o.to[1] == '0') != (o.set_up == 0); });
    expect_words(message_of(parts.survey, with_datum(DatumMode::inner)),
                 {"place and rotation of the part with M00, M01, M02, M03, S1 are open", "shares no point"});
  }
}

/// Slope distances alone, of a cube: nothing tells the vertical.
TEST(NetworkDoctor, NamesTheTiltOfDistances) {
  for (const size_t held : {1u, 2u, 3u}) {
    SurveyObservations cube;
    for (int i = 0; i < 8; ++i) {
      Point p;
      p.id = "P" + std::to_string(i);
      p.coordinates = Eigen::Vector3d(10 * (i & 1), 8 * (i >> 1 & 1), 6 * (i >> 2 & 1));
      if (cube.points.size() < held) p.roles.fill(CoordinateRole::fixed);
      for (const Point& q : cube.points) {
        Observation o;
        o.kind = ObservationKind::slope_distance;
        o.from = p.id;
        o.to = q.id;
        o.value = (p.coordinates - q.coordinates).norm();
        o.sigma = 0.001;
        cube.observations.push_back(o);
      }
      cube.points.push_back(p);
    }
    const std::string message = message_of(cube, with_datum(DatumMode::file));
    if (held == 1) expect_words(message, {"vertical through P0", "tilt of the network", "through P0", "zenith angles"});
    if (held == 2) expect_words(message, {"rotation of the network about the line through P0, P1 is open"});
    EXPECT_EQ(message.empty(), held == 3) << message;
    EXPECT_EQ(message.find("not determined by"), std::string::npos) << message;
  }
}

/// A bench mark holds its height; where it lies is not invented.
TEST(NetworkDoctor, DatumPointWithoutCoordinatesIsAnError) {
  const auto n = simulate({.coordinates = false}, 14);
  AdjustOptions options = with_datum(DatumMode::fixed);
  options.datum_points = {"M00"};
  expect_words(message_of(n.survey, options), {"datum point 'M00' has no coordinates"});
}

TEST(NetworkDoctor, ListsUncontrolledObservationsAndHinges) {
  auto n = simulate({}, 7);
  std::erase_if(n.survey.observations, [](const Observation& o) { return o.to == "M23" && o.set_up != 0; });
  const NetworkResult r = adjust_network(n.survey, with_datum(DatumMode::inner));
  std::string all;
  for (const Finding& f : r.findings) all += f.text + "\n";
  expect_words(all, {"not controlled", "S1 -> M23"});

  auto hinge = simulate({}, 8);
  // Set-up 3 sees two markers only, and set-up 1 and 2 all: no hinge; with one marker it hangs on it.
  std::erase_if(hinge.survey.observations, [](const Observation& o) { return o.set_up == 2 && o.to[1] != '2'; });
  const NetworkResult ok = adjust_network(hinge.survey, with_datum(DatumMode::inner));
  for (const Finding& f : ok.findings) EXPECT_EQ(f.text.find("hangs on"), std::string::npos) << f.text;
}

TEST(NetworkDoctor, SaysWhichPointNobodyObserved) {
  auto n = simulate({}, 9);
  Point lonely;
  lonely.id = "X9";
  n.survey.points.push_back(lonely);
  const NetworkResult r = adjust_network(n.survey, with_datum(DatumMode::inner));
  std::string all;
  for (const Finding& f : r.findings) all += f.text + "\n";
  expect_words(all, {"no observation", "X9"});
  EXPECT_THROW(r.point("X9"), std::out_of_range);
}

/// An angle to a point that it does not begin at is an observation of it, too.
TEST(NetworkDoctor, SaysThatAPointWasSeenInAnAngleOnly) {
  auto n = simulate({}, 9);
  Observation angle;
  angle.kind = ObservationKind::angle;
  angle.from = n.survey.set_ups[0].station, angle.to = n.survey.points[0].id, angle.second_to = "X9";
  angle.value = 1, angle.sigma = 1e-5;
  angle.source = {"job.xml", 7, 1};
  n.survey.observations.push_back(angle);
  const NetworkResult r = adjust_network(n.survey, with_datum(DatumMode::inner));
  std::string all;
  for (const Finding& f : r.findings) all += f.text + "\n";
  expect_words(all, {"X9", ("1 angle with " + angle.from).c_str()});
}

/// A network that passes all its tests: ten readings of each of two set-ups.
NetworkResult sound_result() {
  NetworkResult r;
  for (const char* id : {"S1", "S2"}) {
    ResultSetUp& s = r.set_ups.emplace_back();
    s.id = s.station = id;
    for (int i = 0; i < 10; ++i) {
      ResultRow& row = r.rows.emplace_back();
      row.kind = "direction", row.set_up = id, row.statistics.w = 0.5;
    }
  }
  r.degrees_of_freedom = 10, r.sum_of_squares = 10, r.sigma0 = 1;
  r.cofactors = least_squares::Cofactors(Eigen::MatrixXd::Identity(2, 2));
  return r;
}

constexpr double kCritical = 4.5;

NetworkResult judged(NetworkResult r, bool contradicted = false) {
  NetworkModel model;
  if (contradicted) model.contradiction = "set-up S1 is in feet";
  judge(model, AdjustOptions(), kCritical, r);
  return r;
}

/// Three distances that came back from edges made a network doubtful whose directions to the same targets agree.
TEST(Verdict, DistancesAloneAreNoThinnedSetUpAndTwoReadingsAreNotMuch) {
  NetworkResult r = sound_result();
  for (int i = 0; i < 50; ++i) r.rows.push_back(r.rows.back());
  for (int i = 0; i < 3; ++i) {
    r.rows[i].removed = true;
    r.rows[i].kind = "slope_distance", r.rows[i].to = "P" + std::to_string(i);
  }
  EXPECT_EQ(judged(r).validity, Validity::sound) << judged(r).verdict;
  NetworkResult directions = r;
  for (int i = 0; i < 3; ++i) directions.rows[i].kind = "direction";
  expect_words(judged(directions).verdict, {"sights of set-up S1 to 3 targets were taken out"});
  r.rows[2].removed = false;
  r.errors_taken_off = 1;
  EXPECT_EQ(judged(r).validity, Validity::sound) << judged(r).verdict;
  r.rows[2].removed = true;
  EXPECT_EQ(judged(r).validity, Validity::doubtful);
}

TEST(Verdict, ASetUpThatLostAThirdOfItsReadingsIsNoResult) {
  NetworkResult r = sound_result();
  EXPECT_EQ(judged(r).validity, Validity::sound);
  for (int i = 0; i < 5; ++i) r.rows[i].removed = true;  // half of ten, but five readings are few
  const NetworkResult five = judged(r);
  EXPECT_EQ(five.validity, Validity::doubtful) << "a quarter of all";
  expect_words(five.verdict, {"so much was mended that what is left had to agree", "5 readings were taken out"});
  r.rows[5].removed = true;
  const NetworkResult six = judged(r);
  EXPECT_EQ(six.validity, Validity::invalid);
  expect_words(six.verdict,
               {"not a result", "the readings of set-up S1 contradict the others: 6 of 10 were taken out"});
  // Six of eighteen are a third, which is not more than a third.
  for (int i = 0; i < 8; ++i) r.rows.push_back(r.rows[9]);
  EXPECT_EQ(judged(r).validity, Validity::doubtful);
  r.rows[6].removed = true;
  EXPECT_EQ(judged(r).validity, Validity::invalid);
}

/// A facade that moved between set-ups: the sound sights to the control of the last went, few beside all readings.
TEST(Verdict, ASetUpOfWhichThreeTargetsWentIsDoubtful) {
  NetworkResult r = sound_result();
  for (int i = 0; i < 80; ++i) r.rows.push_back(r.rows[19]);
  for (int i = 0; i < 3; ++i) r.rows[i].removed = true, r.rows[i].to = "P1";
  EXPECT_EQ(judged(r).validity, Validity::sound) << "one target";
  r.rows[1].to = "P2", r.rows[2].to = "P3";
  const NetworkResult three = judged(r);
  EXPECT_EQ(three.validity, Validity::doubtful);
  expect_words(three.verdict, {"sights of set-up S1 to 3 targets were taken out", "these may be right"});
}

TEST(Verdict, ASetUpThatWasSplitTwiceIsNoResult) {
  NetworkResult r = sound_result();
  ResultSetUp part = r.set_ups[0];
  part.id = "S1 (part 2)";
  r.set_ups.push_back(part);
  EXPECT_EQ(judged(r).validity, Validity::sound) << "the circle was turned once";
  part.id = "S1 (part 3)";
  r.set_ups.push_back(part);
  const NetworkResult split = judged(r);
  EXPECT_EQ(split.validity, Validity::invalid);
  expect_words(split.verdict, {"set-up S1", "its circle would have been turned 2 times"});
  for (ResultSetUp& s : r.set_ups) s.orientation = 1, s.orientation_sigma = 1e-5;
  for (const size_t k : {size_t{2}, size_t{3}}) r.set_ups[k].orientation = 1.002 + 4e-5 * static_cast<double>(k - 2);
  EXPECT_EQ(judged(r).validity, Validity::sound) << "one turn of which the parts were found one after the other";
  r.set_ups[3].orientation = 1.0022;
  EXPECT_EQ(judged(r).validity, Validity::invalid);
}

TEST(Verdict, RemovedReadingsOfThePartsOfASetUpCountTogether) {
  NetworkResult r = sound_result();
  for (int i = 5; i < 10; ++i) r.rows[i].set_up = "S1 (part 2)";
  for (int i = 2; i < 8; ++i) r.rows[i].removed = true;  // three of each part
  EXPECT_EQ(judged(r).validity, Validity::invalid);
  for (int i = 2; i < 8; ++i) r.rows[i].set_up = "";  // of no set-up
  EXPECT_EQ(judged(r).validity, Validity::doubtful);
}

TEST(Verdict, WhatContradictsItselfIsNoResultAndItsSigmasGrow) {
  NetworkResult r = sound_result();
  EXPECT_EQ(judged(r, true).validity, Validity::invalid);
  r.global_test.verdict = least_squares::GlobalTest::Verdict::high;
  r.sigma0 = 20, r.sum_of_squares = 4000;
  const NetworkResult bad = judged(r);
  EXPECT_EQ(bad.validity, Validity::invalid);
  EXPECT_NEAR(bad.cofactors(0, 0), 400, 1e-9) << "covariance times sigma0 squared";
  EXPECT_NEAR(bad.variance_factor, 400, 1e-9);
  EXPECT_NEAR(judged(bad).cofactors(0, 0), 400, 1e-9) << "not twice";
  r.sigma0 = 9.9;
  EXPECT_EQ(judged(r).validity, Validity::doubtful);
  EXPECT_NEAR(judged(r).cofactors(0, 0), 1, 1e-12);
  r.findings.push_back({Finding::Severity::error, "x", {}});
  EXPECT_EQ(judged(r).validity, Validity::invalid);
}

TEST(Verdict, DoubtNeedsASuspectOrAClearFailure) {
  NetworkResult r = sound_result();
  r.global_test.verdict = least_squares::GlobalTest::Verdict::high;
  r.sum_of_squares = 21, r.sigma0 = 1.449;  // 10 degrees of freedom: 20.5 at 97.5 %, 29.6 at 99.9 %
  EXPECT_EQ(judged(r).validity, Validity::sound);
  expect_words(judged(r).verdict, {"a little high"});
  r.sum_of_squares = 30;
  EXPECT_EQ(judged(r).validity, Validity::doubtful);
  expect_words(judged(r).verdict, {"agree less well than their accuracies say"});
  r = sound_result();
  r.rows[3].statistics.w = -4.6;
  EXPECT_EQ(judged(r).validity, Validity::doubtful);
  expect_words(judged(r).verdict, {"1 reading fails the test"});
  r.rows[3].removed = true;
  EXPECT_EQ(judged(r).validity, Validity::sound);
  r.degrees_of_freedom = 0;
  EXPECT_EQ(judged(r).validity, Validity::doubtful);
}

}  // namespace test_doctor
}  // namespace plumbline::survey
