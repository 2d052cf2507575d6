// What joining files says of tables of points among them, and of coordinates that two files have.
#include <gtest/gtest.h>

#include "survey/adjust/adjust_network.hpp"
#include "survey/start/merge_surveys.hpp"

namespace plumbline::survey {
namespace test_merged_tables {

Point point_at(const std::string& id, double e, double n, double h) {
  Point p;
  p.id = id;
  p.coordinates = {e, n, h};
  return p;
}

SurveyObservations sights(const std::vector<std::string>& targets) {
  SurveyObservations s;
  s.files = {"day.csv"};
  s.set_ups.push_back({"S1", "S1", kNotGiven, {}});
  for (const std::string& to : targets) {
    Observation o;
    o.kind = ObservationKind::direction;
    o.set_up = 0, o.from = "S1", o.to = to;
    s.observations.push_back(o);
  }
  return s;
}

std::string words(const std::vector<SurveyObservations>& all) {
  std::string text;
  for (const Finding& f : merge_surveys(all, {}).findings) text += f.text + "\n";
  return text;
}

/// Three known points as a file of `survey:` came out as approximate values, and nobody was told.
TEST(MergedTables, ATableOfPointsThatOthersSightIsNoControlAndThatIsSaid) {
  SurveyObservations table;
  table.files = {"pts.csv"};
  for (const char* id : {"K1", "K2", "K3"}) table.points.push_back(point_at(id, 500, 600, 100));
  const std::string said = words({sights({"K1", "K2", "K3", "P1"}), table});
  EXPECT_NE(said.find("pts has coordinates of 3 points that the other files sight (K1, K2, K3) and no readings"),
            std::string::npos)
      << said;
  EXPECT_NE(said.find("give the file as the control"), std::string::npos) << said;
  // One that nobody sights, or that is held by its file, is told of elsewhere.
  EXPECT_EQ(words({sights({"P1", "P2"}), table}).find("and no readings"), std::string::npos);
  for (Point& p : table.points) p.roles.fill(CoordinateRole::fixed);
  EXPECT_EQ(words({sights({"K1", "K2", "K3"}), table}).find("and no readings"), std::string::npos);
}

/// K1 is known in both, 400 mm apart, T1 approximate, 20 mm apart: "differ by up to 0.400 m" was said of T1.
TEST(MergedTables, HowFarApproximateCoordinatesDifferIsTheirOwn) {
  SurveyObservations a = sights({"K1", "T1", "T2", "T3"}), b = a;
  for (SurveyObservations* s : {&a, &b}) {
    const double off = s == &b ? 1 : 0;
    s->points = {point_at("K1", 500 + 0.4 * off, 600, 100), point_at("T1", 510 + 0.02 * off, 600, 100),
                 point_at("T2", 520, 600, 100), point_at("T3", 530, 600, 100)};
    s->points[0].known = {true, true, true};
  }
  b.observations[0].to = "T4";
  const std::string said = words({a, b});
  EXPECT_NE(said.find("K1 (E 500.000 m and 500.400 m)"), std::string::npos) << said;
  EXPECT_NE(said.find("the coordinates of T1"), std::string::npos) << said;
  EXPECT_NE(said.find("by up to 0.020 m"), std::string::npos) << said;
}

}  // namespace test_merged_tables
}  // namespace plumbline::survey
