// survey.tables: coordinates and relative precision as a spreadsheet gets them.
#include <Eigen/Eigenvalues>
#include <cmath>
#include <cstring>
#include <map>
#include <numbers>
#include <set>
#include <sstream>

#include "artifacts/file.hpp"
#include "artifacts/points.hpp"
#include "artifacts/survey_artifact.hpp"
#include "artifacts/survey_network.hpp"
#include "artifacts/survey_observations.hpp"
#include "geometry/packed_symmetric.hpp"
#include "geometry/relative_points.hpp"
#include "node_harness.hpp"
#include "simulated_network.hpp"
#include "stopping.hpp"

namespace plumbline::survey {
namespace test_tables {

using Rows = std::vector<std::map<std::string, std::string>>;

std::vector<std::string> cells_of(const std::string& line, char delimiter) {
  std::vector<std::string> cells;
  std::stringstream stream(line);
  for (std::string cell; std::getline(stream, cell, delimiter);) cells.push_back(cell);
  return cells;
}

Rows rows_of(const FileT& file, char delimiter = ',') {
  std::stringstream stream(std::string(file.content.begin(), file.content.end()));
  Rows rows;
  std::vector<std::string> names;
  for (std::string line; std::getline(stream, line);) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    const auto cells = cells_of(line, delimiter);
    if (names.empty()) {
      names = cells;
      continue;
    }
    auto& row = rows.emplace_back();
    for (size_t i = 0; i < cells.size() && i < names.size(); ++i) row[names[i]] = cells[i];
  }
  return rows;
}

class Tables : public testing::Test {
 protected:
  void SetUp() override {
    plumbline::test::NodeHarness adjust("survey.adjust");
    adjust.input<plumbline::SurveyObservations>("observations", to_artifact(test::simulate({}, 5).survey));
    adjust.set("datum", "inner");
    adjust.run();
    points_ = adjust.output<Points>("points");
    network_ = adjust.output<SurveyNetwork>("network");
  }
  plumbline::test::NodeHarness tables() const {
    plumbline::test::NodeHarness node("survey.tables");
    node.input<Points>("points", points_);
    node.input<SurveyNetwork>("network", network_);
    return node;
  }
  size_t index(const std::string& id) const {
    for (size_t i = 0; i < points_.points.size(); ++i)
      if (points_.points[i]->id == id) return i;
    throw std::out_of_range(id);
  }
  PointsT points_;
  SurveyNetworkT network_;
};

/// 165 MB were taken of 1188 points without a word.
TEST_F(Tables, AJointCovarianceIsAnnounced) {
  auto few = tables();
  few.run();
  EXPECT_EQ(few.announced(), 0u);
  PointsT many = points_;
  while (many.points.size() < 850) {
    many.points.push_back(std::make_unique<PointT>(*points_.points[many.points.size() % points_.points.size()]));
    many.points.back()->id += "_" + std::to_string(many.points.size());
  }
  const auto n = static_cast<Eigen::Index>(3 * many.points.size());
  many.covariance = pack_symmetric(Eigen::MatrixXd(1e-6 * Eigen::MatrixXd::Identity(n, n)));
  plumbline::test::NodeHarness node("survey.tables");
  node.input<Points>("points", many);
  node.input<SurveyNetwork>("network", network_);
  node.outcome();  // whatever it makes of points that the network has not
  EXPECT_EQ(node.announced(), 4 * sizeof(double) * static_cast<std::uint64_t>(n * (n + 1) / 2));
}

TEST_F(Tables, CanBeStopped) {
  EXPECT_EQ(plumbline::test::stopping_at_fault([this] { return tables(); }), "");
}

TEST_F(Tables, CoordinatesAndSigmas) {
  auto node = tables();
  node.run();
  const Rows rows = rows_of(node.output<File>("coordinates"));
  ASSERT_EQ(rows.size(), 15u);
  const PointT& marker = *points_.points[index("M12")];
  for (const auto& row : rows) {
    EXPECT_EQ(row.at("kind"), row.at("point")[0] == 'S' ? "station" : "marker");
    if (row.at("point") != "M12") continue;
    EXPECT_NEAR(std::stod(row.at("east_m")), marker.position.x(), 6e-6);
    EXPECT_NEAR(std::stod(row.at("height_m")), marker.position.z(), 6e-6);
    EXPECT_NEAR(std::stod(row.at("sigma_north_mm")), 1e3 * marker.sigma.y(), 6e-4);
    EXPECT_NEAR(std::stod(row.at("height_95_mm")), 1.959964e3 * marker.sigma.z(), 6e-4);
  }
}

TEST_F(Tables, RelativePrecisionOfNeighboursAndWantedPairs) {
  auto node = tables();
  node.set("pairs", "M00 M23");
  node.run();
  const Rows rows = rows_of(node.output<File>("relative"));
  ASSERT_GT(rows.size(), 12u);
  EXPECT_EQ(rows[0].at("from"), "M00");
  EXPECT_EQ(rows[0].at("to"), "M23");
  const Eigen::MatrixXd all = unpack_symmetric(points_.covariance, 3 * points_.points.size(), "test");
  for (const auto& row : rows) {
    EXPECT_EQ(row.at("from")[0], 'M') << "stations are no markers";
    const auto a = 3 * static_cast<Eigen::Index>(index(row.at("from"))),
               b = 3 * static_cast<Eigen::Index>(index(row.at("to")));
    const double variance = all(a + 2, a + 2) + all(b + 2, b + 2) - 2 * all(a + 2, b + 2);
    EXPECT_NEAR(std::stod(row.at("sigma_d_height_mm")), 1e3 * std::sqrt(variance), 6e-4);
    EXPECT_NEAR(std::stod(row.at("cov_hh_mm2")), 1e6 * variance, 1e-6);
  }
}

TEST_F(Tables, DecimalCommaForSpreadsheetsThatWantIt) {
  auto node = tables();
  node.set("decimal", "comma");
  node.run();
  const Rows rows = rows_of(node.output<File>("coordinates"), ';');
  ASSERT_EQ(rows.size(), 15u);
  EXPECT_NE(rows[0].at("east_m").find(','), std::string::npos);
}

TEST_F(Tables, NamesAnUnknownPoint) {
  auto node = tables();
  node.set("pairs", "M00 M99");
  try {
    node.run();
    FAIL();
  } catch (const plumbline::test::NodeFailed& error) {
    EXPECT_NE(std::string(error.what()).find("no point 'M99'"), std::string::npos) << error.what();
  }
}

TEST(RelativePoints, EllipseHasTheAzimuthOfItsMajorAxis) {
  for (const double azimuth : {0.4, 1.2, 2.5}) {  // clockwise from north, of an axis: below pi
    const Eigen::Vector2d major(std::sin(azimuth), std::cos(azimuth)), minor(-major.y(), major.x());
    const Eigen::Matrix2d covariance = 9 * major * major.transpose() + 4 * minor * minor.transpose();
    const ConfidenceEllipse e = confidence_ellipse(covariance, 2);
    EXPECT_NEAR(e.major, 6, 1e-12);
    EXPECT_NEAR(e.minor, 4, 1e-12);
    EXPECT_NEAR(e.azimuth, azimuth, 1e-12);
  }
}

TEST(RelativePoints, EveryPointHasItsNearest) {
  const double nan = std::nan("");
  const std::vector<Eigen::Vector3d> p = {{0, 0, 0}, {1, 0, 0}, {5, 0, 0}, {nan, 0, 0}};
  EXPECT_EQ(neighbours(p, 1), (std::vector<std::pair<int, int>>{{0, 1}, {1, 2}}));
  EXPECT_EQ(neighbours(p, 9).size(), 3u);
  EXPECT_TRUE(neighbours(p, 0).empty());
}

std::string text_of(const FileT& file) { return {file.content.begin(), file.content.end()}; }

TEST_F(Tables, VerdictAsASurveyorReadsIt) {
  auto node = tables();
  node.run();
  const std::string sound = text_of(node.output<File>("verdict"));
  EXPECT_EQ(sound.find("Sound: "), 0u) << sound;
  for (const char* words :
       {"15 points, 3 set-ups, 108 readings", "Nothing has to be measured again", "Weakest at 95 %"})
    EXPECT_NE(sound.find(words), std::string::npos) << words << " in:\n" << sound;
  EXPECT_NE(sound.find("Weakest at 95 %: in plan "), std::string::npos) << sound;
  // Of a levelling network: nothing determines the plan, which is held.
  for (auto& e : network_.ellipsoids) e->plan_semi_axis_95 = 0;
  auto levelled = tables();
  levelled.run();
  EXPECT_NE(text_of(levelled.output<File>("verdict")).find("Weakest at 95 %: in height "), std::string::npos);
  // Of a resection the station is all there is; known points are without error.
  for (auto& e : network_.ellipsoids)
    if (e->id != "S1") e->plan_semi_axis_95 = e->height_half_length_95 = 0;
  auto resection = tables();
  resection.run();
  EXPECT_NE(text_of(resection.output<File>("verdict")).find("Weakest at 95 %: in height S1 "), std::string::npos);
  // One of a hundred readings fails by chance: nobody goes back for it.
  network_.observations[4]->w = 3.5, network_.observations[4]->flagged = true;
  auto by_chance = tables();
  by_chance.run();
  EXPECT_NE(text_of(by_chance.output<File>("verdict")).find("Nothing has to be measured again"), std::string::npos);
  network_.validity = "invalid";
  network_.verdict = "not a result: the readings contradict each other (sigma0 314.00)";
  network_.left_out = {"X7"};
  auto& worst = *network_.observations[4];
  worst.w = 77.7, worst.estimated_blunder = 0.0123, worst.kind = "slope_distance", worst.flagged = true;
  auto invalid = tables();
  invalid.run();
  const std::string text = text_of(invalid.output<File>("verdict"));
  EXPECT_EQ(text.find("NOT A RESULT: "), 0u) << text;
  for (const std::string& words : {"1. slope distance S1 -> " + worst.to + ": w +77.7, off by +12.3 mm, suspect",
                                   "  - sight " + worst.to + " from set-up S1", std::string("  - sight X7")})
    EXPECT_NE(text.find(words), std::string::npos) << words << " in:\n" << text;
}

/// Of a network in a plane no height is the weakest: it has none.
TEST(TablesOfAPlane, HaveNoHeightAmongTheWeakest) {
  SurveyObservations plane = test::simulate({}, 5).survey;
  for (Point& p : plane.points) p.roles[2] = CoordinateRole::unused, p.coordinates.z() = kNotGiven;
  std::erase_if(plane.observations, [](const Observation& o) { return o.kind == ObservationKind::zenith_angle; });
  for (Observation& o : plane.observations)
    if (o.kind == ObservationKind::slope_distance) o.kind = ObservationKind::horizontal_distance, o.sigma = 0.1;
  plumbline::test::NodeHarness adjust("survey.adjust"), node("survey.tables");
  adjust.input<plumbline::SurveyObservations>("observations", to_artifact(plane));
  adjust.set("datum", "inner");
  adjust.run();
  node.input<Points>("points", adjust.output<Points>("points"));
  node.input<SurveyNetwork>("network", adjust.output<SurveyNetwork>("network"));
  node.run();
  const std::string verdict = text_of(node.output<File>("verdict"));
  EXPECT_NE(verdict.find("Weakest at 95 %: in plan "), std::string::npos) << verdict;
  EXPECT_EQ(verdict.find("in height"), std::string::npos) << verdict;
}

TEST_F(Tables, BlocksAndTheFullCovarianceForNumPy) {
  auto node = tables();
  node.set("full_covariance", "true");
  node.run();
  const auto n = 3 * points_.points.size();
  const Eigen::MatrixXd covariance = unpack_symmetric(points_.covariance, n, "the points");
  const std::string npy = text_of(node.output<File>("covariance"));
  ASSERT_EQ(npy.substr(1, 5), "NUMPY");
  const size_t header = 10 + static_cast<unsigned char>(npy[8]) + 256 * static_cast<unsigned char>(npy[9]);
  EXPECT_EQ(header % 64, 0u);
  EXPECT_NE(npy.find("'shape': (" + std::to_string(n) + ", " + std::to_string(n) + ")"), std::string::npos);
  ASSERT_EQ(npy.size(), header + 8 * n * n);
  const auto element = [&](size_t i, size_t j) {
    double value = 0;
    std::memcpy(&value, npy.data() + header + 8 * (i * n + j), 8);
    return value;
  };
  for (const auto& [i, j] : {std::pair<size_t, size_t>{0, 0}, {7, 2}, {2, 7}, {n - 1, 3}})
    EXPECT_EQ(element(i, j), covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)));
  const std::string json = text_of(node.output<File>("blocks"));
  EXPECT_NE(json.find("{\"id\": \"M00\", \"position\": [1"), std::string::npos) << json.substr(0, 300);
  EXPECT_LT(json.size(), 600 * points_.points.size());
  auto without = tables();
  without.run();
  EXPECT_NE(text_of(without.output<File>("covariance")).find("(0, 0)"), std::string::npos);
}

