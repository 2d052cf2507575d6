// What searches, diagnoses and plans give for networks made at random; see record.hpp.
#include <cmath>

#include "random_network.hpp"
#include "record.hpp"
#include "survey/adjust/adjust_network.hpp"
#include "survey/epochs/check_control.hpp"
#include "survey/plan/plan_survey.hpp"
#include "survey/simulate/simulate_survey.hpp"
#include "survey/start/approximate.hpp"
#include "survey/start/approximate_figure.hpp"
#include "survey/start/set_up_chain.hpp"
#include "test_support.hpp"

namespace plumbline::survey {
namespace test_records {

using plumbline::test::digits;
using plumbline::test::expect_recorded;
using test::NetworkKind;
using test::RandomNetwork;

AdjustOptions plain() {
  AdjustOptions options;
  options.curvature = Switch::off;
  return options;
}

/// How far the approximate coordinates are from the truth, once moved and lifted onto it where nothing is held.
std::string distance_from_truth(const RandomNetwork& network, const std::map<std::string, Eigen::Vector3d>& points,
                                bool held) {
  std::vector<Eigen::Vector2d> from, to;
  double lift = 0, plan = 0, height = 0;
  int heights = 0, placed = 0;
  for (size_t i = 0; i < network.truth.size(); ++i) {
    const auto at = points.find(network.survey.points[i].id);
    if (at == points.end()) continue;
    ++placed;
    if (!at->second.head<2>().hasNaN()) {
      from.push_back(at->second.head<2>());
      to.push_back(network.truth[i].head<2>());
    }
    if (std::isnan(at->second.z())) continue;
    lift += network.truth[i].z() - at->second.z();
    ++heights;
  }
  PlaneMotion motion;
  if (const auto fit = fit_plane(from, to); fit && !held) motion = *fit;
  lift = held || heights == 0 ? 0 : lift / heights;
  for (size_t k = 0; k < from.size(); ++k) plan = std::max(plan, (motion(from[k]) - to[k]).norm());
  for (size_t i = 0; i < network.truth.size(); ++i)
    if (const auto at = points.find(network.survey.points[i].id); at != points.end() && !std::isnan(at->second.z()))
      height = std::max(height, std::abs(at->second.z() + lift - network.truth[i].z()));
  return std::to_string(placed) + " points, plan " + digits(plan) + ", height " + digits(height);
}

TEST(Records, ApproximateCoordinates) {
  std::string text;
  for (const NetworkKind kind : test::kNetworkKinds)
    for (std::uint64_t seed = 100; seed < 112; ++seed) {
      const RandomNetwork network(kind, seed);
      const SurveyObservations survey = network.without_coordinates();
      std::map<std::string, Eigen::Vector3d> known;
      for (const Point& p : survey.points)
        if (!p.coordinates.array().isNaN().all()) known[p.id] = p.coordinates;
      const auto observations = mean_observations(survey).observations;
      text += std::string(test::kNetworkKindNames[static_cast<int>(kind)]) + " " + std::to_string(seed) + ":";
      for (const Approximation& a : approximate_coordinates(survey, observations, known)) {
        double turn = 0;
        for (const double orientation : a.orientations)
          if (!std::isnan(orientation)) turn += std::cos(orientation);
        text += " " + distance_from_truth(network, a.points, !known.empty()) + ", turn " + digits(turn) + ";";
      }
      const SetUpChain chain(survey, observations, {});
      if (const auto start = start_from_chain(chain, survey.set_ups.size(), known))
        text += " chain " + distance_from_truth(network, start->points, !known.empty());
      text += "\n";
    }
  expect_recorded("unit/survey/records/starts.txt", text);
}

std::string told(const NetworkResult& r) {
  std::string text = "  " + r.verdict + "\n  sigma0 " + digits(r.sigma0) + ", redundancy " +
                     std::to_string(r.degrees_of_freedom) + ", defect " + std::to_string(r.defect) + ", left out " +
                     std::to_string(r.left_out.size()) + "\n";
  double effect = 0, mdb = 0, trace = 0;
  for (const ResultRow& row : r.rows) {
    if (row.removed) text += "  removed " + row.kind + " " + row.from + " " + row.to + " " + digits(row.statistics.w);
    if (std::isfinite(row.statistics.mdb)) {
      mdb += row.statistics.mdb, effect += row.statistics.external_effect;
      trace += row.statistics.bias_to_noise + row.statistics.sigma_adjusted;
    }
  }
  text += "  mdb " + digits(mdb) + ", effect " + digits(effect) + ", bias " + digits(trace) + "\n";
  for (const SnoopingAction& a : r.snooping)
    text += "  " + std::string(a.restored ? "restored " : "taken out ") + std::to_string(a.row) + " " + digits(a.w) +
            " " + digits(a.estimated_blunder) + "\n";
  double orientation = 0, pointings = 0, errors = 0;
  for (const ResultSetUp& u : r.set_ups) {
    if (!std::isnan(u.orientation)) orientation += std::cos(u.orientation) + 1e3 * u.orientation_sigma;
    for (const CommonEstimate& e : {u.index, u.constant, u.scale})
      if (!std::isnan(e.value)) errors += 1e3 * (e.value + e.sigma);
  }
  size_t k = 0;
  for (const ResultPointing& p : r.pointings)
    pointings += p.test.statistic * static_cast<double>(1 + k++ % 7) * static_cast<double>((p.set_up + p.to).size()) +
                 p.flagged + p.critical;
  text += "  orientations " + digits(orientation) + ", errors " + digits(errors) + ", " +
          std::to_string(r.pointings.size()) + " pointings " + digits(pointings) + ", " + std::to_string(r.unknowns) +
          " unknowns\n";
  for (const Finding& f : r.findings) {
    text += "  " + f.text + " [";
    for (const std::string& id : f.points) text += id + " ";
    text += "]\n";
  }
  return text;
}

std::string answer(const SurveyObservations& survey, const AdjustOptions& options) {
  try {
    return told(adjust_network(survey, options));
  } catch (const NetworkError& error) {
    std::string text = "  refused: " + std::string(error.what()) + "\n";
    for (const std::string& id : error.undetermined) text += "  " + id;
    return text + "\n";
  }
}

TEST(Records, NetworksThatAreThinnedOutOrWrong) {
  std::string text;
  AdjustOptions mending = plain();
  mending.remove_blunders = true;
  for (const NetworkKind kind : test::kNetworkKinds)
    for (std::uint64_t seed = 200; seed < 206; ++seed) {
      const RandomNetwork network(kind, seed);
      text += std::string(test::kNetworkKindNames[static_cast<int>(kind)]) + " " + std::to_string(seed) + "\n";
      SurveyObservations thin = network.survey;
      size_t k = 0;
      std::erase_if(thin.observations, [&](const Observation&) { return (k++ * 7 + seed) % 3 == 0; });
      text += answer(thin, plain());
      SurveyObservations wrong = network.survey;
      if (wrong.observations.empty()) continue;
      for (const size_t one : {wrong.observations.size() / 3, wrong.observations.size() - 1}) {
        Observation& o = wrong.observations[one];
        o.value += 30 * (std::isnan(o.sigma) ? 0.001 : o.sigma);
      }
      text += answer(wrong, mending);
    }
  expect_recorded("unit/survey/records/networks.txt", text);
}

/// Wrong readings stayed, as without them a height or another reading was not controlled, and sound ones went in their
/// place. Of free stations 205 nobody knows which it is: two zenith angles control each other alone.
TEST(Records, NoSoundReadingGoesInPlaceOfAWrongOne) {
  AdjustOptions mending = plain();
  mending.remove_blunders = true;
  for (const auto& [kind, seed] : std::initializer_list<std::pair<NetworkKind, std::uint64_t>>{
           {NetworkKind::free_stations, 200}, {NetworkKind::mixed, 204}}) {
    SurveyObservations wrong = RandomNetwork(kind, seed).survey;
    std::set<std::string> planted;
    for (const std::size_t one : {wrong.observations.size() / 3, wrong.observations.size() - 1}) {
      Observation& o = wrong.observations[one];
      o.value += 30 * (std::isnan(o.sigma) ? 0.001 : o.sigma);
      planted.insert(o.from + " " + o.to);
    }
    const NetworkResult r = adjust_network(wrong, mending);
    EXPECT_EQ(r.errors_taken_off, 0) << seed;
    for (const ResultRow& row : r.rows)
      EXPECT_TRUE(!row.removed || planted.contains(row.from + " " + row.to))
          << seed << " " << row.kind << " " << row.from << " " << row.to << " out, wrong were " << *planted.begin()
          << ", " << *planted.rbegin();
  }
}

/// Of two zenith angles that control each other alone the sound one went, and the network was "sound" with a mark 9 mm
/// off.
TEST(Records, WhereTwoReadingsControlEachOtherAloneBothAreNamed) {
  AdjustOptions mending = plain();
  mending.remove_blunders = true;
  SurveyObservations wrong = RandomNetwork(NetworkKind::free_stations, 205).survey;
  const Observation& planted = wrong.observations.back();
  for (const std::size_t one : {wrong.observations.size() / 3, wrong.observations.size() - 1}) {
    Observation& o = wrong.observations[one];
    o.value += 30 * (std::isnan(o.sigma) ? 0.001 : o.sigma);
  }
  const NetworkResult r = adjust_network(wrong, mending);
  EXPECT_EQ(r.validity, Validity::doubtful) << r.verdict;
  EXPECT_EQ(r.verdict.find("doubtful: 1 of 2 readings is wrong, and nothing tells which"), 0u) << r.verdict;
  EXPECT_NE(r.verdict.find(planted.from + " -> " + planted.to), std::string::npos) << r.verdict;
  const auto either = std::find_if(r.findings.begin(), r.findings.end(),
                                   [](const Finding& f) { return f.subject == Finding::Subject::either; });
  ASSERT_NE(either, r.findings.end());
  EXPECT_EQ(either->points, std::vector<std::string>{planted.to});
}

TEST(Records, MistakesOfTheField) {
  using Kind = SurveyMistake::Kind;
  const SurveyLayout layout = facade_layout(24, 3, 11);
  AdjustOptions options;
  options.profile = built_in_profile("total_station_2arcsec");
  options.datum = DatumMode::inner;
  options.remove_blunders = true;
  SimulationOptions simulation;
  simulation.profile = options.profile;
  std::string text;
  for (const auto& [kind, size] : std::initializer_list<std::pair<Kind, double>>{{Kind::reading, 0.02},
                                                                                 {Kind::swapped_names, 0},
                                                                                 {Kind::turned_circle, 0.01},
                                                                                 {Kind::prism, 0.0344},
                                                                                 {Kind::scale, 3e-4},
                                                                                 {Kind::instrument_height, 0.1},
                                                                                 {Kind::unit, 0.3048},
                                                                                 {Kind::moved_instrument, 0.4}}) {
    SurveyObservations survey = simulate_survey(layout, simulation, 12);
    SurveyMistake m;
    m.kind = kind, m.set_up = 1, m.size = size, m.observation = 40, m.from_sight = 9;
    if (kind == Kind::swapped_names) m.first = survey.observations[60].to, m.second = survey.observations[90].to;
    text += "mistake " + std::to_string(static_cast<int>(kind));
    double checksum = 0;
    for (const int n : plant(m, layout, survey)) text += " " + std::to_string(n);
    for (size_t i = 0; i < survey.observations.size(); ++i)
      checksum += survey.observations[i].value * static_cast<double>(i % 17 + 1);
    text += " checksum " + digits(checksum) + "\n" + answer(survey, options);
    options.remove_blunders = !options.remove_blunders;
    text += answer(survey, options);
    options.remove_blunders = true;
  }
  expect_recorded("unit/survey/records/mistakes.txt", text);
}

TEST(Records, Epochs) {
  const auto of = [](std::uint64_t seed) {
    test::SimulationSettings settings;
    settings.rows = 2;
    return epoch_of(adjust_network(test::simulate(settings, seed).survey, plain()));
  };
  const Epoch first = of(301);
  std::string text;
  for (const int motions : {4, 5, 6, 7}) {
    Epoch second = of(302);
    second.coordinates.segment<3>(6) += Eigen::Vector3d(0.004, 0, -0.003);
    second.coordinates.segment<3>(12) += Eigen::Vector3d(0, 0.01, 0);
    ComparisonOptions options;
    options.free_motions = motions;
    const Comparison c = compare_epochs(first, second, options);
    text += std::to_string(motions) + " motions: " + digits(c.statistic) + " of " + digits(c.critical) + ", rank " +
            std::to_string(c.rank) + "\n";
    for (const Exclusion& e : c.excluded) {
      text += "  without " + e.id + " " + digits(e.statistic) + " of " + digits(e.critical) + ", else";
      for (const std::string& id : e.alternatives) text += " " + id;
      text += "\n";
    }
    for (const Movement& m : c.movements)
      text += "  " + m.id + (m.moved ? " moved " : " ") + (m.stable ? "datum " : "") + digits(m.movement.x()) + " " +
              digits(m.movement.y()) + " " + digits(m.movement.z()) + ", sigma " + digits(m.sigma.x()) + " " +
              digits(m.sigma.z()) + ", " + digits(m.statistic) + " of " + digits(m.critical) + ", height " +
              digits(m.detectable_height) + "\n";
  }
  expect_recorded("unit/survey/records/epochs.txt", text);
}

TEST(Records, ControlThatDoesNotFit) {
  test::SimulationSettings settings;
  settings.rows = 2, settings.coordinates = false;
  const auto n = test::simulate(settings, 401);
  std::string text;
  for (int what = 0; what < 8; ++what) {
    ControlPoints control;
    for (size_t i = 0; i < 6; ++i) control.ids.push_back(n.survey.points[i].id);
    control.coordinates.resize(18);
    for (Eigen::Index i = 0; i < 6; ++i) {
      Eigen::Vector3d p =
          n.truth[i] + Eigen::Vector3d(0, 3.0 * static_cast<double>(i % 2) - static_cast<double>(i), 0) * (what == 7);
      if (what == 1) p *= 3.28084;
      if (what == 2) p *= 0.3048;
      if (what == 3) p *= 1000;
      if (what == 4) std::swap(p.x(), p.y());
      if (what == 5 && i == 2) p.x() += 0.03;
      if (what == 6 && i > 1) p.head<2>().setConstant(std::nan(""));
      control.coordinates.segment<3>(3 * i) = p;
    }
    const ControlCheck c = check_control(n.survey, control, plain(), {});
    text += std::to_string(what) + ": " + c.problem + c.cause + " " + std::to_string(c.free_motions) + " motions, " +
            digits(c.comparison.statistic) + " of " + digits(c.comparison.critical);
    for (const Exclusion& e : c.comparison.excluded) text += ", without " + e.id;
    text += "\n";
  }
  expect_recorded("unit/survey/records/control.txt", text);
}

std::string told(const PlanResult& r) {
  std::string text;
  for (const PlannedRule& rule : r.rules) {
    text += "  " + rule.name + (rule.holds ? " holds: " : " fails: ") + rule.text + " [";
    for (const std::string& id : rule.points) text += id + " ";
    text += "]\n";
  }
  for (const PlanRemedy& remedy : r.remedies) {
    text += "  " + remedy.rule + ": " + remedy.text + ", " + std::to_string(remedy.sightings) + " [";
    for (const PlannedSight& s : remedy.added)
      text += s.set_up + "-" + s.marker + " " + digits(s.length) + " " + digits(s.incidence) + " ";
    text += "]\n";
  }
  double length = 0, incidence = 0;
  for (const PlannedSight& s : r.sights) length += s.length, incidence += s.incidence;
  text += "  " + std::to_string(r.sights.size()) + " sights " + digits(length) + " m, " + digits(incidence) + "\n";
  for (const PlannedTransfer& t : r.transfers)
    text += "  " + std::to_string(t.from_floor) + "-" + std::to_string(t.to_floor) + "/" + std::to_string(t.column) +
            " " + digits(t.sigma) + "\n";
  for (const PlannedDrift& d : r.drifts) text += "  D(" + std::to_string(d.floor) + ") " + digits(d.sigma) + "\n";
  return text;
}

TEST(Records, Plans) {
  std::vector<PlannedMarker> markers;
  for (int f = 1; f <= 3; ++f)
    for (int c = 1; c <= 4; ++c)
      for (int r = 0; r < 2; ++r)
        markers.push_back({"A" + std::to_string(f) + std::to_string(c) + std::to_string(r),
                           {2.0 * c, 0.1 * (c % 2), 4.0 * (f - 1) + 1 + 2.0 * r},
                           {0, -1, 0},
                           f,
                           c});
  std::vector<std::string> low, middle, high;
  for (const PlannedMarker& m : markers) (m.floor == 1 ? low : m.floor == 2 ? middle : high).push_back(m.id);
  PlanOptions options;
  options.profile = built_in_profile("total_station_5arcsec");
  std::string text =
      "two on the ground\n" + told(plan_survey(markers, {{"S1", {0, -15, 1.6}}, {"S2", {9, -16, 1.6}}}, options));
  text += "one\n" + told(plan_survey(markers, {{"S1", {5, -12, 1.6}}}, options));
  text +=
      "floors apart\n" +
      told(plan_survey(
          markers, {{"S1", {0, -12, 1.6}, low}, {"S2", {9, -13, 5.6}, middle}, {"S3", {3, -14, 9.6}, high}}, options));
  auto shared = low;
  shared.insert(shared.end(), {"A210", "A240"});
  auto upper = middle;
  upper.insert(upper.end(), {"A110", "A140", "A311"});
  options.tolerance = 0.001;
  text += "weak joint\n" + told(plan_survey(markers,
                                            {{"S1", {0, -12, 1.6}, shared},
                                             {"S2", {9, -13, 5.6}, upper},
                                             {"S3", {3, -14, 9.6}, high},
                                             {"S4", {11, -9, 9.6}, high}},
                                            options));
  for (PlannedMarker& m : markers) m.normal.setConstant(std::nan(""));
  markers[5].position.x() += 2.7;
  text += "no normals\n" + told(plan_survey(markers, {{"S1", {-6, -8, 1.6}}, {"S2", {30, -40, 1.6}}}, options));
  expect_recorded("unit/survey/records/plans.txt", text);
}

}  // namespace test_records
}  // namespace plumbline::survey
