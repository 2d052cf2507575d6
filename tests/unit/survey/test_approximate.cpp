// Networks without approximate coordinates: whatever can be determined is found, what has two solutions is refused.
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <map>
#include <numbers>

#include "random_network.hpp"
#include "survey/adjust/adjust_network.hpp"
#include "survey/files/gama.hpp"
#include "survey/start/approximate.hpp"
#include "survey/start/approximate_figure.hpp"
#include "test_support.hpp"

namespace plumbline::survey {
namespace test_approximate {

using test::NetworkKind;
using test::RandomNetwork;

AdjustOptions plain() {
  AdjustOptions options;
  options.curvature = Switch::off;
  return options;
}

std::string network(const std::string& content) {
  return "<gama-local><network axes-xy=\"en\"><parameters sigma-apr=\"1\" sigma-act=\"apriori\"/>"
         "<points-observations distance-stdev=\"5\" direction-stdev=\"10\" angle-stdev=\"10\" "
         "zenith-angle-stdev=\"10\">" +
         content + "</points-observations></network></gama-local>\n";
}

NetworkResult adjust(const std::string& content) {
  return adjust_network(read_gama_xml(network(content), "t.gkf"), plain());
}

std::string refusal(const std::string& content) {
  try {
    adjust(content);
  } catch (const NetworkError& error) {
    return error.what();
  }
  return "";
}

/// C and D north or south of AB: five distances cannot tell.
std::string quadrilateral(const std::string& c) {
  return "<point id='A' x='0' y='100' fix='xy'/><point id='B' x='100' y='100' fix='xy'/><point id='C' " + c +
         " adj='xy'/><point id='D' adj='xy'/><obs><distance from='A' to='C' val='100'/><distance from='A' to='D' "
         "val='141.421'/><distance from='B' to='C' val='141.421'/><distance from='B' to='D' val='100'/><distance "
         "from='C' to='D' val='100'/></obs>";
}

TEST(Approximate, TwoMirroredNetworksAreRefusedUntilOnePointDecides) {
  const std::string text = refusal(quadrilateral(""));
  for (const char* words : {"2 different networks equally well", "point C is at E", "N 0.00", "N 200.00",
                            "one of these as approximate coordinates of C,"})
    EXPECT_NE(text.find(words), std::string::npos) << words << " in: " << text;
  EXPECT_NEAR(adjust(quadrilateral("x='0.2' y='-0.3'")).point("D").position.y(), 0, 0.01);
  EXPECT_NEAR(adjust(quadrilateral("x='0.5' y='200.4'")).point("D").position.y(), 200, 0.01);
}

TEST(Approximate, FreeTrilaterationAsksForThreePoints) {
  const auto points = [](const char* a, const char* b, const char* c) {
    return std::string("<point id='A' ") + a + " adj='XY'/><point id='B' " + b + " adj='XY'/><point id='C' " + c +
           " adj='XY'/><point id='D' adj='XY'/><obs><distance from='A' to='B' val='100'/><distance from='A' to='C' "
           "val='100'/><distance from='A' to='D' val='141.421'/><distance from='B' to='C' val='141.421'/><distance "
           "from='B' to='D' val='100'/><distance from='C' to='D' val='100'/></obs>";
  };
  EXPECT_NE(refusal(points("", "", "")).find("of three points"), std::string::npos) << refusal(points("", "", ""));
  const NetworkResult r = adjust(points("x='1' y='2'", "x='99' y='1'", "x='-1' y='-98'"));
  EXPECT_LT(r.point("D").position.y(), -90);
}

/// Four spheres about points of one height: above or below; a fifth decides.
TEST(Approximate, SlopeDistancesPlaceAPointInSpace) {
  const std::string four =
      "<point id='1' x='300' y='0' z='0' fix='xyz'/><point id='2' x='0' y='300' z='0' fix='xyz'/><point id='3' "
      "x='-300' y='0' z='0' fix='xyz'/><point id='4' x='0' y='-300' z='0' fix='xyz'/><point id='5' x='0' y='0' z='100' "
      "fix='xyz'/><point id='P' adj='xyz'/><obs><s-distance from='1' to='P' val='500'/><s-distance from='2' to='P' "
      "val='500'/><s-distance from='3' to='P' val='500'/><s-distance from='4' to='P' val='500'/>";
  const std::string text = refusal(four + "</obs>");
  EXPECT_NE(text.find("H 400.00"), std::string::npos) << text;
  EXPECT_NE(text.find("H -400.00"), std::string::npos) << text;
  const NetworkResult r = adjust(four + "<s-distance from='5' to='P' val='500'/></obs>");
  EXPECT_LT((r.point("P").position - Eigen::Vector3d(0, 0, -400)).norm(), 1e-6);
}

/// Between two points without a view of each other: each of S1 and S2 lies on two circles, and only the angles between
/// them tell which of the four combinations is meant.
TEST(Approximate, AnglesDecideBetweenCombinationsOfPlaces) {
  const NetworkResult r = adjust(
      "<point id='A' x='-200' y='100' z='0' fix='xyz'/><point id='B' x='200' y='-100' z='0' fix='xyz'/><point id='S1' "
      "adj='xyz'/><point id='S2' adj='xyz'/><obs><angle from='S1' bs='S2' fs='A' val='100'/><angle from='S2' bs='B' "
      "fs='S1' val='300'/><s-distance from='A' to='S1' val='223.606798'/><s-distance from='S1' to='S2' "
      "val='200'/><s-distance from='B' to='S2' val='223.606798'/><s-distance from='A' to='S2' val='300'/><z-angle "
      "from='A' to='S1' val='70.4833'/><z-angle from='B' to='S2' val='70.4833'/></obs>");
  EXPECT_LT((r.point("S1").position - Eigen::Vector3d(0, 100, 100)).norm(), 1e-3);
  EXPECT_LT((r.point("S2").position - Eigen::Vector3d(0, -100, 100)).norm(), 1e-3);
}

/// Two directions to known points and one distance: the circle of the angle meets that of the distance twice.
/// A topographic job: details that one set-up alone has seen place nothing else, and are placed last.
TEST(Approximate, DetailsSightedOnceAreWhereTheyWereSeen) {
  test::SimulationSettings settings;
  settings.coordinates = false, settings.noise = 0;
  auto n = test::simulate(settings, 77);
  const auto found = [](const SurveyObservations& survey) {
    const auto all = approximate_coordinates(survey, mean_observations(survey).observations, {});
    EXPECT_EQ(all.size(), 1u);
    return all.at(0).points;
  };
  const auto before = found(n.survey);
  std::map<std::string, Eigen::Vector3d> truth;
  for (size_t i = 0; i < n.truth.size(); ++i) truth[n.survey.points[i].id] = n.truth[i];
  for (int k = 0; k < 60; ++k) {
    const int set_up = k % 3;
    const std::string station = "S" + std::to_string(set_up + 1), id = "D" + std::to_string(k);
    const double azimuth = 0.1 * k, zenith = 1.2 + 0.01 * k, slope = 10 + k;
    truth[id] = truth.at(station) + slope * Eigen::Vector3d(std::sin(azimuth) * std::sin(zenith),
                                                            std::cos(azimuth) * std::sin(zenith), std::cos(zenith));
    Observation o;
    o.set_up = set_up, o.from = station, o.to = id, o.pointing = 1000 + k;
    for (const auto& [kind, value, sigma] : {std::tuple{ObservationKind::direction, azimuth - 0.7 - 1.9 * set_up, 1e-5},
                                             {ObservationKind::zenith_angle, zenith, 1e-5},
                                             {ObservationKind::slope_distance, slope, 1e-3}}) {
      o.kind = kind, o.value = value, o.sigma = sigma;
      if (k != 59 || kind == ObservationKind::direction) n.survey.observations.push_back(o);
    }
    Point point;
    point.id = id;
    n.survey.points.push_back(point);
  }
  const auto after = found(n.survey);
  for (const auto& [id, p] : before) EXPECT_LT((after.at(id) - p).norm(), 1e-9) << id;
  const bool seen = after.contains("D59") && !std::isnan(after.at("D59").x());
  EXPECT_FALSE(seen) << "a direction alone places nothing";
  for (int k = 1; k < 59; ++k) {  // distances do not depend on the frame
    const std::string id = "D" + std::to_string(k), other = "D" + std::to_string(k - 1);
    ASSERT_TRUE(after.contains(id)) << id;
    EXPECT_NEAR((after.at(id) - after.at(other)).norm(), (truth.at(id) - truth.at(other)).norm(), 1e-6) << id;
    EXPECT_NEAR((after.at(id) - after.at("M23")).norm(), (truth.at(id) - truth.at("M23")).norm(), 1e-6) << id;
  }
}

TEST(Approximate, TwoDirectionsAndADistancePlaceAStation) {
  const std::string start =
      "<point id='A' x='0' y='50' fix='xy'/><point id='B' x='40' y='50' fix='xy'/><point id='S' adj='xy'/><obs "
      "from='S'><direction to='A' val='0'/><direction to='B' val='50'/><distance to='A' val='50'/>";
  EXPECT_NE(refusal(start + "</obs>").find("equally well"), std::string::npos) << refusal(start + "</obs>");
  const double b = std::hypot(40 - 30, 50 - 10);
  const NetworkResult r = adjust(
      "<point id='A' x='0' y='50' fix='xy'/><point id='B' x='40' y='50' fix='xy'/><point id='S' adj='xy'/><obs "
      "from='S'><direction to='A' val='0'/><direction to='B' val='" +
      std::to_string((std::atan2(10, 40) - std::atan2(-30, 40)) * 200 / std::numbers::pi) +
      "'/><distance to='A' val='50'/></obs><obs><distance from='B' to='S' val='" + std::to_string(b) + "'/></obs>");
  EXPECT_LT((r.point("S").position.head<2>() - Eigen::Vector2d(30, 10)).norm(), 1e-3);
}

/// Largest distance between the two results, after the plane motion and the lift a free network leaves open.
double disagreement(const NetworkResult& a, const NetworkResult& b) {
  std::vector<Eigen::Vector2d> from, to;
  double lift = 0;
  int heights = 0;
  for (const ResultPoint& p : a.points) {
    const ResultPoint& q = b.point(p.id);
    if (!std::isnan(p.position.x())) {
      from.push_back(p.position.head<2>());
      to.push_back(q.position.head<2>());
    }
    if (std::isnan(p.position.z())) continue;
    lift += q.position.z() - p.position.z();
    ++heights;
  }
  const bool is_free = a.defect > 0;
  PlaneMotion motion;
  if (const auto fit = fit_plane(from, to); fit && is_free) motion = *fit;
  lift = is_free && heights > 0 ? lift / heights : 0;
  double largest = 0;
  for (const ResultPoint& p : a.points) {
    const ResultPoint& q = b.point(p.id);
    if (!std::isnan(p.position.x()))
      largest = std::max(largest, (motion(p.position.head<2>()) - q.position.head<2>()).norm());
    if (!std::isnan(p.position.z())) largest = std::max(largest, std::abs(p.position.z() + lift - q.position.z()));
  }
  return largest;
}

/// What becomes of a network without its approximate coordinates.
enum class Outcome { undetermined, solved, refused, not_found, wrong };

/// The message names points: with approximate coordinates of these it must come out right.
Outcome outcome_of_remedy(const RandomNetwork& network, const NetworkResult& right, NetworkError refusal) {
  SurveyObservations survey = network.without_coordinates();
  for (int round = 0; round < 4; ++round) {
    for (const Finding& f : refusal.findings)
      for (const std::string& id : f.points)
        for (size_t i = 0; i < survey.points.size(); ++i)
          if (survey.points[i].id == id) survey.points[i].coordinates = network.truth[i];
    try {
      return disagreement(adjust_network(survey, plain()), right) < 1e-4 ? Outcome::refused : Outcome::wrong;
    } catch (const NetworkError& again) {
      refusal = again;
    }
  }
  return Outcome::not_found;
}

/// Only what can be determined near the truth counts.
Outcome outcome_of(const RandomNetwork& network, std::string& text) {
  NetworkResult right;
  try {
    right = adjust_network(network.survey, plain());
  } catch (const NetworkError&) {
    return Outcome::undetermined;
  }
  if (!right.left_out.empty()) return Outcome::undetermined;  // not all of it
  try {
    const NetworkResult r = adjust_network(network.without_coordinates(), plain());
    // A better fit than the one near the truth is no mistake of the search: the observations cannot tell.
    if (disagreement(r, right) < 1e-4 || r.sum_of_squares < right.sum_of_squares - 1e-6) return Outcome::solved;
    for (const Finding& f : r.findings)
      if (f.text.find("probably wrong") != std::string::npos) return Outcome::not_found;
    text = "off by " + std::to_string(disagreement(r, right)) + " m";
    return Outcome::wrong;
  } catch (const NetworkError& error) {
    text = error.what();
    if (text.find("equally well") == std::string::npos) return Outcome::not_found;
    return right.defect > 0 ? Outcome::refused : outcome_of_remedy(network, right, error);
  }
}

class RandomNetworks : public testing::TestWithParam<NetworkKind> {};

/// 25 networks of each kind; PLUMBLINE_TRIALS runs another number of them, PLUMBLINE_SHOW tells what became of them.
TEST_P(RandomNetworks, AreFoundOrRefusedButNeverWrong) {
  const char* trials = std::getenv("PLUMBLINE_TRIALS");
  const auto count = static_cast<std::uint64_t>(trials ? std::atoi(trials) : 25);
  const std::string name = test::kNetworkKindNames[static_cast<int>(GetParam())];
  std::map<Outcome, int> outcomes;
  for (std::uint64_t seed = 0; seed < count; ++seed) {
    std::string text;
    const Outcome outcome = outcome_of(RandomNetwork(GetParam(), seed), text);
    ++outcomes[outcome];
    EXPECT_NE(outcome, Outcome::wrong) << name << " " << seed << ": " << text;
    if (std::getenv("PLUMBLINE_SHOW") && outcome == Outcome::not_found)
      std::cout << name << " " << seed << ": " << text << "\n";
  }
  const int determined = static_cast<int>(count) - outcomes[Outcome::undetermined];
  const int answered = outcomes[Outcome::solved] + outcomes[Outcome::refused];
  if (std::getenv("PLUMBLINE_SHOW"))
    std::cout << name << ": " << determined << " determined, " << outcomes[Outcome::solved] << " solved, "
              << outcomes[Outcome::refused] << " have two solutions, " << outcomes[Outcome::not_found] << " not found, "
              << outcomes[Outcome::wrong] << " wrong" << std::endl;
  EXPECT_GT(determined, 0);
  // Theodolites that see markers only, without distances, are beyond what the search knows.
  EXPECT_GE(answered, (GetParam() == NetworkKind::theodolite ? 0 : 0.95) * determined);
}

INSTANTIATE_TEST_SUITE_P(Approximate, RandomNetworks, testing::ValuesIn(test::kNetworkKinds), [](const auto& kind) {
  std::string name = test::kNetworkKindNames[static_cast<int>(kind.param)];
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
});

}  // namespace test_approximate
}  // namespace plumbline::survey