/// What a network that is too large for a joint covariance gives, of one that has both.
TEST_F(Tables, AreTheSameWithoutAJointCovariance) {
  plumbline::test::NodeHarness adjust("survey.adjust");
  adjust.input<plumbline::SurveyObservations>("observations", to_artifact(test::simulate({}, 5).survey));
  adjust.set("datum", "inner");
  adjust.set("covariance", "neighbours");
  adjust.set("pairs", "M00 M23");
  adjust.run();
  const PointsT points = adjust.output<Points>("points");
  const SurveyNetworkT network = adjust.output<SurveyNetwork>("network");
  EXPECT_TRUE(points.covariance.empty());
  ASSERT_FALSE(network.findings.empty());
  EXPECT_NE(network.findings.back()->text.find("covariance=full"), std::string::npos) << "it is said";
  auto whole = tables(), parts = plumbline::test::NodeHarness("survey.tables");
  parts.input<Points>("points", points);
  parts.input<SurveyNetwork>("network", network);
  whole.set("pairs", "M00 M23"), parts.set("pairs", "M23 M00");
  whole.run(), parts.run();
  EXPECT_EQ(whole.output<File>("coordinates").content, parts.output<File>("coordinates").content);
  EXPECT_EQ(whole.output<File>("blocks").content, parts.output<File>("blocks").content);
  std::map<std::string, std::string> heights;
  for (const auto& row : rows_of(parts.output<File>("relative")))
    heights[row.at("from") + row.at("to")] = row.at("cov_hh_mm2");
  const Rows rows = rows_of(whole.output<File>("relative"));
  for (const auto& row : rows) EXPECT_EQ(heights[row.at("from") + row.at("to")], row.at("cov_hh_mm2"));
  EXPECT_EQ(heights["M23M00"], heights["M00M23"]);
  parts.set("pairs", "M23 M23");
  parts.run();
  EXPECT_NEAR(std::stod(rows_of(parts.output<File>("relative")).front().at("cov_hh_mm2")), 0, 1e-9) << "to itself";
  parts.set("pairs", "M01 M23");
  try {
    parts.run();
    FAIL() << "a pair that nobody asked of the adjustment";
  } catch (const plumbline::test::NodeFailed& error) {
    EXPECT_NE(std::string(error.what()).find("network.with.pairs=[\"M01;M23\"]"), std::string::npos) << error.what();
  }
}

