// Series of epochs with movements that were planted, against what was planted and against chance.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <limits>

#include "geometry/random.hpp"
#include "survey/epochs/epoch_axes.hpp"
#include "survey/epochs/epoch_series.hpp"

namespace plumbline::survey {
namespace test_epoch_series {

constexpr double kMillimetre = 1e-3;

/// Twelve markers 10 m apart, measured with 0.5 mm in each coordinate and a correlation between neighbours; every epoch
/// lies somewhere else.
struct Site {
  int epochs = 5;
  std::uint64_t seed = 1;
  double noise = 1;  ///< of what is stated
  Eigen::Vector3d velocity_of_m7 = Eigen::Vector3d::Zero();
  Eigen::Vector3d step_of_m4 = Eigen::Vector3d::Zero();  ///< from the third epoch on

  std::vector<DatedEpoch> make() const {
    Random random(seed, "series");
    const int n = 12;
    std::vector<DatedEpoch> result;
    Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(3 * n, 3 * n);
    const double s = 0.5 * kMillimetre;
    for (int i = 0; i < 3 * n; ++i)
      for (int j = 0; j < 3 * n; ++j) covariance(i, j) = s * s * (i == j ? 1 : i % 3 == j % 3 ? 0.2 : 0);
    const Eigen::MatrixXd root = covariance.llt().matrixL();
    for (int k = 0; k < epochs; ++k) {
      DatedEpoch e;
      e.name = "E" + std::to_string(k + 1), e.time = 30 * k;
      e.variance = {noise * (1 + 0.01 * random.normal(1)), 120, false};
      e.epoch.coordinates.resize(3 * n), e.epoch.covariance = covariance;
      Eigen::VectorXd error(3 * n);
      for (int i = 0; i < 3 * n; ++i) error[i] = random.normal(noise);
      error = root * error;
      const double turn = random.uniform(0, 6);
      const Eigen::Vector3d shift(random.uniform(-100, 100), random.uniform(-100, 100), random.uniform(-5, 5));
      for (int m = 0; m < n; ++m) {
        e.epoch.ids.push_back("M" + std::to_string(m + 1));
        Eigen::Vector3d p(10 * (m % 4), 8 * (m / 4) + 0.3 * m, 2 * (m % 3));
        if (m == 6) p += e.time * velocity_of_m7;
        if (m == 3 && k >= 2) p += step_of_m4;
        p += error.segment<3>(3 * m);
        e.epoch.coordinates.segment<3>(3 * m) =
            Eigen::Vector3d(p.x() * std::cos(turn) + p.y() * std::sin(turn),
                            -p.x() * std::sin(turn) + p.y() * std::cos(turn), p.z()) +
            shift;
      }
      result.push_back(std::move(e));
    }
    return result;
  }
};

const SeriesPoint& of(const EpochSeries& s, const std::string& id) {
  for (const SeriesPoint& p : s.points)
    if (p.id == id) return p;
  throw std::out_of_range(id);
}

TEST(EpochSeries, WhereNothingMovesNothingIsFound) {
  int moving = 0, moved = 0, unstable = 0, points = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const EpochSeries s = epoch_series(Site{5, seed}.make(), {});
    ASSERT_EQ(s.points.size(), 12u);
    EXPECT_EQ(s.degrees_of_freedom, 0) << "a priori variances hold";
    for (const SeriesPoint& p : s.points) {
      moving += p.moves, unstable += !p.stable, points += 1;
      for (const auto& at : p.at) moved += at.moved;
    }
  }
  // 480 points, 1920 movements at 0.1 %; a point leaves the datum in about one series of twenty.
  EXPECT_LE(moving, 4);
  EXPECT_LE(moved, 10);
  EXPECT_LE(unstable, 10);
}

TEST(EpochSeries, AVelocityIsFoundWithItsUncertainty) {
  double sum = 0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  const int trials = 60;
  for (int seed = 1; seed <= trials; ++seed) {
    Site site{6, static_cast<std::uint64_t>(seed)};
    site.velocity_of_m7 = {0, 0, -0.04 * kMillimetre};  // a day: 6 mm over the series
    const EpochSeries s = epoch_series(site.make(), {});
    const SeriesPoint& p = of(s, "M7");
    EXPECT_TRUE(p.moves) << seed;
    EXPECT_FALSE(p.stable) << seed;
    EXPECT_FALSE(p.uneven()) << seed;
    EXPECT_FALSE(of(s, "M1").moves && of(s, "M2").moves && of(s, "M3").moves) << seed;
    const Eigen::Vector3d off = (p.velocity - site.velocity_of_m7).cwiseQuotient(p.velocity_sigma);
    sum += off.squaredNorm();
    mean += (p.velocity - site.velocity_of_m7) / trials;
  }
  EXPECT_NEAR(sum / (3 * trials), 1, 0.3);  // three standard deviations of a mean of 180 squares
  EXPECT_LT(mean.norm(), 0.003 * kMillimetre);
}

TEST(EpochSeries, AStepIsUnevenAndReachesItsLevels) {
  Site site;
  site.epochs = 6;
  site.step_of_m4 = {6 * kMillimetre, 0, 0};
  SeriesOptions options;
  options.warning_level = 4 * kMillimetre, options.alarm_level = 7 * kMillimetre;
  const EpochSeries s = epoch_series(site.make(), options);
  const SeriesPoint& p = of(s, "M4");
  ASSERT_EQ(p.at.size(), 5u);
  EXPECT_FALSE(p.at[0].moved);
  for (size_t k = 1; k < 5; ++k) {
    EXPECT_TRUE(p.at[k].moved);
    EXPECT_NEAR(p.at[k].movement.norm(), 6 * kMillimetre, 3 * kMillimetre);
    EXPECT_NE(p.at[k].warning, Level::below);
    EXPECT_NE(p.at[k].alarm, Level::reached);
  }
  EXPECT_EQ(p.at[0].warning, Level::below);
  EXPECT_TRUE(p.uneven());
  EXPECT_FALSE(of(s, "M5").uneven());
}

/// Readings twice as noisy as stated, in all epochs or in one, are no movements.
TEST(EpochSeries, NoisierThanStatedIsPooledOrOfItsEpoch) {
  int moved = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Site site{5, seed, 2};
    const EpochSeries s = epoch_series(site.make(), {});
    EXPECT_NEAR(s.sigma0, 2, 0.1);
    EXPECT_GT(s.degrees_of_freedom, 400);
    EXPECT_LE(s.bartlett, s.bartlett_critical);
    for (const SeriesPoint& p : s.points) moved += p.moves;
  }
  EXPECT_LE(moved, 3);
  std::vector<DatedEpoch> one = Site{5, 3}.make();
  one[2].variance.sigma0 = 2;
  const EpochSeries s = epoch_series(one, {});
  EXPECT_GT(s.bartlett, s.bartlett_critical);
  EXPECT_DOUBLE_EQ(s.factors[2], 4);
  EXPECT_DOUBLE_EQ(s.factors[1], 1);
}

