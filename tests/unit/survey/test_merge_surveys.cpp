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

double rounded(double value, double step) { return step * std::round(value / step); }

/// As an instrument writes them: tenths of a milligon or of a millimetre, or a tenth of that.
SurveyObservations in_digits(SurveyObservations s, double scale) {
  for (Observation& o : s.observations)
    o.value = rounded(o.value,
                      o.kind == ObservationKind::slope_distance ? scale * 1e-4 : scale * 1e-4 * std::numbers::pi / 200);
  return s;
}

/// Job file and table of the same readings were 4 set-ups for 2, "seen at the same places".
TEST(MergeSurveys, ReadingsWithFewerDigitsInAnotherFileCountOnce) {
  const SurveyObservations fine = in_digits(day("job.gsi", 1), 0.1);
  SurveyObservations coarse = in_digits(fine, 1);
  coarse.files = {"table.csv"};
  for (const auto& files : {std::vector{fine, coarse}, std::vector{coarse, fine}}) {
    const MergedSurvey merged = merge_surveys(files);
    EXPECT_EQ(merged.survey.observations.size(), fine.observations.size());
    ASSERT_EQ(merged.survey.set_ups.size(), 2u);
    EXPECT_EQ(merged.survey.observations[0].value, fine.observations[0].value) << "the digits stay";
    EXPECT_TRUE(says(merged, "of table.csv stand in job.gsi too"));
  }
  // Another day on a circle that was set to zero again, or in digits that tell nothing, is another measurement.
  const SurveyObservations other = in_digits(day("next.gsi", 2), 1);
  EXPECT_EQ(merge_surveys({coarse, other}).survey.observations.size(), 2 * fine.observations.size());
}

TEST(MergeSurveys, RowsThatWerePastedTwiceCountOnce) {
  const SurveyObservations once = in_digits(day("obs.csv", 1), 1);
  SurveyObservations twice = once;
  const int pointings = twice.observations.back().pointing + 1;
  for (const Observation& o : once.observations) {
    twice.observations.push_back(o);
    twice.observations.back().pointing += pointings;
    twice.observations.back().set_number += 1;
  }
  const MergedSurvey merged = merge_surveys({twice});
  EXPECT_EQ(merged.survey.observations.size(), once.observations.size());
  EXPECT_TRUE(says(merged, "of set-up S1 repeat others to the last digit"));
  // A second set that an instrument with few digits shows alike is a second set.
  SurveyObservations sets = twice;
  for (Observation& o : sets.observations)
    o.value = rounded(o.value, o.kind == ObservationKind::slope_distance ? 1e-3 : 1e-3 * std::numbers::pi / 200);
  EXPECT_EQ(merge_surveys({sets}).survey.observations.size(), twice.observations.size());
  EXPECT_TRUE(merge_surveys({once}).findings.empty());
}

SurveyObservations with_vectors(const std::string& file, double off) {
  SurveyObservations s;
  s.files = {file};
  for (const char* id : {"K1", "A"}) s.points.push_back({}), s.points.back().id = id;
  VectorGroup g;
  g.vectors = {{"K1", "A"}};
  g.values = Eigen::Vector3d(10 + off, 20, 30);
  g.covariance = 1e-6 * Eigen::Matrix3d::Identity();
  g.source = {file, 3, 1};
  s.vectors = {g};
  CoordinateGroup k;
  k.components = {{"K1", 0}, {"K1", 1}, {"K1", 2}};
  k.values = Eigen::Vector3d(1, 2, 3);
  k.covariance = g.covariance;
  k.is_control = true;
  k.source = {file, 1, 1};
  s.coordinates = {k};
  Observation line;
  line.kind = ObservationKind::height_difference;
  line.from = "K1", line.to = "A", line.value = 30.001, line.sigma = 0.002;
  line.source = {file, 4, 1};
  s.observations = {line};
  return s;
}

