// What cannot be adjusted is left out before, by name: readings without the coordinates they need, points nobody
// observed, covariances of which rows are left out.
#include <functional>

#include "network_words.hpp"
#include "simulated_network.hpp"
#include "survey/adjust/adjust_network.hpp"
#include "test_support.hpp"

namespace plumbline::survey {
namespace test_screening {

AdjustOptions free_network() {
  AdjustOptions options;
  options.datum = DatumMode::inner;
  options.curvature = Switch::off;
  return options;
}

/// Every reading that needs a height is left out where its point has none, and nothing else is.
TEST(Screening, ReadingsToAPointWithoutHeight) {
  auto n = test::simulate({}, 61);
  for (Point& p : n.survey.points)
    if (p.id == "M11") p.roles[2] = CoordinateRole::unused;
  Observation level;
  level.kind = ObservationKind::height_difference, level.from = "M10", level.to = "M11", level.value = 0,
  level.sigma = 0.001;
  n.survey.observations.push_back(level);
  const NetworkResult r = adjust_network(n.survey, free_network());
  const std::string text = all_words(r);
  for (const char* words : {"zenith angle S1 -> M11", "slope distance S2 -> M11", "height difference M10 -> M11"})
    EXPECT_NE(text.find(words), std::string::npos) << words << " in " << text;
  EXPECT_NE(text.find("one end has no height"), std::string::npos);
  int directions = 0, others = 0;
  for (const ResultRow& row : r.rows)
    if (row.to == "M11") (row.kind == "direction" ? directions : others) += 1;
  EXPECT_EQ(directions, 3);
  EXPECT_EQ(others, 0);
}

/// An observation that takes no part takes its row and column of the covariance along.
TEST(Screening, TheRestOfACovarianceStays) {
  auto n = test::simulate({}, 62);
  Eigen::Matrix3d c = Eigen::Matrix3d::Identity() * 4e-10;
  c(0, 1) = c(1, 0) = 1.5e-10, c(0, 2) = c(2, 0) = -1e-10, c(1, 2) = c(2, 1) = 0.5e-10;
  SurveyObservations whole = n.survey, less = n.survey;
  Observation own = whole.observations[0];
  own.to = own.from;  // sights its own station
  const int at = static_cast<int>(whole.observations.size());
  whole.observations.push_back(own);
  whole.covariances.push_back({{0, at, 3}, c});
  Eigen::Matrix2d rest;
  rest << c(0, 0), c(0, 2), c(2, 0), c(2, 2);
  less.covariances.push_back({{0, 3}, rest});
  const NetworkResult a = adjust_network(whole, free_network()), b = adjust_network(less, free_network());
  EXPECT_NEAR(a.sum_of_squares, b.sum_of_squares, 1e-9);
  EXPECT_NEAR(a.point("M12").position.x(), b.point("M12").position.x(), 1e-12);
  EXPECT_NE(a.sum_of_squares, adjust_network(n.survey, free_network()).sum_of_squares);
}

TEST(Screening, APointWithoutAnyHeightIsNamed) {
  auto n = test::simulate({}, 62);
  std::erase_if(n.survey.observations,
                [](const Observation& o) { return o.to == "M11" && o.kind == ObservationKind::zenith_angle; });
  for (Observation& o : n.survey.observations)
    if (o.to == "M11" && o.kind == ObservationKind::slope_distance)
      o.kind = ObservationKind::horizontal_distance, o.sigma = 1;
  const std::string text = all_words(adjust_network(n.survey, free_network()));
  EXPECT_NE(text.find("no observation of the height of M11\n"), std::string::npos) << text;
  Observation level;
  level.kind = ObservationKind::height_difference, level.from = "M10", level.to = "bolt", level.value = 1,
  level.sigma = 0.001;
  n.survey.observations.push_back(level);
  const std::string levelled = all_words(adjust_network(n.survey, free_network()));
  EXPECT_NE(levelled.find("no observation of the plan position of bolt\n"), std::string::npos) << levelled;
}

TEST(Screening, PointsThatNobodyObservedAreNamedUnlessTheyAreGiven) {
  auto n = test::simulate({}, 62);
  const auto add = [&](const char* id, CoordinateRole plan, CoordinateRole height) {
    Point p;
    p.id = id, p.coordinates = {1, 2, 3}, p.roles = {plan, plan, height};
    n.survey.points.push_back(p);
  };
  add("bolt", CoordinateRole::free, CoordinateRole::fixed), add("pillar", CoordinateRole::fixed, CoordinateRole::free);
  add("lost", CoordinateRole::free, CoordinateRole::free);
  const std::string text = all_words(adjust_network(n.survey, free_network()));
  EXPECT_NE(text.find("no observation, left out: lost\n"), std::string::npos) << text;
}

/// Bytes of an artifact: what is beyond the faces, axes and set-ups there are is refused, not read.
TEST(Screening, NumbersThatPointNowhereAreRefused) {
  const auto refused = [](const std::function<void(SurveyObservations&)>& change) {
    auto n = test::simulate({}, 62);
    CoordinateGroup group;
    group.components = {{"M00", 0}};
    group.values = Eigen::VectorXd::Constant(1, 100);
    group.covariance = Eigen::MatrixXd::Identity(1, 1);
    n.survey.coordinates.push_back(group);
    change(n.survey);
    try {
      adjust_network(n.survey, free_network());
    } catch (const NetworkError&) {
      return true;
    }
    return false;
  };
  EXPECT_FALSE(refused([](SurveyObservations&) {}));
  for (const int wrong : {-1, 3, 255}) {
    EXPECT_TRUE(refused([&](SurveyObservations& s) { s.observations[4].face = wrong; })) << wrong;
    EXPECT_TRUE(refused([&](SurveyObservations& s) { s.coordinates[0].components[0].axis = wrong; })) << wrong;
    EXPECT_TRUE(refused([&](SurveyObservations& s) { s.observations[3].set_up = wrong; })) << "a direction " << wrong;
  }
  EXPECT_TRUE(refused([&](SurveyObservations& s) { s.observations[4].set_up = -2; }));
}

TEST(Screening, ACovarianceOfWhichNothingIsLeft) {
  auto n = test::simulate({}, 62);
  const double before = adjust_network(n.survey, free_network()).sum_of_squares;
  Observation own = n.survey.observations[0];
  own.to = own.from;  // sights its own station
  const int at = static_cast<int>(n.survey.observations.size());
  n.survey.observations.insert(n.survey.observations.end(), {own, own});
  n.survey.covariances.push_back({{at, at + 1}, 4e-10 * Eigen::Matrix2d::Identity()});
  EXPECT_NEAR(adjust_network(n.survey, free_network()).sum_of_squares, before, 1e-9);
}

/// Symmetric to nine digits of what it holds, whatever its size.
TEST(Screening, ACovarianceMustBeSymmetric) {
  auto n = test::simulate({}, 63);
  Eigen::Matrix2d c = Eigen::Matrix2d::Identity() * 4e-10;
  c(0, 1) = 1e-12;
  n.survey.covariances.push_back({{0, 3}, c});
  EXPECT_ANY_THROW(adjust_network(n.survey, free_network()));
  c(1, 0) = 1e-12;
  n.survey.covariances[0].covariance = c;
  EXPECT_NO_THROW(adjust_network(n.survey, free_network()));
}

TEST(Screening, ObservedCoordinatesAreNamedByTheirAxes) {
  auto n = test::simulate({}, 64);
  CoordinateGroup group;
  for (int axis = 0; axis < 3; ++axis) group.components.push_back({"M00", axis});
  group.values = n.truth[0];
  group.covariance = Eigen::Matrix3d::Identity() * 1e-6;
  group.source = {"control.csv", 7, 0};
  n.survey.coordinates.push_back(group);
  std::string axes;
  for (const ResultRow& row : adjust_network(n.survey, free_network()).rows)
    if (row.kind == "coordinate") {
      EXPECT_EQ(row.source.line, 7);
      EXPECT_EQ(row.value, n.truth[0][static_cast<Eigen::Index>(axes.size())]);
      axes += row.detail;
    }
  EXPECT_EQ(axes, "ENH");
  const NetworkResult r = adjust_network(n.survey, free_network());
  EXPECT_EQ(r.pointings.size(), 36u) << "observed coordinates are no sighting";
  for (const ResultPointing& p : r.pointings) EXPECT_FALSE(p.set_up.empty());
}

}  // namespace test_screening
}  // namespace plumbline::survey