/// With two epochs the movements are those of the comparison of two.
TEST(EpochSeries, OfTwoIsTheComparisonOfTwo) {
  Site site{2, 7};
  site.velocity_of_m7 = {0, 0, 0.2 * kMillimetre};
  const std::vector<DatedEpoch> epochs = site.make();
  const EpochSeries s = epoch_series(epochs, {});
  const Comparison c = compare_epochs(epochs[0].epoch, epochs[1].epoch, {});
  for (const Movement& m : c.movements) {
    const SeriesPoint& p = of(s, m.id);
    EXPECT_EQ(p.stable, m.stable) << m.id;
    EXPECT_LT((p.at.at(0).movement - m.movement).norm(), 1e-6) << m.id;
    EXPECT_LT((p.at[0].sigma - m.sigma).norm(), 1e-3 * m.sigma.norm()) << m.id;
    EXPECT_EQ(p.misfit_critical, 0);
  }
}

TEST(EpochSeries, RefusesWhatIsNoSeries) {
  std::vector<DatedEpoch> epochs = Site{3, 1}.make();
  EXPECT_THROW(epoch_series({epochs[0]}, {}), std::runtime_error);
  std::swap(epochs[0], epochs[1]);
  EXPECT_THROW(epoch_series(epochs, {}), std::runtime_error) << "times";
  std::swap(epochs[0], epochs[1]);
  SeriesOptions options;
  options.stable = {"M1", "M99"};
  EXPECT_THROW(epoch_series(epochs, options), std::runtime_error);
}

