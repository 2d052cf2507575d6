// How often a mistake of the field is named and mended: 40 markers, 4 set-ups, one mistake planted in each trial,
// adjusted with remove_blunders. Prints a Markdown table.
//   survey_mistakes_benchmark [TRIALS [SCENARIO [FIRST_SEED]]]      SCENARIO: part of a name, "" for all
// clean: the verdict is "sound" and every marker lies within 5 of its standard deviations (plus 0.2 mm) of the truth
// (of where it was before or after, if it was reset between two set-ups). named: a finding says what was wrong, and
// where; a network that is refused with these words has named it, too. silently wrong: "sound", and a marker does not
// lie there. innocent: a reading was taken out in which nothing was wrong.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "geometry/random.hpp"
#include "survey/adjust/adjust_network.hpp"
#include "survey/simulate/simulate_survey.hpp"

namespace {

using namespace plumbline;
using namespace plumbline::survey;
using Kind = SurveyMistake::Kind;

constexpr double kGon = std::numbers::pi / 200;

struct Trial {
  SurveyLayout layout;
  SurveyObservations survey;
  std::set<int> wrong;                           // lines
  std::vector<std::string> words;                // one of which the findings must have
  std::map<std::string, Eigen::Vector3d> later;  // places of targets that were reset [m]
};

double sign(Random& random) { return random.uniform() < 0.5 ? -1 : 1; }
/// Between two sizes, each decade as often.
double size(Random& random, double least, double most) {
  return least * std::pow(most / least, random.uniform()) * sign(random);
}

void plant(Trial& t, const SurveyMistake& mistake) {
  for (const int i : survey::plant(mistake, t.layout, t.survey)) t.wrong.insert(i + 1);
}

void gross_reading(Trial& t, Random& random) {
  SurveyMistake m;
  m.observation = static_cast<int>(random.uniform() * static_cast<double>(t.survey.observations.size()));
  const Observation& o = t.survey.observations[m.observation];
  m.size = o.kind == ObservationKind::slope_distance ? size(random, 0.02, 5) : size(random, 0.05 * kGon, 20 * kGon);
  m.set_up = o.set_up;
  t.words.push_back(t.survey.set_ups[o.set_up].station + " -> " + o.to);
  plant(t, m);
}

/// Two markers that a set-up sees, near each other or far.
void swapped(Trial& t, Random& random, bool near) {
  SurveyMistake m;
  m.kind = Kind::swapped_names;
  m.set_up = static_cast<int>(random.uniform() * 4);
  std::vector<const SimulatedPoint*> seen;
  const auto& sees = t.layout.set_ups[m.set_up].sees;
  for (const SimulatedPoint& p : t.layout.points)
    if (p.id[0] == 'M' && std::find(sees.begin(), sees.end(), p.id) != sees.end()) seen.push_back(&p);
  for (;;) {
    const auto pick = [&] { return seen[static_cast<size_t>(random.uniform() * static_cast<double>(seen.size()))]; };
    const SimulatedPoint *a = pick(), *b = pick();
    const double apart = (a->position - b->position).norm();
    if (a == b || near != (apart < 3.5) || (!near && apart < 8)) continue;
    m.first = a->id, m.second = b->id;
    break;
  }
  t.words = {m.first + " and " + m.second, m.second + " and " + m.first};
  plant(t, m);
}

void of_set_up(Trial& t, Random& random, Kind kind) {
  SurveyMistake m;
  m.kind = kind;
  m.set_up = static_cast<int>(random.uniform() * 4);
  const std::string set_up = "set-up S" + std::to_string(m.set_up + 1);
  const auto sights = t.layout.set_ups[m.set_up].sees.size();
  if (kind == Kind::turned_circle) {
    m.size = size(random, 0.02 * kGon, 100 * kGon);
    m.from_sight = 5 + static_cast<int>(random.uniform() * (static_cast<double>(sights) - 10));
    t.words = {set_up + " looks turned", set_up + ": the circle was turned"};
  } else if (kind == Kind::prism) {
    const double sizes[] = {0.0344, 0.0231, 0.0175};
    m.size = sizes[static_cast<size_t>(random.uniform() * 3)] * sign(random);
    t.words = {"distances of " + set_up + " look too"};
  } else if (kind == Kind::instrument_height) {
    m.size = size(random, 0.02, 1);
    t.words = {"instrument height of " + set_up};
  } else if (kind == Kind::unit) {
    m.size = 0.3048;
    t.words = {"distances of " + set_up + " are 3.2808 times"};
  } else {
    m.size = size(random, 0.05, 0.5);
    m.from_sight = 8 + static_cast<int>(random.uniform() * (static_cast<double>(sights) - 16));
    t.words = {set_up + ": the instrument stood elsewhere"};
  }
  plant(t, m);
}

/// Every target twice, and the tripod knocked between the two rounds.
void knocked_between_rounds(Trial& t, Random& random) {
  SurveyMistake m;
  m.kind = Kind::moved_instrument;
  m.set_up = static_cast<int>(random.uniform() * 2);
  m.from_sight = static_cast<int>(t.layout.set_ups[m.set_up].sees.size() / 2);
  m.size = size(random, 0.02, 0.5);
  t.words = {"set-up S" + std::to_string(m.set_up + 1)};
  plant(t, m);
}

/// Three targets were reset between the second and the third set-up.
void moved_targets(Trial& t, Random& random) {
  SurveyLayout after = t.layout;
  for (int k = 0; k < 3; ++k) {
    SimulatedPoint& p = after.points[static_cast<size_t>(random.uniform() * 40)];
    p.position += Eigen::Vector3d(size(random, 0.01, 0.2), 0, size(random, 0.01, 0.2));
    t.words.push_back(p.id);
    t.later[p.id] = p.position;
  }
  SimulationOptions exact;
  exact.profile = built_in_profile("total_station_2arcsec"), exact.noise = 0;
  const SurveyObservations before = simulate_survey(t.layout, exact, 1), moved = simulate_survey(after, exact, 1);
  for (size_t i = 0; i < t.survey.observations.size(); ++i) {
    if (t.survey.observations[i].set_up < 2) continue;
    const double by = moved.observations[i].value - before.observations[i].value;
    if (by != 0) t.survey.observations[i].value += by, t.wrong.insert(static_cast<int>(i) + 1);
  }
}

/// A pole of 1.5 m that a set-up has in feet, on the first dozen of its targets.
void pole_in_feet(Trial& t, Random& random) {
  const int set_up = static_cast<int>(random.uniform() * 4);
  SurveyLayout on_pole = t.layout;
  std::set<std::string> targets;
  for (const std::string& id : t.layout.set_ups[set_up].sees)
    if (id[0] == 'M' && targets.size() < 12) targets.insert(id);
  for (SimulatedPoint& p : on_pole.points)
    if (targets.contains(p.id)) p.position.z() += 1.5;
  SimulationOptions exact;
  exact.profile = built_in_profile("total_station_2arcsec"), exact.noise = 0;
  const SurveyObservations plain = simulate_survey(t.layout, exact, 1), raised = simulate_survey(on_pole, exact, 1);
  for (size_t i = 0; i < t.survey.observations.size(); ++i) {
    Observation& o = t.survey.observations[i];
    if (o.set_up != set_up || !targets.contains(o.to)) continue;
    o.value += raised.observations[i].value - plain.observations[i].value;
    o.target_height = 1.5 / 0.3048;
    t.wrong.insert(static_cast<int>(i) + 1);
  }
  t.words = {"target height of 4.921 m noted"};
}

struct Scenario {
  const char* name;
  void (*make)(Trial&, Random&);
  bool two_rounds = false;  // of two set-ups; readings without standard deviations, as they come from an instrument
};

const Scenario kScenarios[] = {
    {"nothing wrong", [](Trial&, Random&) {}},
    {"one gross reading", [](Trial& t, Random& r) { gross_reading(t, r); }},
    {"three gross readings",
     [](Trial& t, Random& r) {
       for (int k = 0; k < 3; ++k) gross_reading(t, r);
     }},
    {"names swapped, neighbours", [](Trial& t, Random& r) { swapped(t, r, true); }},
    {"names swapped, far apart", [](Trial& t, Random& r) { swapped(t, r, false); }},
    {"circle turned within a set-up", [](Trial& t, Random& r) { of_set_up(t, r, Kind::turned_circle); }},
    {"wrong prism in a set-up", [](Trial& t, Random& r) { of_set_up(t, r, Kind::prism); }},
    {"wrong instrument height", [](Trial& t, Random& r) { of_set_up(t, r, Kind::instrument_height); }},
    {"a set-up in feet", [](Trial& t, Random& r) { of_set_up(t, r, Kind::unit); }},
    {"instrument moved within a set-up", [](Trial& t, Random& r) { of_set_up(t, r, Kind::moved_instrument); }},
    {"nothing wrong, two set-ups of two rounds", [](Trial&, Random&) {}, true},
    {"instrument knocked between two rounds", knocked_between_rounds, true},
    {"targets moved between set-ups", moved_targets},
    {"a pole in feet", pole_in_feet},
};

struct TrueMarker {
  const ResultPoint* found;
  std::vector<Eigen::Vector3d> places;  // where it was; two, of a target that was reset
};

/// The markers that some set-up sees; none if one of them has no coordinates.
std::vector<TrueMarker> seen_markers(const NetworkResult& r, const Trial& t) {
  std::vector<TrueMarker> markers;
  for (const SimulatedPoint& p : t.layout.points) {
    if (p.id[0] != 'M') continue;
    if (std::none_of(t.layout.set_ups.begin(), t.layout.set_ups.end(), [&](const SimulatedSetUp& s) {
          return std::find(s.sees.begin(), s.sees.end(), p.id) != s.sees.end();
        }))
      continue;
    const auto at = std::find_if(r.points.begin(), r.points.end(), [&](const auto& q) { return q.id == p.id; });
    if (at == r.points.end()) return {};
    markers.push_back({&*at, {p.position}});
    if (const auto later = t.later.find(p.id); later != t.later.end()) markers.back().places.push_back(later->second);
  }
  return markers;
}

/// Markers within 5 sigma of the truth, after turn and shift of the free network onto those that stayed. A target that
/// was reset is true at either of its places, and wrong between them.
bool is_true(const NetworkResult& r, const Trial& t) {
  const std::vector<TrueMarker> markers = seen_markers(r, t);
  if (markers.empty()) return false;
  Eigen::Vector3d from = Eigen::Vector3d::Zero(), to = from;
  double stayed = 0, sine = 0, cosine = 0;
  for (const TrueMarker& m : markers)
    if (m.places.size() == 1) from += m.found->position, to += m.places[0], ++stayed;
  from /= stayed, to /= stayed;
  for (const TrueMarker& m : markers) {
    if (m.places.size() > 1) continue;
    const Eigen::Vector3d a = m.found->position - from, b = m.places[0] - to;
    cosine += a.x() * b.x() + a.y() * b.y(), sine += a.x() * b.y() - a.y() * b.x();
  }
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(std::atan2(sine, cosine), Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return std::all_of(markers.begin(), markers.end(), [&](const TrueMarker& m) {
    const Eigen::Vector3d sigma = turn.cwiseAbs() * r.sigma(*m.found);
    return std::any_of(m.places.begin(), m.places.end(), [&](const Eigen::Vector3d& place) {
      const Eigen::Vector3d error = turn * (m.found->position - from) + to - place;
      return (error.array().abs() <= 5 * sigma.array() + 2e-4).all();
    });
  });
}

bool is_diagnosis(const Finding& f) {
  for (const char* word : {"looks", "look too", "look wrong", "set-up S"})
    if (f.severity != Finding::Severity::note && f.text.find(word) != std::string::npos) return true;
  return false;
}

struct Tally {
  int clean = 0, named = 0, innocent = 0, diagnosed = 0, silent = 0, failed = 0;
};

void run_trial(const Scenario& scenario, std::uint64_t seed, Tally& tally) {
  Random random(seed, scenario.name);
  Trial t;
  t.layout = facade_layout(40, scenario.two_rounds ? 2 : 4, seed);
  SimulationOptions simulation;
  simulation.profile = built_in_profile("total_station_2arcsec");
  simulation.sigmas = !scenario.two_rounds;
  if (scenario.two_rounds)
    for (SimulatedSetUp& s : t.layout.set_ups) {
      const std::vector<std::string> once = s.sees;
      s.sees.insert(s.sees.end(), once.begin(), once.end());
    }
  t.survey = simulate_survey(t.layout, simulation, seed);
  scenario.make(t, random);
  AdjustOptions options;
  options.profile = simulation.profile;
  options.datum = DatumMode::inner;
  options.remove_blunders = true;
  try {
    const NetworkResult r = adjust_network(t.survey, options);
    const bool clean = r.validity == Validity::sound && is_true(r, t);
    bool innocent = false, diagnosed = false;
    int named = 0;
    for (const ResultRow& row : r.rows) innocent |= row.removed && !t.wrong.contains(row.source.line);
    for (const Finding& f : r.findings) diagnosed |= is_diagnosis(f);
    for (const std::string& word : t.words)
      named += std::any_of(r.findings.begin(), r.findings.end(),
                           [&](const Finding& f) { return f.text.find(word) != std::string::npos; });
    // "Sound" with a mark that is not where it is said to be.
    tally.silent += r.validity == Validity::sound && !is_true(r, t);
    tally.clean += clean, tally.innocent += innocent, tally.diagnosed += diagnosed, tally.named += named > 0;
    if (std::getenv("PLUMBLINE_SHOW") && (!clean || innocent || (t.words.empty() && diagnosed))) {
      std::printf("  %s, seed %lu: %s%s\n", scenario.name, static_cast<unsigned long>(seed), r.verdict.c_str(),
                  innocent ? ", innocent readings removed" : "");
      for (const Finding& f : r.findings)
        if (f.severity != Finding::Severity::note) std::printf("    %s\n", f.text.substr(0, 200).c_str());
    }
  } catch (const NetworkError& error) {
    ++tally.failed;
    tally.named += std::any_of(t.words.begin(), t.words.end(), [&](const std::string& word) {
      return std::string(error.what()).find(word) != std::string::npos;
    });
    if (std::getenv("PLUMBLINE_SHOW"))
      std::printf("  %s, seed %lu: %s\n", scenario.name, static_cast<unsigned long>(seed), error.what());
  }
}

}  // namespace

int main(int argc, char** argv) {
  const int trials = argc > 1 ? std::max(1, std::atoi(argv[1])) : 200;
  const std::string only = argc > 2 ? argv[2] : "";
  const std::uint64_t first = argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 1;
  std::printf(
      "| %d trials each, seeds from %llu | ends clean | named | innocent readings removed | silently wrong | refused "
      "|\n"
      "|---|---|---|---|---|---|\n",
      trials, static_cast<unsigned long long>(first));
  for (const Scenario& scenario : kScenarios) {
    if (std::string(scenario.name).find(only) == std::string::npos) continue;
    Tally tally;
    for (int trial = 0; trial < trials; ++trial) run_trial(scenario, first + static_cast<std::uint64_t>(trial), tally);
    const bool is_sound = std::string(scenario.name).starts_with("nothing wrong");
    const auto share = [&](int n) { return 100.0 * n / trials; };
    std::printf("| %s | %.1f %% | %s%.1f %% | %.1f %% | %.1f %% | %d |\n", scenario.name, share(tally.clean),
                is_sound ? "false diagnosis " : "", share(is_sound ? tally.diagnosed : tally.named),
                share(tally.innocent), share(tally.silent), tally.failed);
    std::fflush(stdout);
  }
  return 0;
}