/// What is to be said of a network stays, and which observation a step of the search means.
/// A result of ten thousand points says no more than one of five hundred: what is told of and the weakest.
TEST_F(Tables, ABriefResultDoesNotGrowWithThePoints) {
  const auto size = network_.points.size();
  for (int i = 0; i < 1200; ++i) {
    auto point = std::make_unique<PointT>();
    point->id = "Q" + std::to_string(i), point->position = Eigen::Vector3d(i, 0, 0);
    point->sigma = Eigen::Vector3d::Constant(i == 700 ? 1e-4 : 1e-3 + 1e-6 * i);
    network_.points.push_back(std::move(point));
  }
  auto finding = std::make_unique<NetworkFindingT>();
  finding->severity = "warning", finding->text = "Q700 stands out", finding->points = {"Q700"};
  network_.findings.push_back(std::move(finding));
  plumbline::test::NodeHarness node("survey.brief");
  node.input<SurveyNetwork>("network", network_);
  node.set("most", "0");
  node.run();
  const SurveyNetworkT brief = node.output<SurveyNetwork>("network");
  ASSERT_EQ(brief.points.size(), 500u);
  const auto has = [&](const std::string& id) {
    return std::any_of(brief.points.begin(), brief.points.end(), [&](const auto& p) { return p->id == id; });
  };
  EXPECT_TRUE(has("Q700")) << "a finding names it";
  EXPECT_TRUE(has("Q1199")) << "the weakest";
  EXPECT_FALSE(has("Q1"));
  EXPECT_NE(brief.findings.back()->text.find("of " + std::to_string(size + 1200) + " points 500"), std::string::npos);
}