/// Two points that carry the datum cannot move across their line, and one that carries it cannot move at all: what
/// coordinates of a map leave there is rounding of 1e-9 m, and its variance is nothing.
TEST(EpochSeries, FewPointsThatCarryTheDatumDoNotMoveByRounding) {
  int moved = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    std::vector<DatedEpoch> epochs = Site{5, seed}.make();
    for (DatedEpoch& e : epochs)
      for (Eigen::Index i = 0; i < e.epoch.coordinates.size(); i += 3)
        e.epoch.coordinates.segment<3>(i) += Eigen::Vector3d(32400000, 5700000, 400);
    SeriesOptions options;
    options.stable = {"M1", "M7"};
    const EpochSeries s = epoch_series(epochs, options);
    for (const char* id : {"M1", "M7"}) {
      const SeriesPoint& p = of(s, id);
      moved += p.moves + p.uneven();
      for (const auto& at : p.at) moved += at.moved;
    }
    options.stable = {"M1"}, options.free_motions = 3;
    for (DatedEpoch& e : epochs)  // of levelled heights
      for (Eigen::Index i = 0; i < e.epoch.coordinates.size(); ++i)
        if (i % 3 != 2) e.epoch.coordinates[i] = std::numeric_limits<double>::quiet_NaN();
    const EpochSeries lift = epoch_series(epochs, options);
    EXPECT_TRUE(lift.seen_once.empty());
    EXPECT_FALSE(of(lift, "M1").moves || of(lift, "M1").at.back().moved) << seed;
    EXPECT_EQ(of(lift, "M1").velocity.z(), 0);
  }
  EXPECT_LE(moved, 3);  // of 480 tests at 0.1 %
}

/// A point that was named to carry the datum and moved is told: all others would seem to move against it.
TEST(EpochSeries, ANamedPointThatMovedIsTold) {
  Site site;
  site.velocity_of_m7 = {0.2 * kMillimetre, 0, 0};
  SeriesOptions options;
  options.stable = {"M1", "M4", "M7", "M12"};
  const EpochSeries s = epoch_series(site.make(), options);
  EXPECT_EQ(s.contradicted, std::vector<std::string>{"M7"});
  EXPECT_EQ(s.stable, options.stable);
  site.velocity_of_m7.setZero();
  EXPECT_TRUE(epoch_series(site.make(), options).contradicted.empty());
}

/// Velocities go with them: DT06-01-2024 of an RW5 file is the first of June.
TEST(EpochSeries, DatesAreReadAsTheirFormatsHaveThem) {
  for (const char* date : {"2024-06-01", "01.06.2024", "06-01-2024", "2024-06-01T10:20:30"})
    EXPECT_EQ(day_of_date(date), 19875) << date;
  for (const char* none : {"", "10-Feb-93 08:23", "2024", "13.13.2024"}) EXPECT_FALSE(day_of_date(none)) << none;
}

/// What an epoch holds was not measured in it: the others are compared, and that is said; before, the coordinate was
/// dropped from all of them without a word.
void hold(Epoch& epoch, Eigen::Index row) {
  epoch.covariance.row(row).setZero();
  epoch.covariance.col(row).setZero();
}

