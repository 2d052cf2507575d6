// How often a mistake made with a whole file is named: angles in another unit, control with exchanged axes, a map that
// nobody gave. Thirty marks around a yard, five set-ups, five known points; one mistake in each trial, nothing mended.
// Prints a Markdown table.
//   survey_file_mistakes_benchmark [TRIALS [SCENARIO [FIRST_SEED]]]      SCENARIO: part of a name, "" for all
// named: a finding or the refusal says what it is. another word: refused, not a result or warned of, for another
// reason. silent: nothing is said and a marker lies beyond five of its standard deviations (plus 0.5 mm) from the
// truth.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "geometry/random.hpp"
#include "survey/adjust/adjust_network.hpp"
#include "survey/simulate/simulate_survey.hpp"

namespace {

using namespace plumbline;
using namespace plumbline::survey;
using Eigen::Vector3d;
using enum ObservationKind;

constexpr double kPi = std::numbers::pi;
constexpr double kUtmScale = 0.99964;  // of this place, the height included
const Vector3d kUtm(565000, 5933000, 20);

struct Trial {
  SurveyLayout layout;  ///< on the ground
  Vector3d origin = Vector3d::Zero();
  double scale = 1;  ///< of the control's map
  SurveyObservations survey;
  AdjustOptions options;
  Random random;

