// Set-ups as figures of polar coordinates: what a figure holds, how it is fitted, and where the chain puts everything.
#include <Eigen/Core>
#include <cmath>
#include <numbers>
#include <set>

#include "plumbline/stop.hpp"
#include "simulated_network.hpp"
#include "survey/model/observation_equations.hpp"
#include "survey/start/approximate_figure.hpp"
#include "survey/start/set_up_chain.hpp"
#include "test_support.hpp"

namespace plumbline::survey {
namespace test_set_up_chain {

using Eigen::Vector2d;
using Eigen::Vector3d;
using K = ObservationKind;

SetUpChain chain_of(const SurveyObservations& survey) {
  return SetUpChain(survey, mean_observations(survey).observations, built_in_profile("total_station_1arcsec"));
}

/// One set-up on S, 1.5 m high, at the origin of its own frame.
SurveyObservations one_set_up(const std::vector<std::tuple<K, std::string, double, double>>& readings) {
  SurveyObservations s;
  s.set_ups.push_back({"S", "S", 1.5, {}});
  for (const auto& [kind, to, value, target_height] : readings) {
    Observation o;
    o.kind = kind, o.set_up = 0, o.from = "S", o.to = to, o.value = value, o.target_height = target_height;
    s.observations.push_back(o);
  }
  return s;
}

TEST(SetUpFigure, IsWhatWasRead) {
  constexpr double kZenith = 1.4;
  const SurveyObservations s = one_set_up({{K::direction, "A", 0.5, 0.2},
                                           {K::zenith_angle, "A", kZenith, 0.2},
                                           {K::slope_distance, "A", 500, 0.2},
                                           {K::direction, "B", 1.0, 0},  // in the plane
                                           {K::horizontal_distance, "B", 40, 0},
                                           {K::direction, "C", 2.0, 0},  // a slope without its zenith angle
                                           {K::slope_distance, "C", 30, 0},
                                           {K::direction, "S", 2.0, 0},  // its own station
                                           {K::horizontal_distance, "S", 5, 0},
                                           {K::direction, "D", 2.5, 0},  // overhead: no direction
                                           {K::zenith_angle, "D", 1e-4, 0},
                                           {K::slope_distance, "D", 9, 0},
                                           {K::zenith_angle, "E", 1.2, 0},  // a sight without direction
                                           {K::slope_distance, "E", 9, 0}});
  const SetUpChain chain = chain_of(s);
  ASSERT_EQ(chain.figures().size(), 1u);
  const auto& sights = chain.figures()[0].sights;
  ASSERT_EQ(sights.size(), 3u);
  const InstrumentProfile p = built_in_profile("total_station_1arcsec");
  EXPECT_EQ(sights[0].point, "S");
  EXPECT_EQ(sights[0].order, -1);
  EXPECT_NEAR(sights[0].sigma, p.instrument_centring + p.height_centring, 1e-12);
  const InstrumentProfile seen = p.without_instrument_centring();  // that is the mark's
  const double h = 500 * std::sin(kZenith);
  EXPECT_EQ(sights[1].point, "A");
  EXPECT_NEAR(sights[1].ray.x(), h * std::sin(0.5), 1e-9);
  EXPECT_NEAR(sights[1].ray.y(), h * std::cos(0.5), 1e-9);
  EXPECT_NEAR(sights[1].ray.z(), 500 * std::cos(kZenith) + h * h / (2 * kEarthRadius), 1e-9) << "19 mm of curvature";
  EXPECT_NEAR(sights[1].heights, 1.3, 1e-12);
  EXPECT_EQ(sights[1].order, 0);
  EXPECT_EQ(sights[1].observations.size(), 3u);
  EXPECT_NEAR(
      sights[1].sigma,
      std::max({h * seen.direction(h, 500, 1, false), seen.distance(500, 1), 500 * seen.zenith_angle(500, 1, false)}),
      1e-9);
  EXPECT_EQ(sights[2].point, "B");
  EXPECT_TRUE(std::isnan(sights[2].ray.z()));
  EXPECT_NEAR(sights[2].ray.head<2>().norm(), 40, 1e-9);
}

TEST(SetUpFigure, TheLargestStandardDeviationOfTheFileCounts) {
  for (const K worst : {K::direction, K::zenith_angle, K::slope_distance}) {
    SurveyObservations s =
        one_set_up({{K::direction, "A", 0.5, 0}, {K::zenith_angle, "A", 1.2, 0}, {K::slope_distance, "A", 100, 0}});
    for (Observation& o : s.observations)
      o.sigma = (o.kind == K::slope_distance ? 1e-3 : 1e-5) * (o.kind == worst ? 20 : 1);
    const double across = worst == K::slope_distance ? 0.02 : worst == K::zenith_angle ? 0.02 : 0.02 * std::sin(1.2);
    EXPECT_NEAR(chain_of(s).figures().at(0).sights.at(1).sigma, across, 1e-9);
  }
}

TEST(SetUpFigure, TwoTargetHeightsAreTwoSights) {
  const SurveyObservations s = one_set_up({{K::direction, "A", 0.5, 0},
                                           {K::horizontal_distance, "A", 40, 0},
                                           {K::direction, "A", 0.5, 2},
                                           {K::horizontal_distance, "A", 40, 2}});
  EXPECT_EQ(chain_of(s).figures().at(0).sights.size(), 3u);
}

/// Pairs whose targets are the sights turned and shifted, with noise that is known.
struct Fitted {
  std::vector<LocalSight> sights;
  std::vector<FigurePair> pairs;
  Fitted(double rotation, const Vector3d& shift, double noise, std::uint64_t seed, size_t count = 7) : sights(count) {
    test::Normal normal(seed);
    FigureFit truth;
    truth.rotation = rotation, truth.shift = shift;
    for (size_t i = 0; i < count; ++i) {
      sights[i].ray = {30 * (normal.uniform() - 0.5), 10 + 20 * normal.uniform(), 4 * normal.uniform()};
      const Vector3d target = truth(sights[i]) + noise * Vector3d(normal(), normal(), normal());
      pairs.push_back({&sights[i], target, 0.05});
    }
  }
};

TEST(FitRobustly, IsTheLeastSquaresFitOfThoseThatAgree) {
  Fitted n(2.1, {100, 200, 30}, 0.003, 4);
  std::vector<Vector2d> from, to;
  double lift = 0;
  for (const FigurePair& p : n.pairs) {
    from.push_back(p.sight->ray.head<2>()), to.push_back(p.target.head<2>());
    lift += (p.target.z() - p.sight->ray.z()) / static_cast<double>(n.pairs.size());
  }
  const auto expected = fit_plane(from, to);
  const auto fit = fit_robustly(n.pairs, 1);
  ASSERT_TRUE(fit && expected);
  EXPECT_EQ(fit->agree, 7);
  EXPECT_EQ(fit->compared, 7);
  EXPECT_NEAR(wrap_angle(fit->rotation - expected->rotation), 0, 1e-12);
  EXPECT_NEAR((fit->shift.head<2>() - expected->translation).norm(), 0, 1e-9);
  EXPECT_NEAR(fit->shift.z(), lift, 1e-12);

  // Gross ones, in plan and in height, do not count; what has no height counts in plan.
  n.pairs[1].target.x() += 3, n.pairs[4].target.z() -= 1;
  n.pairs[2].target.z() = kNotGiven;
  const auto robust = fit_robustly(n.pairs, 1);
  ASSERT_TRUE(robust);
  EXPECT_EQ(robust->agree, 5);
  EXPECT_NEAR(wrap_angle(robust->rotation - 2.1), 0, 0.002);
  EXPECT_NEAR((robust->shift - Vector3d(100, 200, 30)).norm(), 0, 0.02);
}

TEST(FitRobustly, WeighsByTheTolerance) {
  Fitted n(0, Vector3d::Zero(), 0, 5, 6);
  for (size_t i = 0; i < 6; ++i) {
    n.pairs[i].tolerance = i < 3 ? 0.01 : 0.02;
    n.pairs[i].target += Vector3d(0, 0, i < 3 ? 0.001 : -0.003);
  }
  EXPECT_NEAR(fit_robustly(n.pairs, 1)->shift.z(), (3e4 * 0.001 - 0.75e4 * 0.003) / 3.75e4, 1e-12);
  for (size_t i = 0; i < 6; ++i) n.pairs[i].target = n.sights[i].ray + Vector3d(i < 3 ? 0.001 : -0.003, 0, 0);
  const auto fit = fit_robustly(n.pairs, 1);
  Vector2d weighted = Vector2d::Zero();  // the residuals' weighted mean is zero
  for (const FigurePair& p : n.pairs) weighted += ((*fit)(*p.sight) - p.target).head<2>() / (p.tolerance * p.tolerance);
  EXPECT_NEAR(weighted.norm(), 0, 1e-6);
}

TEST(FitRobustly, RefusesWhatNoTwoAgreeOn) {
  Fitted n(1, {5, 5, 0}, 0, 6, 2);
  EXPECT_TRUE(fit_robustly(n.pairs, 1));
  n.pairs[0].target.z() += 1;
  EXPECT_FALSE(fit_robustly(n.pairs, 1)) << "two heights that differ";
  n.pairs.pop_back();
  EXPECT_FALSE(fit_robustly(n.pairs, 1));
  Fitted close(1, {5, 5, 0}, 0, 6, 2);
  close.sights[1].ray = close.sights[0].ray + Vector3d(0.05, 0, 0);
  close.pairs[1].target = close.pairs[0].target + Vector3d(0.05, 0, 0);
  EXPECT_FALSE(fit_robustly(close.pairs, 1)) << "nearer to each other than they are known: no direction";
}

TEST(WithConstant, FindsAPrismAndNothingWhereThereIsNone) {
  for (const double constant : {0.0344, -0.0175}) {
    Fitted n(0.4, {3, 2, 1}, 0, 7, 8);
    for (FigurePair& p : n.pairs) p.tolerance = 0.006;
    for (LocalSight& s : n.sights) s.ray *= 1 + constant / s.ray.norm();
    const auto plain = fit_robustly(n.pairs, 1);
    ASSERT_TRUE(plain);
    const FigureFit fit = with_constant(n.pairs, *plain);
    EXPECT_NEAR(fit.constant, constant, 0.004);
    EXPECT_EQ(fit.agree, 8);
  }
  Fitted sound(0.4, {3, 2, 1}, 0.001, 8, 8);
  sound.pairs[3].target.x() += 0.5;
  EXPECT_EQ(with_constant(sound.pairs, *fit_robustly(sound.pairs, 1)).constant, 0) << "one that is off is no prism";
}

test::SimulatedNetwork without_coordinates(std::uint64_t seed, double noise = 0) {
  test::SimulationSettings settings;
  settings.coordinates = false, settings.noise = noise, settings.set_ups = 4;
  return test::simulate(settings, seed);
}

std::map<std::string, Vector3d> known_points(const test::SimulatedNetwork& n, size_t count) {
  std::map<std::string, Vector3d> known;
  for (size_t i = 0; i < count; ++i) known[n.survey.points[3 * i].id] = n.truth[3 * i];
  return known;
}

void expect_truth(const test::SimulatedNetwork& n, const ChainStart& start, double tolerance) {
  EXPECT_EQ(start.points.size(), n.truth.size());
  for (size_t i = 0; i < n.truth.size(); ++i)
    EXPECT_LT((start.points.at(n.survey.points[i].id) - n.truth[i]).norm(), tolerance) << n.survey.points[i].id;
  for (size_t i = 0; i < start.orientations.size(); ++i)
    EXPECT_NEAR(wrap_angle(start.orientations[i] - (0.7 + 1.9 * static_cast<double>(i))), 0, tolerance);
}

TEST(SetUpChain, PutsEveryPointWhereItIs) {
  const auto n = without_coordinates(31);
  const SetUpChain chain = chain_of(n.survey);
  for (const std::string& id : chain.points()) {
    const auto place = chain.place_of(id);
    ASSERT_TRUE(place) << id;
    EXPECT_EQ(place->views, id[0] == 'S' ? 1 : 4);
    EXPECT_EQ(place->agree, place->views);
    EXPECT_EQ(chain.place_of(id, 2).has_value(), id != "S3") << "nothing but its own set-up says where S3 is";
  }
  const auto start = start_from_chain(chain, 4, known_points(n, 4));
  ASSERT_TRUE(start);
  expect_truth(n, *start, 1e-3);  // curvature over 15 m is far below that
  auto wrong = known_points(n, 4);
  wrong.begin()->second.x() += 5;
  ASSERT_TRUE(start_from_chain(chain, 4, wrong)) << "one of four";
  expect_truth(n, *start_from_chain(chain, 4, wrong), 1e-3);
  (++wrong.begin())->second.y() -= 7;
  EXPECT_FALSE(start_from_chain(chain, 4, wrong)) << "two of four: who is right?";
}

long asks = 0;
bool nobody_waits(const void*) {
  ++asks;
  return false;
}

/// Many set-ups over the same markers: each is fitted a few times, not once for each set-up before it. It asks whether
/// anybody waits at each fit.
TEST(SetUpChain, TakesTwiceAsLongForTwiceAsManySetUps) {
  const auto fits = [](int set_ups) {
    test::SimulationSettings settings;
    settings.columns = 4, settings.rows = 3, settings.set_ups = set_ups, settings.coordinates = false;
    const auto n = test::simulate(settings, 41);
    asks = 0;
    const StopScope scope(&nobody_waits, nullptr);
    const SetUpChain chain = chain_of(n.survey);
    for (size_t f = 0; f < chain.figures().size(); ++f) EXPECT_TRUE(chain.placed(f));
    return asks;
  };
  const long few = fits(12), many = fits(36);
  EXPECT_GT(few, 12);
  EXPECT_LT(many, 4 * few) << few;
}

TEST(SetUpChain, WithoutKnownPointsItBeginsAtTheLargestSetUp) {
  auto n = without_coordinates(32);
  std::erase_if(n.survey.observations, [](const Observation& o) { return o.set_up != 2 && o.to == "M11"; });
  const auto start = start_from_chain(chain_of(n.survey), 4, {});
  ASSERT_TRUE(start);
  EXPECT_LT(start->points.at("S3").norm(), 1e-9);
  EXPECT_NEAR(start->orientations[2], 0, 1e-12);
  for (const auto& [a, b] : {std::pair{0, 5}, {3, 13}, {12, 15}})
    EXPECT_NEAR((start->points.at(n.survey.points[a].id) - start->points.at(n.survey.points[b].id)).norm(),
                (n.truth[a] - n.truth[b]).norm(), 1e-3);
}

TEST(SetUpChain, AGrossViewIsNotInTheMean) {
  auto n = without_coordinates(33);
  for (Observation& o : n.survey.observations)
    if (o.set_up == 1 && o.to == "M12" && o.kind == K::slope_distance) o.value += 0.4;
  const SetUpChain chain = chain_of(n.survey);
  const auto place = chain.place_of("M12");
  ASSERT_TRUE(place);
  EXPECT_EQ(place->views, 4);
  EXPECT_EQ(place->agree, 3);
  expect_truth(n, *start_from_chain(chain, 4, known_points(n, 4)), 1e-3);
}

TEST(SetUpChain, ASetUpInFeetIsSeenByItsScale) {
  auto n = without_coordinates(34);
  for (Observation& o : n.survey.observations)
    if (o.set_up == 1 && o.kind == K::slope_distance) o.value /= 0.3048;
  const SetUpChain chain = chain_of(n.survey);
  for (size_t f = 0; f < chain.figures().size(); ++f) {
    ASSERT_TRUE(chain.placed(f));
    EXPECT_NEAR(chain.fit(f).scale, chain.figures()[f].set_up == 1 ? 0.3048 : 1, 1e-12);
  }
  expect_truth(n, *start_from_chain(chain, 4, known_points(n, 4)), 1e-3);
}

/// Set-ups in the plane: what each of them sees, in its own frame.
SurveyObservations planar(const std::vector<std::map<std::string, Vector2d>>& seen) {
  SurveyObservations s;
  for (size_t f = 0; f < seen.size(); ++f) {
    const std::string station = "S" + std::to_string(f);
    s.set_ups.push_back({station, station, 0, {}});
    for (const auto& [point, place] : seen[f])
      for (const K kind : {K::direction, K::horizontal_distance}) {
        Observation o;
        o.kind = kind, o.set_up = static_cast<int>(f), o.from = station, o.to = point;
        o.value = kind == K::direction ? wrap_angle(std::atan2(place.x(), place.y())) : place.norm();
        s.observations.push_back(o);
      }
  }
  return s;
}

/// Each of four set-ups shares four points with the first, which has two of them where they are and two metres away:
/// two that agree by chance. Two of the four share three points that are sound, and it is these that are a beginning:
/// from the first nothing else could be placed.
TEST(SetUpChain, DoesNotBeginWhereTwoAgreeByChance) {
  std::vector<std::map<std::string, Vector2d>> seen(5);
  for (size_t f = 1; f < 5; ++f)
    for (int k = 0; k < 4; ++k) {
      const std::string point = std::string(1, static_cast<char>('A' + f)) + std::to_string(k);
      const Vector2d place(10 + 7 * k, 12 + 3 * (k * k % 5) + static_cast<double>(f));
      seen[f][point] = place;
      seen[0][point] =
          place + Vector2d(20.0 * static_cast<double>(f), 0) + (k < 2 ? Vector2d(0, 0) : Vector2d(3, 2 + k));
    }
  for (int k = 0; k < 3; ++k)
    for (const size_t f : {1u, 2u})
      seen[f]["Q" + std::to_string(k)] =
          Vector2d(-10 + 4 * k, 8 + 5 * (k % 2)) + Vector2d(0, 2.0 * static_cast<double>(f));
  const SetUpChain chain = chain_of(planar(seen));
  ASSERT_EQ(chain.figures().size(), 5u);
  EXPECT_TRUE(chain.placed(1));
  EXPECT_TRUE(chain.placed(2));
  EXPECT_FALSE(chain.placed(0)) << "nobody knows where";
}

/// Two shared points that agree are all there can be: they count, and who has them with most others is the beginning.
TEST(SetUpChain, BeginsAtTheSetUpThatMostAgreeWith) {
  std::vector<std::map<std::string, Vector2d>> seen(
      7);  // the first shares two points with each, the second and third three
  FigureFit turn;
  turn.rotation = 0.8;
  const auto share = [&](size_t a, size_t b, const std::string& point, const Vector2d& place) {
    seen[a][point] = place;
    LocalSight sight;
    sight.ray = {place.x(), place.y(), 0};
    seen[b][point] = turn(sight).head<2>() + Vector2d(1.0, 2.0 * static_cast<double>(b));
  };
  for (size_t f = 1; f < 7; ++f)
    for (int k = 0; k < 2; ++k)
      if (f != 2)
        share(0, f, std::string(1, static_cast<char>('A' + f)) + std::to_string(k),
              {9.0 + 8 * k, 10.0 + static_cast<double>(f) + 3 * k});
  for (int k = 0; k < 3; ++k) share(1, 2, "Q" + std::to_string(k), {-12.0 + 5 * k, 15.0 - 4 * (k % 2)});
  const SetUpChain chain = chain_of(planar(seen));
  for (size_t f = 0; f < 7; ++f) ASSERT_TRUE(chain.placed(f)) << f;
  EXPECT_NEAR(chain.fit(0).rotation, 0, 1e-9);
  EXPECT_NEAR(chain.fit(0).shift.head<2>().norm(), 0, 1e-6);
  EXPECT_GT(std::abs(wrap_angle(chain.fit(1).rotation)), 0.5);
}

/// The mean of views is weighted by what each of them is known to.
TEST(SetUpChain, TheBetterViewCountsMore) {
  auto n = without_coordinates(35);
  for (Observation& o : n.survey.observations) {
    if (o.set_up == 3) o.sigma *= 10;
    if (o.set_up == 3 && o.to == "M11" && o.kind == K::slope_distance) o.value += 0.02;  // along north, two sigmas
  }
  const auto start = start_from_chain(chain_of(n.survey), 4, known_points(n, 4));
  const size_t m11 = 5;
  EXPECT_LT((start->points.at("M11") - n.truth[m11]).norm(), 0.001) << "20 mm / 100 / 3, not 20 mm / 4";
}

}  // namespace test_set_up_chain
}  // namespace plumbline::survey