TEST(EpochSeries, AnEpochThatHoldsACoordinateIsLeftOutForItAndSaid) {
  Site site{5, 4};
  site.velocity_of_m7 = {0.1 * kMillimetre, 0, -0.2 * kMillimetre};
  std::vector<DatedEpoch> epochs = site.make();
  const SeriesPoint before = of(epoch_series(epochs, {}), "M7");
  ASSERT_TRUE(before.moves);
  hold(epochs[2].epoch, 3 * 6 + 2);
  const EpochSeries s = epoch_series(epochs, {});
  const SeriesPoint& p = of(s, "M7");
  ASSERT_EQ(p.at.size(), 4u);  // the third epoch has its plan still
  EXPECT_TRUE(std::isnan(p.at[1].movement.z()));
  EXPECT_NEAR(p.at[1].movement.x(), before.at[1].movement.x(), 1e-5);
  EXPECT_NEAR(p.velocity.x(), before.velocity.x(), 3e-7);
  EXPECT_NEAR(p.velocity.z(), -0.2 * kMillimetre, 0.03 * kMillimetre);
  EXPECT_GT(p.velocity_sigma.z(), 1.0001 * before.velocity_sigma.z() - 1e-9);
  ASSERT_EQ(s.not_compared.size(), 1u);
  EXPECT_EQ(s.not_compared[0], "E3: H of M7 held there, not measured; compared in the other epochs only");
}

/// Held in height when the series began, and measured since: what it did in plan is against the first epoch, in height
/// against the second.
TEST(EpochSeries, APointHeldInHeightAtFirstKeepsItsPlan) {
  Site site{6, 4};
  site.velocity_of_m7 = {0.15 * kMillimetre, 0, -0.2 * kMillimetre};
  std::vector<DatedEpoch> epochs = site.make();
  const SeriesPoint whole = of(epoch_series(epochs, {}), "M7");
  hold(epochs[0].epoch, 3 * 6 + 2);
  const EpochSeries s = epoch_series(epochs, {});
  const SeriesPoint& p = of(s, "M7");
  EXPECT_EQ(p.first, 0u);
  EXPECT_EQ(p.reference, (std::array<size_t, 3>{0, 0, 1}));
  ASSERT_EQ(p.at.size(), 5u);
  EXPECT_EQ(p.at[0].epoch, 1u);
  EXPECT_TRUE(std::isnan(p.at[0].movement.z()));
  EXPECT_NEAR(p.at[4].movement.x(), whole.at[4].movement.x(), 1e-5);
  EXPECT_NEAR(p.at[4].movement.head<2>().norm(), 150 * 0.15 * kMillimetre, 2.5 * kMillimetre);
  EXPECT_NEAR(p.at[4].movement.z(), -120 * 0.2 * kMillimetre, 2.5 * kMillimetre);
  EXPECT_NEAR(p.velocity_sigma.x(), whole.velocity_sigma.x(), 1e-2 * whole.velocity_sigma.x());
  EXPECT_TRUE(p.moves);
  EXPECT_FALSE(p.uneven()) << p.misfit << " " << p.misfit_critical;
}

TEST(EpochSeries, ACoordinateHeldInAllButOneIsNotComparedAndSaid) {
  std::vector<DatedEpoch> epochs = Site{3, 4}.make();
  for (size_t k = 1; k < 3; ++k)
    for (Eigen::Index row : {3 * 6, 3 * 6 + 1}) hold(epochs[k].epoch, row);
  epochs[0].epoch.coordinates[3 * 8 + 2] = std::numeric_limits<double>::quiet_NaN();  // M9 has no height there
  const EpochSeries s = epoch_series(epochs, {});
  const SeriesPoint& p = of(s, "M7");
  ASSERT_EQ(p.at.size(), 2u);
  EXPECT_TRUE(std::isnan(p.at[0].movement.x()));
  EXPECT_TRUE(std::isfinite(p.at[0].movement.z()));
  ASSERT_EQ(s.not_compared.size(), 2u);
  EXPECT_EQ(s.not_compared[0], "E and N of M7: held in one epoch or more, not measured, and so compared in none");
  EXPECT_NE(s.not_compared[1].find("H of M9"), std::string::npos) << s.not_compared[1];
}