  explicit Trial(std::uint64_t seed) : random(seed, "file mistakes") {
    for (int m = 1; m <= 30; ++m)
      layout.points.push_back(
          {"M" + std::to_string(m), {random.uniform(-100, 100), random.uniform(-75, 75), random.uniform(0, 12)}});
    for (int i = 1; i <= 5; ++i) {
      const std::string id = "S" + std::to_string(i);
      layout.set_ups.push_back({id, id, random.uniform(1.4, 1.7), random.uniform(0, 2 * kPi), {}});
      for (int m = 1; m <= 30; ++m)
        if (random.uniform() < 0.85 || m == 8 || m == 20) layout.set_ups.back().sees.push_back("M" + std::to_string(m));
    }
    for (int i = 1; i <= 5; ++i)
      layout.points.push_back({"S" + std::to_string(i), {random.uniform(-50, 50), random.uniform(-35, 35), 0.1 * i}});
    SimulationOptions simulation;
    simulation.profile = options.profile = built_in_profile("total_station_2arcsec");
    simulation.sigmas = false;
    survey = simulate_survey(layout, simulation, seed);
    survey.info.format = "csv";
  }
  Vector3d on_map(const Vector3d& p) const { return origin + Vector3d(scale * p.x(), scale * p.y(), p.z()); }
  /// M1, M7, M13, M19, M25 as control of 2 mm.
  void know(const std::function<Vector3d(int, const Vector3d&)>& as = [](int, const Vector3d& p) { return p; }) {
    for (int k = 0; k < 5; ++k) {
      const SimulatedPoint& p = layout.points[6 * k];
      CoordinateGroup g;
      for (int axis = 0; axis < 3; ++axis) g.components.push_back({p.id, axis});
      const Vector3d true_place = on_map(p.position);
      g.values = as(k, Vector3d(true_place + random.normal3(2e-3)));
      g.covariance = 4e-6 * Eigen::Matrix3d::Identity();
      g.is_control = true;
      for (Point& point : survey.points)
        if (point.id == p.id) point.coordinates = g.values;
      survey.coordinates.push_back(std::move(g));
    }
  }
  void change(ObservationKind kind, int set_up, double (*how)(double)) {
    for (Observation& o : survey.observations)
      if (o.kind == kind && (set_up < 0 || o.set_up == set_up)) {
        o.value = how(o.value);
        o.value -= 2 * kPi * std::floor(o.value / (2 * kPi)) * (kind == direction || kind == zenith_angle);
      }
  }
};

/// The pole stood on `mark` (in all set-ups, or in one) with another length than was noted.
void target_height(Trial& t, int set_up, const std::string& mark, double error) {
  for (Observation& o : t.survey.observations)
    if (o.to == mark && (set_up < 0 || o.set_up == set_up)) {
      o.target_height = (std::isnan(o.target_height) ? 0 : o.target_height) + error;
    }
}
double some(Random& random, double least, double most) {
  return (random.uniform() < 0.5 ? -1 : 1) * least * std::pow(most / least, random.uniform());
}
void distances(Trial& t, int set_up, double factor, double constant) {
  for (Observation& o : t.survey.observations)
    if (o.kind == slope_distance && (set_up < 0 || o.set_up == set_up)) o.value = factor * o.value + constant;
}

double from_horizon(double z) { return kPi / 2 - z; }
double reversed(double d) { return 2 * kPi - d; }
double degrees_as_gon(double a) { return 0.9 * a; }
double packed(double a) {
  const double degrees = a * 180 / kPi, d = std::floor(degrees), m = std::floor(60 * (degrees - d)),
               s = 3600 * (degrees - d - m / 60);
  return (d + m / 100 + s / 1e4) * kPi / 180;
}
Vector3d exchanged(const Vector3d& p) { return {p.y(), p.x(), p.z()}; }

struct Scenario {
  const char* name;
  const char* word;  ///< "": nothing is wrong
  void (*make)(Trial&);
};

const Scenario kScenarios[] = {
    {"nothing wrong, known points", "", [](Trial& t) { t.know(); }},
    {"nothing wrong, free", "", [](Trial&) {}},
    {"nothing wrong, on a map", "",
     [](Trial& t) { t.origin = kUtm, t.scale = kUtmScale, t.options.map = "utm:32", t.know(); }},
    {"zenith angles from the horizon", "counted from the horizon",
     [](Trial& t) { t.know(), t.change(zenith_angle, -1, from_horizon); }},
    {"those of one set-up", "counted from the horizon", [](Trial& t) { t.change(zenith_angle, 2, from_horizon); }},
    {"directions in degrees read as gon", "in degrees and were read as gon",
     [](Trial& t) { t.know(), t.change(direction, -1, degrees_as_gon); }},
    {"zenith angles in degrees read as gon", "in degrees and were read as gon",
     [](Trial& t) { t.change(zenith_angle, -1, degrees_as_gon); }},
    {"both, of one set-up", "in degrees and were read as gon",
     [](Trial& t) { t.know(), t.change(direction, 1, degrees_as_gon), t.change(zenith_angle, 1, degrees_as_gon); }},
    {"directions counter-clockwise, known points", "known points are exchanged",
     [](Trial& t) { t.know(), t.change(direction, -1, reversed); }},
    {"directions of one set-up counter-clockwise", "counter-clockwise",
     [](Trial& t) { t.change(direction, 3, reversed); }},
    {"D.MMSS read as degrees", "(D.MMSS)",
     [](Trial& t) { t.change(direction, -1, packed), t.change(zenith_angle, -1, packed); }},
    {"one name on two marks", "is the name of two marks",
     [](Trial& t) {
       std::erase_if(t.survey.observations, [](const Observation& o) {
         return (o.set_up >= 2 && o.to == "M20") || (o.set_up < 2 && o.to == "M8");
       });
       for (Observation& o : t.survey.observations)
         if (o.to == "M8") o.to = "M20";
     }},
    {"E and N of all known points exchanged", "known points are exchanged",
     [](Trial& t) { t.origin = kUtm, t.know([](int, const Vector3d& p) { return exchanged(p); }); }},
    {"of one known point", "E and N are exchanged",
     [](Trial& t) { t.origin = kUtm, t.know([](int k, const Vector3d& p) { return k == 1 ? exchanged(p) : p; }); }},
    {"of two known points", "E and N are exchanged",
     [](Trial& t) {
       t.origin = kUtm, t.know([](int k, const Vector3d& p) { return k == 1 || k == 3 ? exchanged(p) : p; });
     }},
    {"zone number before E of one known point", "the zone's number stands before E",
     [](Trial& t) {
       t.origin = kUtm,
       t.know([](int k, const Vector3d& p) { return k == 2 ? Vector3d(p + Vector3d(32e6, 0, 0)) : p; });
     }},
    {"known points in feet", "in feet",
     [](Trial& t) { t.know([](int, const Vector3d& p) { return Vector3d(p / 0.3048); }); }},
    {"ellipsoidal heights of two known points", "above the ellipsoid",
     [](Trial& t) { t.know([](int k, const Vector3d& p) { return k < 2 ? Vector3d(p + Vector3d(0, 0, 42.3)) : p; }); }},
    {"known points on a map, no map given", "look like UTM",
     [](Trial& t) { t.origin = kUtm, t.scale = kUtmScale, t.know(); }},
    {"target height of one sight, 20 mm to 1 m", "target height",
     [](Trial& t) { target_height(t, 1, "M8", some(t.random, 0.02, 1)); }},
    {"likewise, on a map", "target height",
     [](Trial& t) {
       t.origin = kUtm, t.scale = kUtmScale, t.options.map = "utm:32", t.know();
       target_height(t, 1, "M8", some(t.random, 0.02, 1));
     }},
    {"target height of a known point in all set-ups", "M7",
     [](Trial& t) { t.know(), target_height(t, -1, "M7", some(t.random, 0.03, 1)); }},
    {"prism constant of all set-ups, known points", "check the prism constant",
     [](Trial& t) { t.know(), distances(t, -1, 1, some(t.random, 0.0175, 0.0344)); }},
    {"prism constant of all set-ups, on a map", "check the prism constant",
     [](Trial& t) {
       t.origin = kUtm, t.scale = kUtmScale, t.options.map = "utm:32", t.know();
       distances(t, -1, 1, some(t.random, 0.0175, 0.0344));
     }},
    {"prism constant of one set-up, on a map", "check the prism constant",
     [](Trial& t) {
       t.origin = kUtm, t.scale = kUtmScale, t.options.map = "utm:32", t.know();
       distances(t, 2, 1, some(t.random, 0.0175, 0.0344));
     }},
    {"all distances in feet, known points", "feet", [](Trial& t) { t.know(), distances(t, -1, 1 / 0.3048, 0); }},
    {"distances of one set-up in feet, on a map", "feet",
     [](Trial& t) {
       t.origin = kUtm, t.scale = kUtmScale, t.options.map = "utm:32", t.know();
       distances(t, 2, 1 / 0.3048, 0);
     }},
    {"all distances in feet, free", "", [](Trial& t) { distances(t, -1, 1 / 0.3048, 0); }},
    {"ppm setting 100 to 900 off, known points", "ppm setting",
     [](Trial& t) { t.know(), distances(t, -1, 1 + 1e-6 * some(t.random, 100, 900), 0); }},
    {"another zone of the map given", "",
     [](Trial& t) { t.origin = kUtm, t.scale = kUtmScale, t.options.map = "utm:33", t.know(); }},
    {"distances reduced to the map twice", "reduced to the map already",
     [](Trial& t) { t.origin = kUtm, t.options.map = "utm:32", t.know(); }},
    {"one known point on a map, no map given", "look like those of a map",
     [](Trial& t) {
       t.origin = kUtm, t.scale = kUtmScale, t.know();
       t.survey.coordinates.resize(1);
       t.survey.set_ups[0].stated_orientation = t.layout.set_ups[0].orientation;
       for (Point& p : t.survey.points)
         if (p.id != "M1") p.coordinates.setConstant(kNotGiven);
     }},
};

bool is_true(const NetworkResult& r, const Trial& t) {
  for (const SimulatedPoint& p : t.layout.points) {
    const auto at = std::find_if(r.points.begin(), r.points.end(), [&](const auto& q) { return q.id == p.id; });
    if (p.id[0] != 'M' || at == r.points.end()) continue;
    const Vector3d error = at->position - t.on_map(p.position), sigma = r.sigma(*at);
    for (int k = 0; k < 3; ++k)
      if (!(std::abs(error[k]) <= 5 * sigma[k] + 5e-4)) return false;
  }
  return true;
}

struct Tally {
  int named = 0, other = 0, silent = 0, sound = 0;
};

void run_trial(const Scenario& scenario, std::uint64_t seed, Tally& tally) {
  Trial t(seed);
  scenario.make(t);
  std::string said;
  bool alarm = false, correct = true;
  try {
    const NetworkResult r = adjust_network(t.survey, t.options);
    for (const Finding& f : r.findings)
      if (f.severity != Finding::Severity::note) said += f.text + "\n";
    alarm = r.validity != Validity::sound || said.find("probably: ") != std::string::npos;
    correct = t.survey.coordinates.empty() || is_true(r, t);
  } catch (const NetworkError& error) {
    said = error.what();
    alarm = true;
  }
  const bool named = *scenario.word && said.find(scenario.word) != std::string::npos;
  tally.named += named;
  tally.other += !named && alarm;
  tally.silent += !named && !alarm && (*scenario.word || !correct);
  tally.sound += !alarm && correct;
  if (std::getenv("PLUMBLINE_SHOW") && (*scenario.word ? !named : alarm))
    std::printf("  %s, seed %llu: %s\n", scenario.name, static_cast<unsigned long long>(seed),
                said.substr(0, 700).c_str());
}

}  // namespace

int main(int argc, char** argv) {
  const int trials = argc > 1 ? std::max(1, std::atoi(argv[1])) : 100;
  const std::string only = argc > 2 ? argv[2] : "";
  const std::uint64_t first = argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 1;
  std::printf(
      "| %d trials each, seeds from %llu | named | another word | silent | sound and true |\n|---|---|---|---|---|\n",
      trials, static_cast<unsigned long long>(first));
  for (const Scenario& scenario : kScenarios) {
    if (std::string(scenario.name).find(only) == std::string::npos) continue;
    Tally tally;
    for (int trial = 0; trial < trials; ++trial) run_trial(scenario, first + static_cast<std::uint64_t>(trial), tally);
    const auto share = [&](int n) { return 100.0 * n / trials; };
    std::printf("| %s | %.0f %% | %.0f %% | %.0f %% | %.0f %% |\n", scenario.name, share(tally.named),
                share(tally.other), share(tally.silent), share(tally.sound));
    std::fflush(stdout);
  }
  return 0;
}
