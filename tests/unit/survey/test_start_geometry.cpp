// What places a point at the start, piece by piece against a place that is known: plane loci, and every pair of
// observations of one point. Without noise, so that a construction that is a little wrong shows.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "simulated_network.hpp"
#include "survey/model/observation_equations.hpp"
#include "survey/start/approximate.hpp"
#include "survey/start/approximate_figure.hpp"
#include "test_support.hpp"

namespace plumbline::survey {
namespace test_start_geometry {

using Eigen::Vector2d;
using Eigen::Vector3d;
using K = ObservationKind;

class Places {
 public:
  explicit Places(std::uint64_t seed) : normal_(seed) {}
  double number(double from, double to) { return from + (to - from) * normal_.uniform(); }
  Vector2d place() { return {number(-100, 100), number(-100, 100)}; }

 private:
  test::Normal normal_;
};

double azimuth(const Vector2d& from, const Vector2d& to) { return std::atan2(to.x() - from.x(), to.y() - from.y()); }

Locus ray(const Vector2d& from, const Vector2d& to) {
  Locus l;
  l.origin = from, l.azimuth = azimuth(from, to);
  return l;
}

Locus circle(const Vector2d& about, const Vector2d& through) {
  Locus l;
  l.origin = about, l.radius = (through - about).norm();
  return l;
}

bool holds(const std::vector<Vector2d>& places, const Vector2d& p, double tolerance) {
  return std::any_of(places.begin(), places.end(), [&](const Vector2d& q) { return (p - q).norm() < tolerance; });
}

TEST(PlaneMotion, IsFoundFromTwoPointsOrMore) {
  Places random(1);
  for (int trial = 0; trial < 50; ++trial) {
    PlaneMotion truth;
    truth.rotation = random.number(-3, 3), truth.translation = random.place();
    std::vector<Vector2d> from, to;
    for (int i = 0; i < 2 + trial % 4; ++i) from.push_back(random.place()), to.push_back(truth(from.back()));
    const auto found = fit_plane(from, to);
    ASSERT_TRUE(found);
    EXPECT_NEAR(wrap_angle(found->rotation - truth.rotation), 0, 1e-9);
    EXPECT_LT((found->translation - truth.translation).norm(), 1e-9);
    EXPECT_LT(found->rms, 1e-9);
    // A rotation is clockwise: azimuths grow by it, lengths stay.
    EXPECT_NEAR(wrap_angle(azimuth(to[0], to[1]) - azimuth(from[0], from[1]) - truth.rotation), 0, 1e-9);
    EXPECT_NEAR((to[1] - to[0]).norm(), (from[1] - from[0]).norm(), 1e-9);
  }
  const std::vector<Vector2d> line = {{0, 0}, {10, 0}}, longer = {{0, 0}, {10.2, 0}};
  EXPECT_NEAR(fit_plane(line, longer)->rms, 0.1, 1e-12) << "no scale: a decimetre is left on either side";
  EXPECT_FALSE(fit_plane({{1, 1}}, {{2, 2}}));
  EXPECT_FALSE(fit_plane({{1, 1}, {1, 1}}, {{0, 0}, {5, 5}})) << "points that coincide have no direction";
  EXPECT_FALSE(fit_plane({{0, 0}, {5, 5}}, {{1, 1}, {1, 1}}));
}

TEST(Loci, EveryPairMeetsInThePointThatBothAreOf) {
  Places random(2);
  for (int trial = 0; trial < 100; ++trial) {
    const Vector2d p = random.place(), a = random.place(), b = random.place(), c = random.place();
    const double seen = azimuth(p, b) - azimuth(p, a);
    std::vector<Locus> loci = {ray(a, p), ray(b, p), circle(a, p), circle(c, p)};
    if (const auto angle = locus_of_angle(a, b, seen)) {
      EXPECT_NEAR((p - angle->origin).norm(), angle->radius, 1e-6 * angle->radius);
      EXPECT_LT(angle->misfit(p), 1e-6);
      const Vector2d mirrored = a + b - p;  // through the middle of the chord: sees it under the angle the other way
      EXPECT_GT(angle->misfit(mirrored), 1e-3);
      loci.push_back(*angle);
    }
    for (size_t i = 0; i < loci.size(); ++i)
      for (size_t j = 0; j < loci.size(); ++j) {
        EXPECT_LT(loci[i].misfit(p), 1e-6);
        if (i == j || (loci[i].origin - loci[j].origin).norm() < 1e-9) continue;
        const auto places = intersect(loci[i], loci[j]);
        const double cross = std::sin(loci[i].azimuth - loci[j].azimuth);
        if (std::abs(cross) < 0.03) continue;  // rays that are nearly parallel meet anywhere
        EXPECT_TRUE(holds(places, p, 1e-4)) << trial << " " << i << " " << j;
        EXPECT_LE(places.size(), 2u);
        for (const Vector2d& q : places)
          for (const size_t k : {i, j}) {
            if (std::isnan(loci[k].azimuth)) {
              EXPECT_NEAR((q - loci[k].origin).norm(), loci[k].radius, 1e-6 * loci[k].radius) << "on both circles";
            } else {
              EXPECT_LT(loci[k].misfit(q), 1e-6) << "before the instrument, not behind it";
            }
          }
      }
    const auto best = best_intersections(loci);
    ASSERT_FALSE(best.empty());
    EXPECT_LT((best.front() - p).norm(), 1e-3) << trial;
  }
}

TEST(Loci, MeetWithinWhatReadingsMayBeWrong) {
  const auto about = [](double x, double radius) {
    Locus l;
    l.origin = {x, 0}, l.radius = radius;
    return l;
  };
  // Apart by 2 %: between them. By 3 %: nothing.
  const auto between = intersect(about(0, 50), about(102, 50));
  ASSERT_EQ(between.size(), 1u);
  EXPECT_LT((between[0] - Vector2d(51, 0)).norm(), 1e-9);
  EXPECT_TRUE(intersect(about(0, 50), about(103, 50)).empty());
  EXPECT_EQ(intersect(about(0, 50), about(99, 50)).size(), 2u);
  EXPECT_EQ(intersect(about(0, 50), about(39, 10)).size(), 1u) << "one within the other, nearly touching";
  EXPECT_TRUE(intersect(about(0, 50), about(30, 10)).empty());
  EXPECT_TRUE(intersect(about(0, 50), about(0, 50)).empty()) << "the same circle";
  // A ray that passes a circle of 50 m at 50.2 m touches it; at 51 m it does not.
  Locus by;
  by.azimuth = 0, by.origin = {50.2, -100};
  ASSERT_EQ(intersect(by, about(0, 50)).size(), 1u);
  EXPECT_LT((intersect(by, about(0, 50))[0] - Vector2d(50.2, 0)).norm(), 1e-9);
  by.origin.x() = 51;
  EXPECT_TRUE(intersect(by, about(0, 50)).empty());
  by.origin = {0, 0};
  EXPECT_EQ(intersect(by, about(0, 50)).size(), 1u) << "from within: ahead only";
  EXPECT_FALSE(locus_of_angle({0, 0}, {1, 0}, 0.01)) << "nearly on the line through both";
  EXPECT_FALSE(locus_of_angle({0, 0}, {0.0005, 0}, 1));
  EXPECT_TRUE(locus_of_angle({0, 0}, {0.01, 0}, 1));
  EXPECT_TRUE(best_intersections({about(0, 10), about(100, 10)}).empty());
  EXPECT_EQ(best_intersections({about(0, 50), about(60, 50)}).size(), 2u) << "two circles leave two places";
}

TEST(Resection, FindsTheStationButNotOnTheDangerCircle) {
  Places random(3);
  for (int trial = 0; trial < 200; ++trial) {
    const Vector2d known[3] = {random.place(), random.place(), random.place()}, p = random.place();
    const double turn = random.number(0, 6);
    double directions[3];
    for (int i = 0; i < 3; ++i) directions[i] = azimuth(p, known[i]) - turn;
    const auto found = resection(known, directions);
    if (!found) continue;
    EXPECT_LT((*found - p).norm(), 1e-5) << trial;
  }
  const auto seen_from = [](const Vector2d& p) {
    const Vector2d known[3] = {{100, 0}, {0, 100}, {-100, 0}};
    double directions[3];
    for (int i = 0; i < 3; ++i) directions[i] = azimuth(p, known[i]);
    return resection(known, directions);
  };
  EXPECT_FALSE(seen_from({0, -100})) << "on the circle through the three";
  EXPECT_FALSE(seen_from({60, -80}));
  EXPECT_FALSE(seen_from({200, 0})) << "two of them behind one another";
  for (const Vector2d& p : {Vector2d(0, -50), Vector2d(0, 300), Vector2d(50, 20), Vector2d(-250, -40)}) {
    ASSERT_TRUE(seen_from(p));
    EXPECT_LT((*seen_from(p) - p).norm(), 1e-6);
  }
}

/// Observations of one point P among known ones, each exact.
class OnePoint {
 public:
  explicit OnePoint(std::uint64_t seed) {
    Places random(seed);
    places_ = {{"A", {0, 0, 10}}, {"B", {110, 10, 12}}, {"C", {30, 120, 17}}, {"D", {-60, 70, 8}}};
    for (auto& [id, p] : places_) p += Vector3d(random.number(-9, 9), random.number(-9, 9), random.number(-2, 2));
    places_["E"] = Vector3d(80, -70, 11);
    places_["P"] = Vector3d(random.number(10, 40), random.number(20, 60), random.number(5, 20));
    for (const auto& [id, p] : places_) {
      Point point;
      point.id = id;
      survey_.points.push_back(point);
    }
  }
  Vector3d d(const std::string& from, const std::string& to) const { return places_.at(to) - places_.at(from); }
  double azimuth_to(const std::string& from, const std::string& to) const {
    return azimuth(places_.at(from).head<2>(), places_.at(to).head<2>());
  }
  int set_up(const std::string& station) {
    survey_.set_ups.push_back({station + std::to_string(survey_.set_ups.size()), station, 1.6, {}});
    return static_cast<int>(survey_.set_ups.size()) - 1;
  }
  void add(ObservationKind kind, const std::string& from, const std::string& to, double value, int set_up = -1,
           const std::string& second = "") {
    Observation o;
    o.kind = kind, o.from = from, o.to = to, o.second_to = second, o.value = value, o.set_up = set_up;
    o.target_height = set_up >= 0 ? 0.3 : kNotGiven;
    survey_.observations.push_back(o);
  }
  void direction(int set_up, const std::string& from, const std::string& to, double turn) {
    add(ObservationKind::direction, from, to, wrap_angle(azimuth_to(from, to) - turn), set_up);
  }
  /// Slope and zenith angle from axis to target.
  void sight(int set_up, const std::string& from, const std::string& to) {
    const Vector3d s = d(from, to) + Vector3d(0, 0, 0.3 - 1.6);
    add(ObservationKind::slope_distance, from, to, s.norm(), set_up);
    add(ObservationKind::zenith_angle, from, to, std::atan2(s.head<2>().norm(), s.z()), set_up);
  }
  SurveyObservations& survey() { return survey_; }