/// In a fixed frame, where all but the first epoch know one direction in the plan only: across it nobody saw a
/// velocity. Once the normal equations were solved as they stood, singular.
TEST(EpochSeries, ADirectionThatOneEpochLeavesFreeHasNoVelocity) {
  for (const double turn : {0.0, 0.6}) {
    const Eigen::Vector3d along(std::cos(turn), std::sin(turn), 0), velocity(0.1 * kMillimetre, 0.05 * kMillimetre, 0);
    std::vector<DatedEpoch> epochs(4);
    for (size_t k = 0; k < epochs.size(); ++k) {
      DatedEpoch& e = epochs[k];
      e.name = "E" + std::to_string(k), e.time = 30.0 * static_cast<double>(k);
      e.epoch.ids = {"P"};
      e.epoch.coordinates = Eigen::Vector3d(10, 20, 5) + e.time * velocity.dot(along) * along;
      const Eigen::Matrix3d plan =
          k == 0 ? Eigen::Matrix3d(Eigen::Vector3d(1, 1, 0).asDiagonal()) : Eigen::Matrix3d(along * along.transpose());
      e.epoch.covariance = 1e-8 * (plan + Eigen::Matrix3d(Eigen::Vector3d(0, 0, 1).asDiagonal()));
    }
    SeriesOptions options;
    options.free_motions = 0;
    const EpochSeries s = epoch_series(epochs, options);
    const SeriesPoint& p = of(s, "P");
    EXPECT_NEAR(p.velocity.z(), 0, 1e-9);
    EXPECT_TRUE(p.moves);
    if (turn == 0) {  // N is held in all but one epoch, and so compared in none
      EXPECT_NEAR(p.velocity.x(), 0.1 * kMillimetre, 1e-9);
      EXPECT_TRUE(std::isnan(p.velocity.y()));
      continue;
    }
    EXPECT_TRUE(std::isnan(p.velocity.x()) && std::isnan(p.velocity.y())) << p.velocity.transpose();
    // Two coordinates of four epochs: a line needs 1.2 s of its time's spread.
    EXPECT_NEAR(std::sqrt(p.velocity_statistic), velocity.dot(along) / (1e-4 / std::sqrt(4500.0)), 1e-3);
    ASSERT_FALSE(s.not_compared.empty());
    EXPECT_NE(s.not_compared.back().find("no velocity in every direction of P"), std::string::npos)
        << s.not_compared.back();
  }
}

TEST(ComparedAxes, AreThoseThatWereMeasuredTwice) {
  using enum Measured;
  const std::array<Measured, 3> all = {yes, yes, yes}, plan = {yes, yes, held}, none = {missing, missing, missing};
  EXPECT_EQ(compared_axes({all, all, plan}), (std::array{true, true, true}));
  EXPECT_EQ(compared_axes({all, plan}), (std::array{true, true, false}));
  EXPECT_EQ(compared_axes({all, none}), (std::array{false, false, false}));
  EXPECT_EQ(compared_axes({all}), (std::array{false, false, false}));
}

/// A point that is first seen later is compared with where it was then.
TEST(EpochSeries, PointsMayComeLater) {
  std::vector<DatedEpoch> epochs = Site{4, 2}.make();
  std::vector<char> keep(12, 1);
  keep[9] = 0;
  epochs[0].epoch = part_of(epochs[0].epoch, keep);
  const EpochSeries s = epoch_series(epochs, {});
  const SeriesPoint& p = of(s, "M10");
  EXPECT_EQ(p.first, 1u);
  EXPECT_EQ(p.at.size(), 2u);
  EXPECT_FALSE(p.stable);
}

}  // namespace test_epoch_series
}  // namespace plumbline::survey