TEST_F(Tables, ABriefResultKeepsWhatIsToBeSaid) {
  network_.observations[7]->removed = true, network_.observations[7]->w = 0.1;
  network_.observations[11]->flagged = true, network_.observations[11]->w = 9;
  auto step = std::make_unique<SnoopingStepT>();
  step->observation = 7, step->action = "removed";
  network_.snooping.push_back(std::move(step));
  const std::string told = network_.observations[7]->to, suspect = network_.observations[11]->to;
  const auto brief = [&](const char* most) {
    plumbline::test::NodeHarness node("survey.brief");
    node.input<SurveyNetwork>("network", network_);
    node.set("most", most);
    node.run();
    return node.output<SurveyNetwork>("network");
  };
  const SurveyNetworkT all = brief("5000"), ten = brief("10"), none = brief("0");
  EXPECT_EQ(all.observations.size(), network_.observations.size());
  ASSERT_EQ(ten.observations.size(), 10u);
  ASSERT_EQ(none.observations.size(), 2u) << "more than are wanted, for something is to be said of them";
  EXPECT_TRUE(none.observations[0]->removed);
  EXPECT_EQ(none.observations[0]->to, told);
  EXPECT_EQ(none.observations[1]->to, suspect);
  EXPECT_EQ(none.snooping.back()->observation, 0);
  EXPECT_EQ(ten.observations[ten.snooping.back()->observation]->to, told);
  EXPECT_NE(ten.findings.back()->text.find("observations.csv"), std::string::npos);
  const Rows rows = [&] {
    auto node = tables();
    node.run();
    return rows_of(node.output<File>("observations"));
  }();
  ASSERT_EQ(rows.size(), network_.observations.size());
  EXPECT_EQ(rows[7].at("flag"), "removed");
  EXPECT_EQ(rows[11].at("flag"), "suspect");
  const auto& o = *network_.observations[0];
  EXPECT_EQ(rows[0].at("unit"), o.kind == "slope_distance" ? "m" : "gon");
  EXPECT_NEAR(std::stod(rows[0].at("value")), o.value * (o.kind == "slope_distance" ? 1 : 200 / std::numbers::pi),
              1e-5);
}