  /// How near to P the nearest of the places found for it is, in plan and height [m]; nan: none was found.
  Vector2d distance_from_truth() const {
    std::map<std::string, Vector3d> known = places_;
    known.erase("P");
    Vector2d nearest = Vector2d::Constant(kNotGiven);
    for (const Approximation& a : approximate_coordinates(survey_, mean_observations(survey_).observations, known)) {
      const auto at = a.points.find("P");
      if (at == a.points.end()) continue;
      const Vector3d e = at->second - places_.at("P");
      const Vector2d distance(e.head<2>().norm(), std::abs(e.z()));
      if (!(nearest.x() <= distance.x())) nearest = distance;
    }
    return nearest;
  }

 private:
  std::map<std::string, Vector3d> places_;
  SurveyObservations survey_;
};

struct Piece {
  const char* name;
  std::function<void(OnePoint&)> add;
  bool alone = false;   ///< determines the plan by itself
  bool height = false;  ///< and the height
};

/// Each from other stations, so that no two of them are on the same line.
std::vector<Piece> pieces() {
  const auto horizontal = [](OnePoint& n, const char* from, const char* to) {
    n.add(K::horizontal_distance, from, to, n.d(from, to).head<2>().norm());
  };
  return {{"azimuth from A", [](OnePoint& n) { n.add(K::azimuth, "A", "P", n.azimuth_to("A", "P")); }},
          {"azimuth to B", [](OnePoint& n) { n.add(K::azimuth, "P", "B", n.azimuth_to("P", "B")); }},
          {"oriented set-up on C",
           [](OnePoint& n) {
             const int s = n.set_up("C");
             for (const char* to : {"D", "P"}) n.direction(s, "C", to, 1.1);
           }},
          {"distance from D", [&, horizontal](OnePoint& n) { horizontal(n, "D", "P"); }},
          {"distance to A", [&, horizontal](OnePoint& n) { horizontal(n, "P", "A"); }},
          {"angle at P",
           [](OnePoint& n) {
             n.add(K::angle, "P", "B", wrap_angle(n.azimuth_to("P", "D") - n.azimuth_to("P", "B")), -1, "D");
           }},
          {"angle at D",
           [](OnePoint& n) {
             n.add(K::angle, "D", "P", wrap_angle(n.azimuth_to("D", "C") - n.azimuth_to("D", "P")), -1, "C");
           }},
          {"resection",
           [](OnePoint& n) {
             const int s = n.set_up("P");
             for (const char* to : {"A", "B", "C", "D"}) n.direction(s, "P", to, -2.3);
           },
           true},
          {"free station",
           [](OnePoint& n) {
             const int s = n.set_up("P");
             for (const char* to : {"A", "D"}) n.direction(s, "P", to, 0.4), n.sight(s, "P", to);
           },
           true, true},
          {"polar from B",
           [](OnePoint& n) {
             const int s = n.set_up("B");
             n.direction(s, "B", "A", 2.9), n.direction(s, "B", "P", 2.9), n.sight(s, "B", "P");
           },
           true, true},
          {"vector",
           [](OnePoint& n) {
             VectorGroup g;
             g.vectors = {{"C", "P"}};
             g.values = n.d("C", "P");
             g.covariance = 1e-6 * Eigen::Matrix3d::Identity();
             n.survey().vectors.push_back(g);
           },
           true, true},
          {"local coordinates",
           [](OnePoint& n) {
             const int s = n.set_up("P");
             for (const char* to : {"B", "C"}) {
               LocalCoordinate c;
               c.set_up = s, c.point = to, c.target_height = 0.3;
               c.position = Eigen::AngleAxisd(0.7, Vector3d::UnitZ()) * (n.d("P", to) + Vector3d(0, 0, 0.3 - 1.6));
               n.survey().local_coordinates.push_back(c);
             }
           },
           true, true}};
}

TEST(OnePointFrom, EveryPairOfObservationsIsWhereItIs) {
  const std::vector<Piece> all = pieces();
  for (std::uint64_t seed = 11; seed < 14; ++seed)
    for (size_t i = 0; i < all.size(); ++i)
      for (size_t j = i; j < all.size(); ++j) {
        if (i == j && !all[i].alone) continue;
        OnePoint n(seed);
        all[i].add(n);
        if (j != i) all[j].add(n);
        const bool height = all[i].height || all[j].height;
        if (!height) n.add(ObservationKind::height_difference, "A", "P", n.d("A", "P").z());
        const Vector2d off = n.distance_from_truth();
        EXPECT_LT(off.x(), 1e-3) << seed << ": " << all[i].name << " and " << all[j].name;
        EXPECT_LT(off.y(), 1e-3) << seed << ": height by " << all[i].name << " and " << all[j].name;
      }
}

/// Of several resections the one that the other directions agree with.
TEST(OnePointFrom, OneWrongDirectionOfFiveDoesNotPlaceTheStation) {
  for (const int wrong : {1, 4}) {  // in the first triple, in the last
    OnePoint n(15);
    const int s = n.set_up("P");
    for (const char* to : {"A", "B", "C", "D", "E"}) n.direction(s, "P", to, 0.3);
    n.survey().observations[wrong].value += 0.3;
    n.add(ObservationKind::height_difference, "A", "P", n.d("A", "P").z());
    EXPECT_LT(n.distance_from_truth().x(), 1e-3) << wrong;
  }
}

TEST(Figures, WhatStandsOverheadHasNoHeightByItsZenithAngle) {
  OnePoint n(16);
  const int s = n.set_up("B");
  n.add(ObservationKind::zenith_angle, "B", "P", 1e-4, s),
      n.add(ObservationKind::horizontal_distance, "B", "P", 0.5, s);
  n.add(ObservationKind::zenith_angle, "B", "A", 1.0, s), n.add(ObservationKind::horizontal_distance, "B", "A", 10, s);
  const Figures f = make_figures(n.survey(), mean_observations(n.survey()).observations);
  ASSERT_EQ(f.figures.at(0).sights.size(), 2u);
  EXPECT_TRUE(std::isnan(f.figures[0].sights[0].height_difference));
  EXPECT_NEAR(f.figures[0].sights[1].height_difference, 10 / std::tan(1.0) + 1.6 - 0.3, 1e-9);
  Observation levelled;
  levelled.kind = ObservationKind::height_difference, levelled.from = "A", levelled.to = "P", levelled.value = 2;
  levelled.instrument_height = 1.5, levelled.target_height = 0.4;
  n.survey().observations = {levelled};
  EXPECT_NEAR(make_figures(n.survey(), mean_observations(n.survey()).observations).height_differences.at(0).value, 3.1,
              1e-9);
}

TEST(OnePointFrom, HeightsComeByEveryWay) {
  const std::vector<Piece> ways = {
      {"levelled to it", [](OnePoint& n) { n.add(K::height_difference, "B", "P", n.d("B", "P").z()); }},
      {"levelled from it", [](OnePoint& n) { n.add(K::height_difference, "P", "B", n.d("P", "B").z()); }},
      {"zenith angle of its own",
       [](OnePoint& n) {
         n.add(K::zenith_angle, "D", "P", std::atan2(n.d("D", "P").head<2>().norm(), n.d("D", "P").z()));
       }},
      {"sight from a set-up", [](OnePoint& n) { n.sight(n.set_up("B"), "B", "P"); }},
      {"sight from the point", [](OnePoint& n) { n.sight(n.set_up("P"), "P", "D"); }}};
  for (std::uint64_t seed = 21; seed < 24; ++seed)
    for (const Piece& way : ways) {
      OnePoint n(seed);
      n.add(K::azimuth, "A", "P", n.azimuth_to("A", "P"));
      n.add(K::azimuth, "C", "P", n.azimuth_to("C", "P"));
      way.add(n);
      EXPECT_LT(n.distance_from_truth().y(), 1e-3) << seed << ": " << way.name;
    }
}

/// Slope distances, zenith angles and azimuths from three stations, none of which gives a plan alone.
TEST(OnePointFrom, ThreeObservationsInSpace) {
  const auto slope = [](OnePoint& n, const char* from, const char* to) {
    n.add(K::slope_distance, from, to, n.d(from, to).norm());
  };
  const auto zenith = [](OnePoint& n, const char* from, const char* to) {
    n.add(K::zenith_angle, from, to, std::atan2(n.d(from, to).head<2>().norm(), n.d(from, to).z()));
  };
  for (std::uint64_t seed = 31; seed < 37; ++seed) {
    OnePoint spheres(seed);
    for (const char* from : {"A", "B", "C", "D"}) slope(spheres, from, "P");
    EXPECT_LT(spheres.distance_from_truth().norm(), 1e-3) << seed << ": four slope distances";
    OnePoint three(seed);
    slope(three, "A", "P"), slope(three, "P", "B"), slope(three, "C", "P");
    EXPECT_LT(three.distance_from_truth().norm(), 1e-3) << seed << ": three slope distances";
    OnePoint mixed(seed);
    slope(mixed, "P", "A"), zenith(mixed, "B", "P"), mixed.add(K::azimuth, "C", "P", mixed.azimuth_to("C", "P"));
    EXPECT_LT(mixed.distance_from_truth().norm(), 0.01) << seed << ": slope, zenith angle, azimuth";
    OnePoint from_it(seed);
    zenith(from_it, "P", "A"), slope(from_it, "D", "P"),
        from_it.add(K::azimuth, "P", "B", from_it.azimuth_to("P", "B"));
    EXPECT_LT(from_it.distance_from_truth().norm(), 0.01) << seed << ": the same, observed from it";
  }
}

/// Nothing is known: the beginning of the first vector is the origin, and north is right.
TEST(FreeStart, VectorsAloneMakeAFrame) {
  SurveyObservations s;
  VectorGroup g;
  g.vectors = {{"A", "B"}, {"B", "C"}, {"D", "C"}};
  g.values.resize(9);
  g.values << 10, 20, 1, -5, 7, 2, 3, 4, -1;
  g.covariance = 1e-6 * Eigen::MatrixXd::Identity(9, 9);
  s.vectors.push_back(g);
  const auto all = approximate_coordinates(s, {}, {});
  ASSERT_EQ(all.size(), 1u);
  const auto& p = all[0].points;
  ASSERT_EQ(p.size(), 4u);
  EXPECT_LT((p.at("B") - p.at("A") - Vector3d(10, 20, 1)).norm(), 1e-9);
  EXPECT_LT((p.at("C") - p.at("B") - Vector3d(-5, 7, 2)).norm(), 1e-9);
  EXPECT_LT((p.at("C") - p.at("D") - Vector3d(3, 4, -1)).norm(), 1e-9);
}

/// A shape from angles alone takes the length of its one distance, wherever that is.
TEST(FreeStart, AnglesTakeTheScaleOfOneDistance) {
  const std::map<std::string, Vector2d> truth = {{"A", {0, 0}}, {"B", {300, 40}}, {"C", {120, 260}}, {"D", {420, 300}}};
  for (const auto& [one, other] : {std::pair{"A", "B"}, {"C", "D"}}) {
    SurveyObservations s;
    const auto add = [&](K kind, const std::string& from, const std::string& to, double value,
                         const std::string& second) {
      Observation o;
      o.kind = kind, o.from = from, o.to = to, o.second_to = second, o.value = value;
      s.observations.push_back(o);
    };
    for (const char* t : {"ABC", "BCA", "CAB", "BDC", "DCB", "CBD"}) {
      const std::string at(1, t[0]), left(1, t[1]), right(1, t[2]);
      add(K::angle, at, left,
          wrap_angle(azimuth(truth.at(at), truth.at(right)) - azimuth(truth.at(at), truth.at(left))), right);
    }
    add(K::horizontal_distance, one, other, (truth.at(other) - truth.at(one)).norm(), "");
    for (const auto& [id, p] : truth) {
      Point point;
      point.id = id, point.roles[2] = CoordinateRole::unused;
      s.points.push_back(point);
    }
    const auto all = approximate_coordinates(s, mean_observations(s).observations, {});
    ASSERT_FALSE(all.empty());
    for (const auto& [a, b] : {std::pair{"A", "B"}, {"A", "D"}, {"C", "D"}, {"B", "C"}})
      EXPECT_NEAR((all[0].points.at(a) - all[0].points.at(b)).head<2>().norm(), (truth.at(a) - truth.at(b)).norm(),
                  1e-6)
          << a << b << " by " << one << other;
  }
}

}  // namespace test_start_geometry
}  // namespace plumbline::survey