/// GNSS vectors of a file and its copy were 20 readings for 10; the block of known points that both days' files begin
/// with held a point that was keyed 30 mm wrong as if two had measured it.
TEST(MergeSurveys, VectorsAndKnownPointsInTwoFilesCountOnce) {
  const MergedSurvey copy = merge_surveys({with_vectors("a.dat", 0), with_vectors("b.dat", 0)});
  EXPECT_EQ(copy.survey.vectors.size(), 1u);
  EXPECT_EQ(copy.survey.coordinates.size(), 1u);
  EXPECT_EQ(copy.survey.observations.size(), 1u);
  EXPECT_TRUE(says(copy, "1 of the vectors stand a second time with the same values (b.dat:3:1 is a.dat:3:1)"));
  const MergedSurvey days = merge_surveys({with_vectors("a.dat", 0), with_vectors("b.dat", 0.002)});
  EXPECT_EQ(days.survey.vectors.size(), 2u);
  EXPECT_EQ(days.survey.coordinates.size(), 1u);
  EXPECT_EQ(days.survey.observations.size(), 2u) << "one line may come out alike on two days";
  for (const Finding& f : days.findings)
    EXPECT_EQ(f.severity, Finding::Severity::note)
        << "known points of every file are nothing to worry about: " << f.text;
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

/// A Cyrillic K in the control, a number mistyped: the known point held nothing, "3 known points" of 4, sound.
/// Two free stations of one file that are both called FS were one point: nothing fitted, and control was blamed.
TEST(MergeSurveys, OneNameForTwoFreeStationsOfOneFileIsTwoPoints) {
  SurveyObservations s = day("a.gsi", 1);
  for (auto& u : s.set_ups) u.station = "FS";
  for (Observation& o : s.observations) o.from = "FS";
  const MergedSurvey merged = merge_surveys({s});
  ASSERT_EQ(merged.survey.set_ups.size(), 2u);
  EXPECT_EQ(merged.survey.set_ups[0].station, "FS");
  EXPECT_EQ(merged.survey.set_ups[1].station, "FS/2");
  for (const Observation& o : merged.survey.observations) EXPECT_EQ(o.from, merged.survey.set_ups[o.set_up].station);
  EXPECT_TRUE(says(merged, "station FS is occupied twice"));
  EXPECT_LT(adjust_network(merged.survey, {}).sigma0, 1.3);
  // Said to be one mark, sighted as one, or seen to be one, it is one.
  EXPECT_EQ(merge_surveys({s}, {{}, {"FS"}}).survey.set_ups[1].station, "FS");
  EXPECT_EQ(merge_surveys({s}, {{"FS"}, {}}).survey.set_ups[1].station, "FS");
  SurveyObservations twice = day("a.gsi", 1);
  twice.set_ups[1].station = twice.set_ups[0].station;
  test::Normal normal(3);
  std::erase_if(twice.observations, [](const Observation& o) { return o.set_up == 1; });
  for (size_t i = 0, n = twice.observations.size(); i < n; ++i) {
    Observation o = twice.observations[i];
    o.set_up = 1, o.pointing += 1000;
    o.value += o.sigma * normal();
    twice.observations.push_back(o);
  }
  const MergedSurvey one = merge_surveys({twice});
  EXPECT_EQ(one.survey.set_ups[1].station, one.survey.set_ups[0].station);
  EXPECT_FALSE(says(one, "is occupied twice"));
}

TEST(AlikeNames, ForeignLettersAndMistypedNumbersOfKnownPointsAreSaid) {
  SurveyObservations s = day("a.gsi", 1);
  for (const auto& [one, other] : {std::pair{"\xD0\x9A"
                                             "1",
                                             "K1"},
                                   {"\xCE\x9A"
                                    "1",
                                    "K1"}}) {
    Observation o;
    o.to = other;
    SurveyObservations with = s;
    with.observations.push_back(o);
    const std::vector<Finding> findings = examine_known_names(with, {one});
    ASSERT_EQ(findings.size(), 1u);
    EXPECT_NE(findings[0].text.find("(read is K1)"), std::string::npos) << findings[0].text;
  }
  NetworkResult r;
  r.points.resize(2);
  r.points[0].id = "K1", r.points[0].position = {1000.004, 2000, 100};
  r.points[1].id = "K2", r.points[1].position = {1100, 2000, 100};
  ControlPoints known;
  known.ids = {"K7", "K2", "K2old", "K9"};
  known.coordinates.resize(12);
  known.coordinates << 1000, 2000, 100, 1100, 2000, 100, 1100, 2000, 100, 5000, 5000, 100;
  const std::vector<Finding> findings = examine_unread_places(r, known);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_NE(findings[0].text.find(": K7 (4.0 mm from K1); where"), std::string::npos) << findings[0].text;
  EXPECT_EQ(findings[0].points, std::vector<std::string>{"K1"});
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
