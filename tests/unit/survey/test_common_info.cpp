// What several files say of themselves: the order of the files decides nothing, and what differs is told.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "simulated_network.hpp"
#include "survey/adjust/adjust_network.hpp"
#include "survey/model/several_instruments.hpp"
#include "survey/start/merge_surveys.hpp"

namespace plumbline::survey {
namespace test_common_info {

/// A day whose readings have no standard deviation; all days have the same approximate coordinates.
SurveyObservations plain_day(const std::string& file, std::uint64_t seed) {
  test::SimulationSettings settings;
  settings.set_ups = 2;
  settings.sigmas = false;
  SurveyObservations survey = test::simulate(settings, seed).survey;
  survey.files = {file};
  survey.info.format = "gsi";
  return survey;
}

/// As survey.adjust does with its parameters as they are.
NetworkResult adjusted(const MergedSurvey& merged) {
  AdjustOptions options;
  std::string remark;
  options.profile = choose_profile("automatic", "", merged.survey.info.instrument, remark);
  options.instruments = choose_instruments("automatic", "", merged.survey.instruments);
  options.curvature = Switch::off;
  options.datum = DatumMode::inner;
  return adjust_network(merged.survey, options);
}

void expect_same(const NetworkResult& a, const NetworkResult& b) {
  ASSERT_EQ(a.points.size(), b.points.size());
  for (const ResultPoint& p : a.points) {
    const ResultPoint& q = b.point(p.id);
    EXPECT_LT((p.position - q.position).norm(), 1e-12 * p.position.norm()) << p.id;
    EXPECT_LT((a.sigma(p) - b.sigma(q)).norm(), 1e-12) << p.id;
  }
}

std::string finding_with(const MergedSurvey& merged, const std::string& text) {
  for (const Finding& f : merged.findings)
    if (f.text.find(text) != std::string::npos) return f.text;
  return "";
}

TEST(CommonInfo, EachFilesReadingsHaveTheirOwnInstrumentInAnyOrder) {
  SurveyObservations precise = plain_day("campaign.gsi", 1), other = plain_day("tracker.gsi", 2);
  precise.info.instrument = "total_station_1arcsec";
  other.info.instrument = "iCON 50";  // no profile has that name
  const MergedSurvey one = merge_surveys({precise, other}), two = merge_surveys({other, precise});
  for (const MergedSurvey* merged : {&one, &two}) {
    EXPECT_EQ(merged->survey.info.instrument, "");
    for (const Observation& o : merged->survey.observations) {
      ASSERT_GE(o.instrument, 0);
      const bool first = std::any_of(precise.observations.begin(), precise.observations.end(),
                                     [&](const Observation& p) { return p.value == o.value; });
      EXPECT_EQ(merged->survey.instruments[o.instrument], first ? "total_station_1arcsec" : "iCON 50");
    }
    const std::string said = finding_with(*merged, "the instrument that the files name differs");
    EXPECT_NE(said.find("'total_station_1arcsec' in campaign"), std::string::npos) << said;
    EXPECT_NE(said.find("'iCON 50' in tracker"), std::string::npos) << said;
  }
  expect_same(adjusted(one), adjusted(two));
  // And the two days weigh as they would alone.
  SurveyObservations both_precise = other;
  both_precise.info.instrument = precise.info.instrument;
  const NetworkResult finer = adjusted(merge_surveys({precise, both_precise}));
  EXPECT_LT(finer.sigma(finer.point("M00")).norm(), 0.9 * adjusted(one).sigma(adjusted(one).point("M00")).norm());
}

TEST(CommonInfo, AFileThatNamesNoInstrumentDoesNotTakeThatOfAnother) {
  SurveyObservations precise = plain_day("campaign.gsi", 1), silent = plain_day("monday.gsi", 2);
  precise.info.instrument = "total_station_1arcsec";
  const MergedSurvey one = merge_surveys({precise, silent}), two = merge_surveys({silent, precise});
  EXPECT_NE(finding_with(one, "none in monday"), "");
  expect_same(adjusted(one), adjusted(two));
  const auto without = std::count_if(one.survey.observations.begin(), one.survey.observations.end(),
                                     [](const Observation& o) { return o.instrument < 0; });
  EXPECT_EQ(static_cast<size_t>(without), silent.observations.size());
}

TEST(CommonInfo, FilesOfOneInstrumentStayAsTheyAre) {
  SurveyObservations a = plain_day("monday.gsi", 1), b = plain_day("tuesday.gsi", 2);
  a.info.instrument = b.info.instrument = "total_station_1arcsec";
  SurveyObservations list;  // names no instrument and needs none
  list.files = {"points.csv"};
  list.points.push_back(a.points.front());
  list.info.format = "gsi";
  const MergedSurvey merged = merge_surveys({list, a, b});
  EXPECT_EQ(merged.survey.info.instrument, "total_station_1arcsec");
  EXPECT_TRUE(merged.survey.instruments.empty());
  EXPECT_EQ(finding_with(merged, "differs"), "");
}

TEST(CommonInfo, AChosenProfileHoldsForAllInstruments) {
  EXPECT_TRUE(choose_instruments("ics50_assumed", "", {"total_station_1arcsec"}).empty());
  EXPECT_EQ(choose_instruments("automatic", "", {"total_station_1arcsec", "TS 16"}).size(), 1u);
}

TEST(CommonInfo, WhatOneFileAsksForIsNotDoneToAnother) {
  SurveyObservations a = plain_day("net.gkf", 1), b = plain_day("monday.gsi", 2);
  a.info.use_a_posteriori_sigma0 = true;
  a.info.refraction_coefficient = 0.2;
  a.info.largest_misclosure = 0.001;
  a.info.date = "2024-05-02", b.info.date = "2024-05-03";
  a.info.coordinate_system = "EPSG:25832";
  for (const MergedSurvey& merged : {merge_surveys({a, b}), merge_surveys({b, a})}) {
    const NetworkInfo& info = merged.survey.info;
    EXPECT_FALSE(info.use_a_posteriori_sigma0);
    EXPECT_TRUE(std::isnan(info.refraction_coefficient));
    EXPECT_TRUE(std::isnan(info.largest_misclosure));
    EXPECT_EQ(info.date, "");
    EXPECT_EQ(info.coordinate_system, "EPSG:25832") << "who states none contradicts nobody";
    EXPECT_NE(finding_with(merged, "a posteriori sigma0").find("yes in net"), std::string::npos);
    EXPECT_NE(finding_with(merged, "a posteriori sigma0").find("no in monday"), std::string::npos);
    EXPECT_NE(finding_with(merged, "refraction coefficient").find("0.2 in net"), std::string::npos);
    EXPECT_NE(finding_with(merged, "misclosure").find("0.001 in net"), std::string::npos);
    EXPECT_NE(finding_with(merged, "the date").find("'2024-05-03' in monday"), std::string::npos);
    EXPECT_EQ(adjusted(merged).variance_factor, 1);
  }
  b.info.coordinate_system = "EPSG:25833";
  EXPECT_EQ(merge_surveys({a, b}).survey.info.coordinate_system, "");
  EXPECT_NE(finding_with(merge_surveys({b, a}), "coordinate system of the files differs"), "");
}

// --- reduced readings beside those of a field book ----------------------------------------------------------------

/// One set-up on the known A, oriented on the known B, that sights `target`, a kilometre away and 20 m higher.
SurveyObservations long_sight(const std::string& file, const std::string& format, const std::string& target,
                              bool reduced) {
  SurveyObservations s;
  s.files = {file};
  s.info.format = format;
  const auto known = [&](const std::string& id, const Eigen::Vector3d& at) {
    Point p;
    p.id = id;
    p.coordinates = at;
    p.roles.fill(CoordinateRole::fixed);
    s.points.push_back(p);
  };
  known("A", {0, 0, 100});
  known("B", {0, 1000, 100});
  s.set_ups.push_back({file, "A", 0.0, {}});
  const auto add = [&](ObservationKind kind, const std::string& to, double value, double sigma) {
    Observation o;
    o.kind = kind;
    o.set_up = 0;
    o.from = "A";
    o.to = to;
    o.value = value;
    o.sigma = sigma;
    s.observations.push_back(o);
  };
  const double h = 1000, dh = 20;
  const double bend = reduced ? 0 : (1 - 0.13) / 6.371e6;  // the earth falls away below the line of sight
  const double seen = dh - 0.5 * bend * h * h;
  add(ObservationKind::direction, "B", 0, 1e-6);
  add(ObservationKind::direction, target, 1.0, 1e-6);
  add(ObservationKind::zenith_angle, target, std::atan2(h, seen), 1e-6);
  add(ObservationKind::slope_distance, target, std::hypot(h, dh), 1e-4);
  return s;
}

double height(const NetworkResult& result, const std::string& id) { return result.point(id).position.z(); }

TEST(CommonInfo, ReducedReadingsAreNotReducedAgainBesideAFieldBook) {
  const SurveyObservations net = long_sight("net.gkf", "gama-xml", "P", true);
  const SurveyObservations book = long_sight("book.gsi", "gsi", "Q", false);
  EXPECT_NEAR(height(adjust_network(net, {}), "P"), 120, 1e-3);
  EXPECT_NEAR(height(adjust_network(book, {}), "Q"), 120, 2e-3);
  for (const auto& files : {std::vector{net, book}, std::vector{book, net}}) {
    const NetworkResult result = adjust_network(merge_surveys(files).survey, {});
    EXPECT_NEAR(height(result, "P"), 120, 1e-3);
    EXPECT_NEAR(height(result, "Q"), 120, 2e-3);
  }
  // Who says it outright gets it, for all of them.
  AdjustOptions on;
  on.curvature = Switch::on;
  EXPECT_GT(height(adjust_network(merge_surveys({net, book}).survey, on), "P"), 120.06);
}

TEST(CommonInfo, TwoFormatsOfReducedReadingsStayReduced) {
  const SurveyObservations net = long_sight("net.gkf", "gama-xml", "P", true);
  const SurveyObservations krumm = long_sight("net.dat", "krumm", "Q", true);
  const NetworkResult result = adjust_network(merge_surveys({net, krumm}).survey, {});
  EXPECT_NEAR(height(result, "P"), 120, 1e-3);
  EXPECT_NEAR(height(result, "Q"), 120, 1e-3);
  // An unknown refraction coefficient belongs to the raw readings only.
  AdjustOptions options;
  options.refraction_sigma = 0.1;
  const SurveyObservations book = long_sight("book.gsi", "gsi", "R", false);
  const NetworkResult mixed = adjust_network(merge_surveys({net, book}).survey, options);
  EXPECT_LT(mixed.sigma(mixed.point("P")).z(), 0.002);
  EXPECT_GT(mixed.sigma(mixed.point("R")).z(), 0.005);
}

}  // namespace test_common_info
}  // namespace plumbline::survey