/// A cell of millimetres, gon or numbers without unit, as it is rounded.
void expect_rounded(const std::map<std::string, std::string>& row, const std::string& name, double value, int digits) {
  EXPECT_NEAR(std::stod(row.at(name)), value, 0.51 * std::pow(10, -digits)) << name;
}

/// Semi-axes and azimuth by the eigenvectors of the plan's covariance, in place of the formula of the library.
void expect_ellipse(const std::map<std::string, std::string>& row, const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> plan(covariance.topLeftCorner<2, 2>());
  const double factor = 1e3 * std::sqrt(-2 * std::log(0.05));  // chi-square of two degrees of freedom, 95 %
  expect_rounded(row, "plan_major_95_mm", factor * std::sqrt(plan.eigenvalues()[1]), 3);
  expect_rounded(row, "plan_minor_95_mm", factor * std::sqrt(plan.eigenvalues()[0]), 3);
  expect_rounded(row, "height_95_mm", 1959.964 * std::sqrt(covariance(2, 2)), 3);
  const double turned = std::stod(row.at("azimuth_major_gon")) * std::numbers::pi / 200;
  const Eigen::Vector2d axis(std::sin(turned), std::cos(turned));
  EXPECT_NEAR(std::abs(axis.dot(plan.eigenvectors().col(1))), 1, 1e-4) << "clockwise from north";
}

