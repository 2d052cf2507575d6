#include "survey_test_support.hpp"

#include <stdexcept>

namespace plumbline::survey::test_help {

using enum ObservationKind;

const Observation& observation(const SurveyObservations& survey, int pointing, ObservationKind kind) {
  for (const Observation& o : survey.observations)
    if (o.pointing == pointing && o.kind == kind) return o;
  throw std::runtime_error("no such observation of pointing " + std::to_string(pointing));
}

double value(const SurveyObservations& survey, int pointing, ObservationKind kind) {
  return observation(survey, pointing, kind).value;
}

const Point& point(const SurveyObservations& survey, const std::string& id) {
  for (const Point& p : survey.points)
    if (p.id == id) return p;
  throw std::runtime_error("no point " + id);
}

bool skipped(const SurveyObservations& survey, int line, int column, const std::string& expected) {
  for (const SkippedLine& s : survey.skipped)
    if (s.source.line == line && s.source.column == column && s.expected.find(expected) != std::string::npos)
      return true;
  return false;
}

SurveyObservations random_survey(unsigned long long seed) {
  Random random{seed};
  SurveyObservations survey;
  const auto add_point = [&](const std::string& id) {
    Point p;
    p.id = id;
    if (random.uniform(0, 1) < 0.5)
      p.coordinates = {random.uniform(-5000, 5000), random.uniform(-5000, 5000), random.uniform(-10, 100)};
    survey.points.push_back(p);
  };
  for (int s = 0; s < 3; ++s) {
    SetUp set_up;
    set_up.id = set_up.station = "S-" + std::to_string(s);
    set_up.instrument_height = random.uniform(0, 2);
    add_point(set_up.id);
    survey.set_ups.push_back(set_up);
  }
  for (int p = 0; p < 8; ++p) add_point("TOR \xC3\x9C " + std::to_string(p));
  for (int pointing = 0; pointing < 60; ++pointing) {
    Observation o;
    o.set_up = pointing / 20;
    o.pointing = pointing;
    o.from = survey.set_ups[o.set_up].station;
    o.to = survey.points[3 + static_cast<std::size_t>(random.uniform(0, 7.99))].id;
    o.target_height = random.uniform(-1, 3);
    if (pointing % 20 != 0 && random.uniform(0, 1) < 0.2) o.instrument_height = random.uniform(0, 2);
    const double zenith = random.uniform(1e-4, 2 * std::numbers::pi - 1e-4);
    o.face = zenith > std::numbers::pi ? 2 : 1;
    const auto add = [&](ObservationKind kind, double v) {
      o.kind = kind;
      o.value = v;
      survey.observations.push_back(o);
    };
    add(direction, random.uniform(0, 2 * std::numbers::pi));
    add(zenith_angle, zenith);
    if (random.uniform(0, 1) < 0.8) add(slope_distance, random.uniform(0.5, 3000));
  }
  return survey;
}

void expect_same(const SurveyObservations& a, const SurveyObservations& b, double tolerance) {
  ASSERT_EQ(a.set_ups.size(), b.set_ups.size());
  for (std::size_t i = 0; i < a.set_ups.size(); ++i) {
    EXPECT_EQ(a.set_ups[i].station, b.set_ups[i].station);
    EXPECT_NEAR(a.set_ups[i].instrument_height, b.set_ups[i].instrument_height, tolerance);
  }
  ASSERT_EQ(a.observations.size(), b.observations.size());
  for (std::size_t i = 0; i < a.observations.size(); ++i) {
    const Observation &x = a.observations[i], &y = b.observations[i];
    EXPECT_EQ(x.kind, y.kind);
    EXPECT_EQ(x.set_up, y.set_up);
    EXPECT_EQ(x.pointing, y.pointing);
    EXPECT_EQ(x.to, y.to);
    EXPECT_EQ(x.face, y.face);
    EXPECT_EQ(x.set_number, y.set_number);
    EXPECT_NEAR(std::remainder(x.value - y.value, 2 * std::numbers::pi), 0, tolerance);
    const auto height = [](const SurveyObservations& s, const Observation& o) {
      return std::isnan(o.instrument_height) ? s.set_ups[o.set_up].instrument_height : o.instrument_height;
    };
    EXPECT_NEAR(height(a, x), height(b, y), tolerance);
    EXPECT_NEAR(std::isnan(x.target_height) ? 0 : x.target_height, y.target_height, tolerance);
  }
}

}  // namespace plumbline::survey::test_help
