// Small networks as gama-local XML whose answer is known without an adjustment: by construction, or in closed form.
#include <Eigen/LU>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <sstream>

#include "survey/adjust/adjust_network.hpp"
#include "survey/files/gama.hpp"
#include "test_support.hpp"

namespace plumbline::survey {
namespace test_small_networks {

constexpr double kGon = std::numbers::pi / 200;

std::string network(const std::string& content, const std::string& attributes = "axes-xy=\"en\"") {
  return "<gama-local><network " + attributes + "><parameters sigma-apr=\"1\" sigma-act=\"apriori\"/>" +
         "<points-observations distance-stdev=\"5\" direction-stdev=\"10\" angle-stdev=\"10\" " +
         "zenith-angle-stdev=\"10\">" + content + "</points-observations></network></gama-local>\n";
}

std::string digits(double value) {
  std::ostringstream text;
  text.precision(17);
  text << value;
  return text.str();
}

using Plan = std::map<std::string, Eigen::Vector2d>;

double azimuth(const Plan& plan, const std::string& from, const std::string& to) {
  const Eigen::Vector2d d = plan.at(to) - plan.at(from);
  return std::atan2(d.x(), d.y());
}

/// A chain of triangles over 70 km.
Plan chain() {
  return {{"A", {0, 0}},         {"B", {12000, 9000}}, {"C", {21000, -4000}}, {"D", {33000, 8000}},
          {"E", {45000, -3000}}, {"F", {56000, 9000}}, {"G", {68000, 1000}}};
}

/// All three angles of the triangles of neighbours in the chain, without error.
std::string angles(const Plan& plan) {
  const std::string names = "ABCDEFG";
  std::string text;
  for (size_t t = 0; t + 2 < names.size(); ++t)
    for (size_t k = 0; k < 3; ++k) {
      const std::string at(1, names[t + k]), left(1, names[t + (k + 1) % 3]), right(1, names[t + (k + 2) % 3]);
      const double angle = azimuth(plan, at, right) - azimuth(plan, at, left);
      text += "<angle from='" + at + "' bs='" + left + "' fs='" + right + "' val='" +
              digits((angle < 0 ? angle + 2 * std::numbers::pi : angle) / kGon) + "'/>";
    }
  return text;
}

std::string free_points(const Plan& plan, const std::string& except) {
  std::string text;
  for (const auto& [id, p] : plan)
    if (except.find(id) == std::string::npos) text += "<point id='" + id + "' adj='xy'/>";
  return text;
}

std::string fixed_point(const Plan& plan, const std::string& id) {
  const Eigen::Vector2d& p = plan.at(id);
  return "<point id='" + id + "' x='" + digits(p.x()) + "' y='" + digits(p.y()) + "' fix='xy'/>";
}

NetworkResult adjust(const std::string& xml) { return adjust_network(read_gama_xml(xml, "t.gkf"), {}); }

void expect_plan(const NetworkResult& r, const Plan& plan, double tolerance) {
  for (const auto& [id, p] : plan) EXPECT_LT((r.point(id).position.head<2>() - p).norm(), tolerance) << id;
}

TEST(SmallNetworks, TriangulationBetweenTwoDistantPoints) {
  const Plan plan = chain();
  const NetworkResult r = adjust(network(fixed_point(plan, "A") + fixed_point(plan, "G") + free_points(plan, "AG") +
                                         "<obs>" + angles(plan) + "</obs>"));
  EXPECT_EQ(r.degrees_of_freedom, 15 - 10);
  expect_plan(r, plan, 1e-6);
}

TEST(SmallNetworks, TriangulationFromAnglesOneSideAndAnAzimuth) {
  const Plan plan = chain();
  const double side = (plan.at("F") - plan.at("G")).norm();
  const std::string base = "<distance from='F' to='G' val='" + digits(side) + "'/>";
  const double to_b = azimuth(plan, "A", "B") / kGon;
  const NetworkResult r =
      adjust(network(fixed_point(plan, "A") + free_points(plan, "A") + "<obs>" + angles(plan) + base +
                     "<azimuth from='A' to='B' val='" + digits(to_b) + "' stdev='10'/></obs>"));
  EXPECT_EQ(r.degrees_of_freedom, 17 - 12);
  expect_plan(r, plan, 1e-5);
}

TEST(SmallNetworks, TriangulationWithoutAnyLengthNamesTheScale) {
  const Plan plan = chain();
  const double to_b = azimuth(plan, "A", "B") / kGon;
  try {
    adjust(network(fixed_point(plan, "A") + free_points(plan, "A") + "<obs>" + angles(plan) +
                   "<azimuth from='A' to='B' val='" + digits(to_b) + "' stdev='10'/></obs>"));
    FAIL() << "adjusted without a length";
  } catch (const NetworkError& error) {
    EXPECT_NE(std::string(error.what()).find("scale of the network is open"), std::string::npos) << error.what();
  }
}

TEST(SmallNetworks, DirectionsTellWhichOfTwoMirroredPlacesIsMeant) {
  // Circles about A and B meet on both sides of AB; only the directions from C say on which it lies.
  const Plan plan = {{"A", {0, 0}}, {"B", {100, 0}}, {"C", {30, -60}}, {"D", {80, -50}}};
  const auto distance = [&](const std::string& a, const std::string& b) {
    return "<distance from='" + a + "' to='" + b + "' val='" + digits((plan.at(a) - plan.at(b)).norm()) + "'/>";
  };
  const auto direction = [&](const std::string& a, const std::string& b) {
    const double value = azimuth(plan, a, b) / kGon;
    return "<direction to='" + b + "' val='" + digits(value < 0 ? value + 400 : value) + "'/>";
  };
  const NetworkResult r = adjust(network(fixed_point(plan, "A") + fixed_point(plan, "B") + free_points(plan, "AB") +
                                         "<obs>" + distance("A", "C") + distance("A", "D") + distance("B", "C") +
                                         distance("B", "D") + distance("C", "D") + "</obs><obs from='C'>" +
                                         direction("C", "A") + direction("C", "B") + direction("C", "D") + "</obs>"));
  expect_plan(r, plan, 1e-7);
  EXPECT_EQ(r.rows.size(), 8u);
}

/// Two baselines to one point: P = (P1 + P2)^-1 (P1 x1 + P2 x2), in the axes of the file, whatever these are and
/// whichever way its angles run; the correlations of a file belong to its axes.
TEST(SmallNetworks, TwoBaselinesAreTheirWeightedMeanInAnyAxes) {
  Eigen::Matrix3d c1, c2;
  c1 << 9, 3, -2, 3, 4, 1, -2, 1, 16;
  c2 << 4, -1, 1, -1, 9, 2, 1, 2, 25;
  const Eigen::Vector3d x1(100, 200, 30), x2(100.004, 199.995, 30.007);
  const Eigen::Matrix3d p1 = c1.inverse(), p2 = c2.inverse(), q = (p1 + p2).inverse();
  const Eigen::Vector3d mean = q * (p1 * x1 + p2 * x2);
  const auto vector = [](const Eigen::Vector3d& x, const Eigen::Matrix3d& c) {
    std::string text = "<vectors><vec from='A' to='P' dx='" + digits(x[0]) + "' dy='" + digits(x[1]) + "' dz='" +
                       digits(x[2]) + "'/><cov-mat dim='3' band='2'>";
    for (int i = 0; i < 3; ++i)
      for (int j = i; j < 3; ++j) text += digits(c(i, j)) + " ";
    return text + "</cov-mat></vectors>";
  };
  const std::map<std::string, std::array<Eigen::Vector3d, 2>> axes = {
      {"en", {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0)}},
      {"ne", {Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(1, 0, 0)}},
      {"sw", {Eigen::Vector3d(0, -1, 0), Eigen::Vector3d(-1, 0, 0)}}};
  for (const auto& [name, directions] : axes)
    for (const std::string sense : {"left-handed", "right-handed"}) {
      const NetworkResult r = adjust(network(
          "<point id='A' x='0' y='0' z='0' fix='xyz'/><point id='P' adj='xyz'/>" + vector(x1, c1) + vector(x2, c2),
          "axes-xy='" + name + "' angles='" + sense + "'"));
      Eigen::Matrix3d turn;  // E, N, H of x, y, z
      turn << directions[0], directions[1], Eigen::Vector3d::UnitZ();
      const ResultPoint& p = r.point("P");
      EXPECT_LT((turn.transpose() * p.position - mean).norm(), 1e-9) << name << sense;
      EXPECT_LT((turn.transpose() * r.covariance(p, p) * turn - 1e-6 * q).norm(), 1e-14) << name << sense;
    }
}

/// Levelling between two bench marks: the misclosure is shared out by length, the heights in the middle have
/// sigma^2 = s0^2 L1 L2 / (L1 + L2).
TEST(SmallNetworks, LevellingLineBetweenTwoBenchMarks) {
  const NetworkResult r =
      adjust(network("<point id='A' z='100' fix='z'/><point id='P' adj='z'/>"
                     "<point id='B' z='103.010' fix='z'/>"
                     "<height-differences><dh from='A' to='P' val='1' dist='1'/>"
                     "<dh from='P' to='B' val='2' dist='4'/></height-differences>"));
  EXPECT_NEAR(r.point("P").position.z(), 101.002, 1e-12);
  EXPECT_NEAR(r.sigma(r.point("P")).z(), 1e-3 * std::sqrt(0.8), 1e-12);
  EXPECT_NEAR(r.sum_of_squares, 100.0 / 5, 1e-9);  // (10 mm)^2 / (1 + 4) mm^2
  EXPECT_EQ(r.degrees_of_freedom, 1);
}

TEST(SmallNetworks, TheFileSaysWhatIsTooFarOff) {
  const std::string xml = network(
      "<point id='A' z='100' fix='z'/><point id='P' z='101' adj='z'/><height-differences>\n"
      "<dh from='A' to='P' val='1' dist='1'/>\n  <dh from='A' to='P' val='1.5' dist='1'/></height-differences>");
  EXPECT_NEAR(adjust(xml).point("P").position.z(), 101.25, 1e-12);
  std::string strict = xml;
  strict.replace(strict.find("sigma-act"), 0, "tol-abs=\"100\" ");
  const NetworkResult r = adjust(strict);
  EXPECT_NEAR(r.point("P").position.z(), 101, 1e-12);
  EXPECT_NE(r.findings.front().text.find("(t.gkf:3:4) is not used"), std::string::npos) << r.findings.front().text;
}

/// Two points and their coordinates; `together`: with one covariance.
SurveyObservations list_of_two(bool together) {
  SurveyObservations list;
  const std::vector<std::string> ids = {"A", "B"};
  for (size_t i = 0; i < 2; ++i) {
    Point point;
    point.id = ids[i], point.coordinates = Eigen::Vector3d(10, 20, 30 + static_cast<double>(i));
    list.points.push_back(point);
    if (i == 0 || !together) list.coordinates.emplace_back();
    CoordinateGroup& group = list.coordinates.back();
    const auto n = static_cast<Eigen::Index>(group.components.size());
    for (int k = 0; k < 3; ++k) group.components.push_back({ids[i], k});
    group.values.conservativeResize(n + 3), group.values.tail<3>() = point.coordinates;
    group.covariance = 1e-6 * Eigen::MatrixXd::Identity(n + 3, n + 3);
  }
  return list;
}

/// What another program adjusted comes as a list; nothing here can test it, and that is no "no reading is controlled".
TEST(SmallNetworks, AListOfCoordinatesIsTakenAsGivenAndSoundOnlyWhereSomebodySaysSo) {
  AdjustOptions options;
  const NetworkResult plain = adjust_network(list_of_two(false), options);
  EXPECT_TRUE(plain.without_readings);
  EXPECT_EQ(plain.validity, Validity::doubtful);
  EXPECT_TRUE(plain.verdict.starts_with("not tested: a list of coordinates")) << plain.verdict;
  EXPECT_TRUE(plain.findings.empty()) << plain.findings.front().text;
  options.coordinates_are_tested = true;
  const NetworkResult tested = adjust_network(list_of_two(false), options);
  EXPECT_EQ(tested.validity, Validity::sound);
  EXPECT_TRUE(tested.verdict.ends_with("; the errors of each point are taken as its own")) << tested.verdict;
  EXPECT_NEAR(tested.sigma(tested.point("B")).z(), 1e-3, 1e-9);
  EXPECT_EQ(adjust_network(list_of_two(true), options).verdict.find("its own"), std::string::npos);
  SurveyObservations twice = list_of_two(false);
  twice.coordinates.push_back(twice.coordinates[0]);
  twice.coordinates.back().values.z() += 0.02;
  const NetworkResult contradicted = adjust_network(twice, options);
  EXPECT_NE(contradicted.validity, Validity::sound) << contradicted.verdict;
}

}  // namespace test_small_networks
}  // namespace plumbline::survey