TEST_F(Tables, EveryCellIsTheFigureOfItsHeading) {
  auto node = tables();
  node.run();
  const Eigen::MatrixXd all = unpack_symmetric(points_.covariance, 3 * points_.points.size(), "test");
  const auto block = [&](size_t a, size_t b) -> Eigen::Matrix3d {
    return all.block<3, 3>(3 * static_cast<Eigen::Index>(a), 3 * static_cast<Eigen::Index>(b));
  };
  const std::vector<std::string> axes = {"east", "north", "height"};
  const std::set<std::string> datum(network_.datum_points.begin(), network_.datum_points.end());
  for (const auto& row : rows_of(node.output<File>("coordinates"))) {
    const size_t i = index(row.at("point"));
    for (Eigen::Index k = 0; k < 3; ++k) {
      expect_rounded(row, axes[static_cast<size_t>(k)] + "_m", points_.points[i]->position[k], 5);
      expect_rounded(row, "sigma_" + axes[static_cast<size_t>(k)] + "_mm", 1e3 * std::sqrt(block(i, i)(k, k)), 3);
    }
    EXPECT_EQ(row.at("datum"), datum.contains(row.at("point")) ? "yes" : "no");
    expect_ellipse(row, block(i, i));
  }
  for (const auto& row : rows_of(node.output<File>("relative"))) {
    const size_t a = index(row.at("from")), b = index(row.at("to"));
    const Eigen::Vector3d way = points_.points[b]->position - points_.points[a]->position;
    const Eigen::Matrix3d of = block(a, a) + block(b, b) - block(a, b) - block(b, a);
    for (Eigen::Index k = 0; k < 3; ++k) {
      expect_rounded(row, "d_" + axes[static_cast<size_t>(k)] + "_m", way[k], 5);
      expect_rounded(row, "sigma_d_" + axes[static_cast<size_t>(k)] + "_mm", 1e3 * std::sqrt(of(k, k)), 3);
      for (Eigen::Index j = k; j < 3; ++j)
        expect_rounded(row, std::string("cov_") + "enh"[k] + "enh"[j] + "_mm2", 1e6 * of(k, j), 6);
    }
    expect_rounded(row, "distance_m", way.norm(), 5);
    expect_rounded(row, "sigma_distance_mm", 1e3 * std::sqrt(way.dot(of * way)) / way.norm(), 3);
    expect_ellipse(row, of);
  }
}

/// Of readings angles are in gon and lengths in metres, and what is small a thousandth of it.
TEST_F(Tables, EveryReadingHasItsFiguresInItsUnit) {
  network_.observations[5]->removed = network_.observations[8]->flagged = true;
  network_.observations[3]->control = "none", network_.observations[3]->detail = "face 2";
  auto node = tables();
  node.run();
  const Rows rows = rows_of(node.output<File>("observations"));
  ASSERT_EQ(rows.size(), network_.observations.size());
  for (size_t i = 0; i < rows.size(); ++i) {
    const auto& o = *network_.observations[i];
    const auto& row = rows[i];
    const bool length = o.kind == "slope_distance";
    const double unit = length ? 1 : 200 / std::numbers::pi;
    EXPECT_EQ(row.at("unit"), length ? "m" : "gon");
    for (const auto& [name, text] : {std::pair("kind", o.kind),
                                     {"set_up", o.set_up},
                                     {"from", o.from},
                                     {"to", o.to},
                                     {"detail", o.detail},
                                     {"effect_on", o.external_point},
                                     {"control", o.control}})
      EXPECT_EQ(row.at(name), text) << name;
    EXPECT_EQ(row.at("flag"), o.removed ? "removed" : o.flagged ? "suspect" : "");
    expect_rounded(row, "value", unit * o.value, 5);
    expect_rounded(row, "residual_milli", 1e3 * unit * o.residual, 3);
    expect_rounded(row, "sigma_milli", 1e3 * unit * o.sigma, 3);
    expect_rounded(row, "redundancy_number", o.redundancy_number, 3);
    expect_rounded(row, "w", o.w, 2);
    expect_rounded(row, "mdb_milli", 1e3 * unit * o.mdb, 3);
    expect_rounded(row, "effect_mm", 1e3 * o.external_effect, 3);
    expect_rounded(row, "line", o.line, 0);
  }
}

}  // namespace test_tables
}  // namespace plumbline::survey
