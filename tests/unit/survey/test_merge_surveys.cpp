#include <gtest/gtest.h>

#include <map>
#include <numbers>

#include "simulated_network.hpp"
#include "survey/adjust/adjust_network.hpp"
#include "survey/doctor/network_doctor.hpp"
#include "survey/start/alike_names.hpp"
#include "survey/start/merge_surveys.hpp"

namespace plumbline::survey {
namespace test_merge_surveys {

/// A day of the simulated facade whose file has a name; its set-ups are S1, S2.
SurveyObservations day(const std::string& file, std::uint64_t seed, const Eigen::Vector3d& shift = {0, 0, 0}) {
  test::SimulationSettings settings;
  settings.set_ups = 2;
  settings.coordinates = false;
  auto n = test::simulate(settings, seed);
  n.survey.files = {file};
  if (shift.norm() == 0) return n.survey;
  // Other free stations: what they measure is computed anew from where they stand.
  for (Observation& o : n.survey.observations) {
    const auto index = [&](const std::string& id) {
      for (size_t i = 0; i < n.survey.points.size(); ++i)
        if (n.survey.points[i].id == id) return i;
      return size_t{0};
    };
    const Eigen::Vector3d d = n.truth[index(o.to)] - n.truth[index(o.from)] - shift;
    const double h = d.head<2>().norm();
    if (o.kind == ObservationKind::direction) o.value = std::atan2(d.x(), d.y());
    if (o.kind == ObservationKind::zenith_angle) o.value = std::atan2(h, d.z());
    if (o.kind == ObservationKind::slope_distance) o.value = d.norm();
  }
  return n.survey;
}

bool says(const MergedSurvey& merged, const std::string& text) {
  for (const Finding& f : merged.findings)
    if (f.text.find(text) != std::string::npos) return true;
  return false;
}

TEST(MergeSurveys, FreeStationsOfOneNameAreTwoPoints) {
  const MergedSurvey merged = merge_surveys({day("a/monday.gsi", 1), day("b/tuesday.gsi", 2, {3, -2, 0.1})});
  EXPECT_TRUE(says(merged, "monday:S1, tuesday:S1"));
  ASSERT_EQ(merged.survey.set_ups.size(), 4u);
  EXPECT_EQ(merged.survey.set_ups[2].station, "tuesday:S1");
  EXPECT_EQ(merged.survey.set_ups[2].id, "tuesday:S1");
  for (const Observation& o : merged.survey.observations) EXPECT_EQ(o.from, merged.survey.set_ups[o.set_up].station);
  const NetworkResult result = adjust_network(merged.survey, {});
  EXPECT_LT(result.sigma0, 1.3);
}

TEST(MergeSurveys, SightingsOfThreeFilesStayApartAndFilesAreListed) {
  const std::vector<SurveyObservations> days = {day("a.gsi", 1), day("b.gsi", 2, {3, -2, 0.1}),
                                                day("c.gsi", 3, {5, -1, 0.1})};
  const MergedSurvey merged = merge_surveys(days);
  EXPECT_EQ(merged.survey.files, (std::vector<std::string>{"a.gsi", "b.gsi", "c.gsi"}));
  std::map<int, std::pair<int, std::string>> seen;  // pointing -> set-up, target
  for (const Observation& o : merged.survey.observations) {
    const auto [at, is_new] = seen.try_emplace(o.pointing, o.set_up, o.to);
    EXPECT_EQ(at->second, std::pair(o.set_up, o.to)) << "pointing " << o.pointing;
  }
  EXPECT_EQ(seen.size(), 3u * 2 * 12);
}

TEST(MergeSurveys, ReadingsInTheOtherFaceShowTheSameFigure) {
  SurveyObservations second = day("tuesday.gsi", 2);
  for (Observation& o : second.observations) {
    o.face = 2;
    if (o.kind == ObservationKind::direction) o.value += std::numbers::pi;
    if (o.kind == ObservationKind::zenith_angle) o.value = 2 * std::numbers::pi - o.value;
  }
  // Some of them in face 1, so that a face that is taken for the other bends the figure.
  for (size_t i = 0; i < 12; ++i) second.observations[i] = day("tuesday.gsi", 2).observations[i];
  EXPECT_TRUE(says(merge_surveys({day("monday.gsi", 1), second}), "station S1 of monday, tuesday was united"));
}

/// The turn that most targets agree on decides, whichever target is looked at first or last.
TEST(MergeSurveys, OneTargetThatWasMovedDoesNotPartAStation) {
  for (const char* moved : {"M00", "M23"}) {
    SurveyObservations second = day("tuesday.gsi", 2);
    for (Observation& o : second.observations)
      if (o.to == moved && o.kind == ObservationKind::direction) o.value += 0.05;
    EXPECT_TRUE(says(merge_surveys({day("monday.gsi", 1), second}), "station S1 of monday, tuesday was united"))
        << moved;
  }
}

/// A file named twice counted every reading twice: redundancy 67 for 8.
TEST(MergeSurveys, ReadingsThatStandInTwoFilesCountOnce) {
  const SurveyObservations monday = day("monday.gsi", 1);
  SurveyObservations copy = monday;
  copy.files = {"copy.gsi"};
  copy.set_ups[0].id = copy.set_ups[0].station = "free-station-1";
  for (Observation& o : copy.observations)
    if (o.set_up == 0) o.from = "free-station-1";
  const MergedSurvey twice = merge_surveys({monday, copy});
  EXPECT_EQ(twice.survey.observations.size(), monday.observations.size());
  EXPECT_EQ(twice.survey.set_ups.size(), monday.set_ups.size());
  EXPECT_EQ(twice.survey.points.size(), monday.points.size()) << "no station that nothing is read from";
  EXPECT_TRUE(says(twice, "copy.gsi stand in monday.gsi too, set-ups free-station-1, S2"));
  ASSERT_EQ(twice.findings.size(), 1u);
  EXPECT_EQ(twice.findings[0].severity, Finding::Severity::warning);

  // What else the copy has is left out with it where it is the same, and stays where it is not; files may have no name.
  SurveyObservations with_gnss = monday;
  CoordinateGroup& group = with_gnss.coordinates.emplace_back();
  group.components = {{"M00", 0}, {"M00", 1}}, group.values = Eigen::Vector2d(10, 20);
  group.covariance = Eigen::Matrix2d::Identity() * 1e-4;
  SurveyObservations same = with_gnss, other = with_gnss;
  other.coordinates[0].values[1] += 0.01;
  EXPECT_EQ(merge_surveys({with_gnss, same}).survey.coordinates.size(), 1u);
  EXPECT_EQ(merge_surveys({with_gnss, other}).survey.coordinates.size(), 2u);
  same.files.clear();
  EXPECT_TRUE(says(merge_surveys({with_gnss, same}), "readings of file 2 stand in monday.gsi too"));

  // Downloaded at noon and in the evening: the first file is part of the second.
  SurveyObservations noon = monday;
  noon.files = {"noon.gsi"};
  noon.observations.resize(noon.observations.size() / 3);
  const MergedSurvey day_and_noon = merge_surveys({noon, monday, day("tuesday.gsi", 2)});
  EXPECT_EQ(day_and_noon.survey.observations.size(), 2 * monday.observations.size());
  EXPECT_TRUE(says(day_and_noon, "readings of noon.gsi stand in monday.gsi too"));
  EXPECT_FALSE(says(day_and_noon, "tuesday.gsi stand"));

  SurveyObservations glued = monday;
  for (auto u : monday.set_ups) glued.set_ups.push_back((u.id += "/2", u));
  for (Observation o : monday.observations) glued.observations.push_back((o.set_up += 2, o.pointing += 1000, o));
  EXPECT_EQ(merge_surveys({glued}).survey.observations.size(), monday.observations.size());
  EXPECT_TRUE(says(merge_surveys({glued}), "stand in it a second time"));
}

TEST(MergeSurveys, AMistypedNameOfASameStationIsSaid) {
  MergeOptions options;
  options.same_stations = {"S3", "S1"};
  EXPECT_TRUE(
      says(merge_surveys({day("monday.gsi", 1)}, options), "same_stations names S3, which is occupied in no file"));
  const MergedSurvey merged = merge_surveys({day("monday.gsi", 1), day("tuesday.gsi", 2)}, options);
  EXPECT_TRUE(says(merged, "S3, which is occupied in no file"));
  EXPECT_FALSE(says(merged, "S1, which is"));
}

TEST(MergeSurveys, TheSameFigureIsTheSameMark) {
  const MergedSurvey merged = merge_surveys({day("monday.gsi", 1), day("tuesday.gsi", 2)});
  EXPECT_TRUE(says(merged, "station S1 of monday, tuesday was united"));
  EXPECT_EQ(merged.survey.points.size(), 14u);
  EXPECT_EQ(merged.survey.set_ups[2].id, "tuesday:S1") << "two set-ups on one point have two ids";
  EXPECT_LT(adjust_network(merged.survey, {}).sigma0, 1.3);
}

// Turning alone hides a part of 20 mm: they were united, and sigma0 was 5.5.
TEST(MergeSurveys, StationsTwoCentimetresApartAreTwoMarks) {
  for (const Eigen::Vector3d& shift :
       {Eigen::Vector3d(0.02, 0, 0), Eigen::Vector3d(0, 0.02, 0), Eigen::Vector3d(0.014, -0.014, 0)}) {
    const MergedSurvey merged = merge_surveys({day("monday.gsi", 1), day("tuesday.gsi", 2, shift)});
    EXPECT_TRUE(says(merged, "monday:S1, tuesday:S1")) << shift.transpose();
    EXPECT_EQ(says(merged, "puts them") || says(merged, "at other places"), true) << shift.transpose();
    EXPECT_LT(adjust_network(merged.survey, {}).sigma0, 1.3);
  }
}

TEST(MergeSurveys, TheUserMaySayThatItIsOneMark) {
  const auto two = {day("monday.gsi", 1), day("tuesday.gsi", 2, {3, -2, 0.1})};
  EXPECT_FALSE(says(merge_surveys(two, {{}, {"S1"}}), "tuesday:S1"));
  EXPECT_TRUE(says(merge_surveys(two, {{}, {"S1"}}), "tuesday:S2"));
  EXPECT_FALSE(says(merge_surveys(two, {{}, {"*"}}), "tuesday:S2"));
}

TEST(MergeSurveys, NamesThatAReaderInventedNeverUnite) {
  SurveyObservations a = day("monday.gsi", 1), b = day("tuesday.gsi", 2);
  for (SurveyObservations* s : {&a, &b}) {
    for (auto& u : s->set_ups)  // SetUp is a member of the test here

      if (u.station == "S1") u.station = u.id = "free-station-1";
    for (Observation& o : s->observations)
      if (o.from == "S1") o.from = "free-station-1";
    for (Point& p : s->points)
      if (p.id == "S1") p.id = "free-station-1";
  }
  EXPECT_TRUE(says(merge_surveys({a, b}), "monday:free-station-1, tuesday:free-station-1"));
}

TEST(MergeSurveys, CoordinatesThatContradictAreLookedAt) {
  SurveyObservations a = day("monday.gsi", 1), b = day("tuesday.gsi", 2);
  for (size_t i = 0; i < 4; ++i) {
    a.points[i].coordinates = Eigen::Vector3d(10.0 * static_cast<double>(i), 5, 1);
    b.points[i].coordinates = a.points[i].coordinates + Eigen::Vector3d(1000, 2000, 3);
  }
  const MergedSurvey frames = merge_surveys({a, b});
  EXPECT_TRUE(says(frames, "the files are in different frames"));
  EXPECT_EQ(frames.survey.points[1].coordinates.x(), 10);
  b.points[0].coordinates = a.points[0].coordinates + Eigen::Vector3d(0, 0, 0.05);
  for (size_t i = 1; i < 4; ++i) b.points[i].coordinates = a.points[i].coordinates;
  EXPECT_TRUE(says(merge_surveys({a, b}), "by up to 0.050 m; those of monday are taken"));
  a.points[0].roles[2] = b.points[0].roles[2] = CoordinateRole::fixed;
  EXPECT_THROW(merge_surveys({a, b}), NetworkError);
}

/// A target of which one day has the direction only tells nothing of the mark; it neither counts nor stands for zero.
/// The targets of `survey` as another day has them that numbers from the same start: the next one's name each.
SurveyObservations renumbered(SurveyObservations survey, int by) {
  const auto next = [&](const std::string& id) {
    const int number = (id[1] - '0') * 4 + (id[2] - '0') + by;
    return "M" + std::to_string(number / 4 % 3) + std::to_string(number % 4);
  };
  for (Observation& o : survey.observations)
    if (o.to[0] == 'M') o.to = next(o.to);
  for (SetUp& s : survey.set_ups) s.id = s.station = "T" + s.station.substr(1);
  for (Observation& o : survey.observations) o.from[0] = 'T';
  return survey;
}

TEST(MergeSurveys, NumbersThatBeganAgainAreOtherMarks) {
  const SurveyObservations monday = day("monday.gsi", 1);
  SurveyObservations tuesday = day("tuesday.gsi", 2, {3, -2, 0.1});
  for (size_t i = 0; i < tuesday.observations.size(); ++i)  // no lattice that fits itself one mark further on
    if (tuesday.observations[i].kind == ObservationKind::slope_distance)
      tuesday.observations[i].value += 0.4 * static_cast<double>((7 * i) % 11);
  const MergedSurvey merged = merge_surveys({monday, renumbered(tuesday, 5)});
  EXPECT_TRUE(says(merged, "stand for other marks in tuesday than in monday"));
  EXPECT_TRUE(says(merged, "numbering began again"));
  size_t renamed = 0;
  for (const Observation& o : merged.survey.observations) renamed += o.to.starts_with("tuesday:M");
  EXPECT_GE(renamed, 2u * 3 * 9);
}

TEST(MergeSurveys, OneSwapFeetOrAControlPointAreNoNumberingThatBeganAgain) {
  const SurveyObservations monday = day("monday.gsi", 1);
  SurveyObservations swapped = renumbered(day("tuesday.gsi", 2, {3, -2, 0.1}), 0);
  for (Observation& o : swapped.observations) {
    if (o.to == "M00")
      o.to = "M12";
    else if (o.to == "M12")
      o.to = "M00";
  }
  EXPECT_FALSE(says(merge_surveys({monday, swapped}), "numbering began again"));
  SurveyObservations feet = renumbered(day("tuesday.gsi", 2, {3, -2, 0.1}), 0);
  for (Observation& o : feet.observations)
    if (o.kind == ObservationKind::slope_distance) o.value /= 0.3048;
  EXPECT_FALSE(says(merge_surveys({monday, feet}), "numbering began again"));
  MergeOptions options;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) options.known.push_back("M" + std::to_string(r) + std::to_string(c));
  EXPECT_FALSE(says(merge_surveys({monday, renumbered(day("tuesday.gsi", 2, {3, -2, 0.1}), 5)}, options),
                    "numbering began again"));
}

TEST(MergeSurveys, TargetsWithoutADistanceAreNotShared) {
  SurveyObservations a = day("monday.gsi", 1), b = day("tuesday.gsi", 2);
  int kept = 0;
  std::erase_if(b.observations, [&](const Observation& o) {
    return o.kind == ObservationKind::slope_distance && o.from == "S1" && ++kept > 3;
  });
  EXPECT_TRUE(says(merge_surveys({a, b}), "3 of 3 shared targets"));
}

TEST(MergeSurveys, LocalCoordinatesKeepTheirSetUp) {
  const auto local = [](const std::string& file, const std::string& station) {
    SurveyObservations survey;
    survey.files = {file};
    survey.set_ups.push_back({station + "/1", station, 1.5, {}});
    survey.set_ups.push_back({station + "/2", station, 1.5, {}});
    LocalCoordinate c;
    c.set_up = 1;
    c.point = "M1";
    c.position = {1, 20, 3};
    survey.local_coordinates.push_back(c);
    return survey;
  };
  const MergedSurvey merged = merge_surveys({local("monday.csv", "A"), local("tuesday.csv", "B")});
  ASSERT_EQ(merged.survey.local_coordinates.size(), 2u);
  EXPECT_EQ(merged.survey.set_ups.at(merged.survey.local_coordinates[0].set_up).id, "A/2");
  EXPECT_EQ(merged.survey.set_ups.at(merged.survey.local_coordinates[1].set_up).id, "B/2");
}

TEST(AlikeNames, AKnownPointOfWhichOnlyANameLikeItIsReadIsSaid) {
  const SurveyObservations survey = day("monday.gsi", 1);
  MergeOptions options;
  options.known = {"M00", "m01", "M-1-2", "elsewhere"};
  const MergedSurvey merged = merge_surveys({survey}, options);
  EXPECT_TRUE(says(merged, "m01 (read is M01)"));
  EXPECT_TRUE(says(merged, "M-1-2 (read is M12)"));
  EXPECT_TRUE(says(merged, "no reading touches: elsewhere"));
  EXPECT_FALSE(says(merged, "M00"));
  SurveyObservations said = survey;
  for (const Finding& f : merged.findings) said.warnings.push_back(f.text);
  EXPECT_TRUE(merge_surveys({said}, options).findings.empty());
  // The same where the file itself has it: held, or keyed in.
  for (const bool keyed : {false, true}) {
    SurveyObservations file = survey;
    Point& p = file.points.emplace_back();
    p.id = "m01", p.coordinates = {1, 2, 3};
    if (keyed)
      p.known[0] = true;
    else
      p.roles[0] = CoordinateRole::fixed;
    EXPECT_TRUE(says(merge_surveys({file}), "m01 (read is M01)")) << keyed;
    file.points.back().id = "elsewhere";
    EXPECT_TRUE(merge_surveys({file}).findings.empty()) << keyed;
  }
  options.known = {"M00", "M01"};
  EXPECT_TRUE(merge_surveys({survey}, options).findings.empty());
}

TEST(AlikeNames, LettersThatLookLikeDigitsAndUmlautsOfTwoEncodingsAreAlike) {
  const std::string composed =
                        "M\xc3\x9c"
                        "1",
                    decomposed =
                        "MU\xcc\x88"
                        "1";
  for (const auto& [known, read] : std::vector<std::pair<std::string, std::string>>{
           {"PO3", "P03"}, {"M0l", "M01"}, {decomposed, composed}, {"mue1", composed}, {"FO1", "F1"}}) {
    SurveyObservations survey = day("monday.gsi", 1);
    for (Observation& o : survey.observations)
      if (o.to == "M01") o.to = read;
    MergeOptions options;
    options.known = {known};
    EXPECT_EQ(merge_surveys({survey}, options).known_by_other_names, std::vector<std::string>{read}) << known;
    options.known = {read, "BOLT", "MI"};
    EXPECT_TRUE(merge_surveys({survey}, options).known_by_other_names.empty()) << "letters alone stay letters";
  }
}

TEST(AlikeNames, NothingIsSoundWhileKnownPointsHoldNothingForTheirSpelling) {
  const SurveyObservations survey = day("monday.gsi", 1);
  MergeOptions options;
  options.known = {"M00", "m01"};
  SurveyObservations joined = survey;
  for (int round = 0; round < 2; ++round) {
    const MergedSurvey merged = merge_surveys({joined}, options);
    EXPECT_EQ(merged.known_by_other_names, std::vector<std::string>{"M01"}) << "also of a folder that was joined";
    NetworkResult result = adjust_network(merged.survey, {});
    ASSERT_EQ(result.validity, Validity::sound) << result.verdict;
    const std::string before = result.verdict;
    doubt_known_names({}, result);
    EXPECT_EQ(result.verdict, before);
    doubt_known_names(merged.known_by_other_names, result);
    EXPECT_EQ(result.validity, Validity::doubtful);
    EXPECT_NE(result.verdict.find("(M01); of the readings: " + before), std::string::npos) << result.verdict;
    for (const Finding& f : merged.findings) joined.warnings.push_back(f.text);
  }
  NetworkResult invalid;
  invalid.validity = Validity::invalid, invalid.verdict = "not a result";
  doubt_known_names({"M01"}, invalid);
  EXPECT_EQ(invalid.verdict, "not a result");
}

TEST(AlikeNames, OneMarkUnderTwoNamesIsSaidAndTwoMarksAreNot) {
  SurveyObservations survey = day("monday.gsi", 1);
  for (Observation& o : survey.observations)
    if (o.to == "M01" && o.from == "S2") o.to = "m01";
  const std::vector<Finding> one = examine_alike_points(adjust_network(survey, {}));
  ASSERT_EQ(one.size(), 1u);
  EXPECT_EQ(one.front().points, (std::vector<std::string>{"M01", "m01"}));
  for (Observation& o : survey.observations) {
    if (o.to == "m01") o.to = "M01";
    if (o.to == "M12") o.to = "m01";  // another mark, some metres away
  }
  EXPECT_TRUE(examine_alike_points(adjust_network(survey, {})).empty());
}

}  // namespace test_merge_surveys
}  // namespace plumbline::survey
