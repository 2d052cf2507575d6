// Whether photographs are of one camera, and what their scatter makes of its covariance: simulated photographs of a
// board, so that the truth is known.
#include <gmock/gmock.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <numbers>
#include <random>

#include "geometry/statistics.hpp"
#include "markers/calibration_parts.hpp"
#include "scene.hpp"

namespace plumbline::markers {
namespace {

using testing::HasSubstr;

/// What a photograph has of its own.
struct Own {
  double zoom = 1;
  Eigen::Vector2d shift = {0, 0}, rows = {0, 0};  // [px], over the height
};
using OwnOf = std::function<Own(int photograph, const Eigen::Vector2d& drawn)>;

enum class Order { mixed, walking };

/// `count` photographs of a board of 10 × 7 points with 0.1 px of noise, from all sides in mixed order, or as somebody
/// takes them who walks past it from left to right, every fourth upright. `twist`: of the board, at its corners [m].
std::vector<CalibrationView> photographs(int count, unsigned seed, const OwnOf& own_of = {},
                                         Order order = Order::mixed, double twist = 0) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0, 1);
  const BrownCamera camera = true_camera();
  std::vector<CalibrationView> views;
  for (int k = 0; k < count; ++k) {
    const double around = 2.4 * k + noise(random), out = 0.15 + 0.15 * std::abs(noise(random));
    const double along = -0.22 + 0.44 * k / (count - 1) + 0.03 * noise(random);
    const Eigen::Vector3d target(0.1125 + 0.03 * noise(random), -0.075 + 0.03 * noise(random), 0);
    const double height = 0.35 + 0.03 * noise(random), beside = 0.12 * noise(random);
    const RigidTransform pose =
        order == Order::walking
            ? look({0.1125 + along, -0.075 + beside, height}, target,
                   0.15 * noise(random) + (k % 4 == 3 ? std::numbers::pi / 2 : 0))
            : look({0.1125 + out * std::cos(around), -0.075 + out * std::sin(around), height}, target, 0.7 * k);
    const Own own = own_of ? own_of(k, {noise(random), noise(random)}) : Own{};
    CalibrationView view;
    view.path = "IMG_" + std::to_string(k) + ".JPG";
    for (int i = 0; i < 70; ++i) {
      const Eigen::Vector3d board(0.025 * (i % 10), -0.025 * (i / 10), 0);
      const double u = (i % 10 - 4.5) / 4.5, v = (3 - i / 10) / 3.0;
      const auto pixel = project(camera, pose * (board + Eigen::Vector3d(0, 0, twist * u * v)));
      if (!pixel || pixel->minCoeff() < 20 || pixel->x() > 1580 || pixel->y() > 1180) continue;
      const Eigen::Vector2d middle(800, 600);
      const Eigen::Vector2d seen =
          middle + own.zoom * (*pixel - middle) + own.shift + own.rows * (pixel->y() / 1200 - 0.5);
      view.points.push_back({board, seen + 0.1 * Eigen::Vector2d(noise(random), noise(random)), 0.1});
    }
    if (view.points.size() > 20) views.push_back(view);
  }
  return views;
}

double normalised_square(const Calibration& c, const Eigen::MatrixXd& covariance) {
  const auto found = c.camera.parameters(), truth = true_camera().parameters();
  Eigen::VectorXd error(9);
  for (Eigen::Index k = 0; k < 9; ++k) error(k) = found[static_cast<size_t>(k)] - truth[static_cast<size_t>(k)];
  return error.dot(covariance.ldlt().solve(error)) / 9;
}

/// Of a single photograph and of a part of them: the parameters move as a calibration without them says.
TEST(PhotographShares, LeavingOneOutIsWhatACalibrationWithoutItGives) {
  const auto views = photographs(12, 3);
  const Calibration all = calibrate(views, 1600, 1200, {});
  for (const size_t left_out : {size_t{0}, size_t{5}, views.size() - 1}) {
    auto rest = views;
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(left_out));
    CalibrationOptions options;
    options.reject_above = 0;
    const Calibration without = calibrate(rest, 1600, 1200, options);
    const auto at =
        std::find(all.truth.evidence.members.begin(), all.truth.evidence.members.end(), static_cast<int>(left_out)) -
        all.truth.evidence.members.begin();
    const Eigen::VectorXd& predicted = all.truth.evidence.change_without[static_cast<size_t>(at)];
    const auto before = all.camera.parameters(), after = without.camera.parameters();
    for (size_t k = 0; k < 9; ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      EXPECT_NEAR(predicted(i), after[k] - before[k], 0.08 * std::sqrt(all.formal_covariance(i, i)))
          << BrownCamera::parameter_names[k];
    }
  }
}

TEST(PhotographShares, AddUpToTheReducedNormalEquations) {
  adjustment::PartitionedSystem system;
  system.kept_count = 5, system.eliminated_count = 3, system.eliminated_size = 2;
  system.groups = {"all"};
  std::mt19937_64 random(2);
  std::normal_distribution<double> unit(0, 1);
  std::vector<Eigen::MatrixXd> effects;
  const auto drawn = [&](int rows, int columns) {
    Eigen::MatrixXd m(rows, columns);
    for (Eigen::Index i = 0; i < m.size(); ++i) m(i) = unit(random);
    return m;
  };
  for (int k = 0; k < 18; ++k) {
    adjustment::ObservationRows rows;
    rows.eliminated = k % 3, rows.columns = {4, k % 4};
    rows.kept = drawn(2, 2), rows.own = drawn(2, 2), rows.misclosure = drawn(2, 1);
    system.observations.push_back(rows);
    effects.push_back(drawn(2, 2));
  }
  const auto shares = shares_of(system, effects);
  const auto reduced = adjustment::reduce(system);
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(7, 7);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(7);
  for (const PhotographShare& share : shares) {
    normal(share.columns, share.columns) += share.information;
    right(share.columns) += share.score;
  }
  EXPECT_LT((normal.topLeftCorner(5, 5) - reduced.normal).norm(), 1e-11);
  EXPECT_LT((right.head(5) - reduced.right).norm(), 1e-11);
  // With the effects as two more unknowns that are kept.
  auto wider = system;
  wider.kept_count = 7;
  for (size_t k = 0; k < effects.size(); ++k) {
    auto& rows = wider.observations[k];
    rows.columns.insert(rows.columns.end(), {5, 6});
    Eigen::MatrixXd kept(2, 4);
    kept << rows.kept, effects[k];
    rows.kept = kept;
  }
  EXPECT_LT((normal - adjustment::reduce(wider).normal).norm(), 1e-11);
}

/// Errors over the covariance that is stated, of photographs that scatter and of photographs that do not.
TEST(EmpiricalCovariance, CoversWhatPhotographsHaveInCommon) {
  constexpr int trials = 24;
  for (const bool scattered : {false, true}) {
    double formal = 0, written = 0, factor = 0, bootstrap = 0;
    int told = 0;
    for (int trial = 0; trial < trials; ++trial) {
      const auto views = photographs(20, 100 + static_cast<unsigned>(trial), [&](int, const Eigen::Vector2d& drawn) {
        Own own;
        if (scattered) own.rows = 1.5 * drawn;
        return own;
      });
      const Calibration c = calibrate(views, 1600, 1200, {});
      ASSERT_TRUE(c.truth.empirical.judged);
      formal += normalised_square(c, c.formal_covariance) / trials;
      written += normalised_square(c, c.covariance) / trials;
      factor += c.truth.empirical.factor / trials;
      bootstrap += c.truth.empirical.bootstrap_ratio / trials;
      if (const std::string words = in_words(c.truth.empirical, c.truth.scatter); !words.empty())
        ++told, RecordProperty((scattered ? "scattered_" : "sound_") + std::to_string(trial), words);
      EXPECT_GE((c.covariance - c.formal_covariance).eval().diagonal().minCoeff(), -1e-12);
    }
    RecordProperty(scattered ? "scattered" : "sound", std::to_string(formal) + " " + std::to_string(written) + " " +
                                                          std::to_string(factor) + " " + std::to_string(bootstrap));
    if (scattered) {
      EXPECT_GT(formal, 4) << "or there is nothing to mend";
    } else {
      EXPECT_NEAR(formal, 1, 0.4);
      EXPECT_LT(factor, 1.5) << "sound photographs are hardly charged for it";
      EXPECT_LE(told, 1) << "nor is it said of them";
    }
    EXPECT_GT(written, scattered ? 0.6 : 0.5);
    EXPECT_LT(written, 1.5);
    EXPECT_GT(bootstrap, 0.6) << "two ways to the same";
    EXPECT_LT(bootstrap, 1.4);
  }
}

TEST(EmpiricalCovariance, OfTooFewPhotographsIsNotJudged) {
  const Calibration c = calibrate(photographs(5, 4), 1600, 1200, {});
  EXPECT_FALSE(c.truth.empirical.judged);
  EXPECT_LT((c.covariance - c.formal_covariance).norm(), 1e-15);
}

CalibrationOptions bending() {
  CalibrationOptions options;
  options.bend_sigma = 1e-3;
  return options;
}

/// Of how many seeds a change is named.
int changes_named(int seeds, const std::function<std::vector<CalibrationView>(unsigned seed)>& of,
                  const CalibrationOptions& options = {}) {
  int named = 0;
  for (unsigned seed = 1; seed <= static_cast<unsigned>(seeds); ++seed) {
    const Calibration c = calibrate(of(seed), 1600, 1200, options);
    named += c.truth.change.has_value();
    if (c.truth.change)
      testing::Test::RecordProperty("seed_" + std::to_string(seed), in_words(*c.truth.change, c.truth.evidence));
  }
  return named;
}

TEST(CameraChange, OfSoundPhotographsIsNotFound) {
  EXPECT_LE(changes_named(25, [](unsigned seed) { return photographs(16, seed); }), 1);
  EXPECT_LE(changes_named(15, [](unsigned seed) { return photographs(24, seed, {}, Order::walking); }), 1);
}

/// What all photographs have of a rolling shutter is no change of the camera.
TEST(CameraChange, OfPhotographsThatScatterIsNotFound) {
  const OwnOf rows = [](int, const Eigen::Vector2d& drawn) { return Own{1, {0, 0}, 2 * drawn}; };
  for (const Order order : {Order::mixed, Order::walking})
    EXPECT_LE(changes_named(15, [&](unsigned seed) { return photographs(20, seed, rows, order); }), 1);
}

/// A board that is not quite plane looks the same from neighbouring places, and somebody who walks past it takes those
/// one after another.
TEST(CameraChange, IsNotFoundWhereASoundCameraWalksPastATwistedBoard) {
  const auto of = [](double twist) {
    return [=](unsigned seed) { return photographs(24, seed, {}, Order::walking, twist); };
  };
  EXPECT_LE(changes_named(20, of(1e-4), bending()), 1);
  EXPECT_LE(changes_named(10, of(4e-4), bending()), 1);
  EXPECT_LE(changes_named(20, of(2e-4)), 1) << "the board taken as flat";
}

TEST(Calibration, FindsTheTwistOfABoard) {
  const Calibration c = calibrate(photographs(24, 3, {}, Order::walking, 2e-4), 1600, 1200, bending());
  EXPECT_NEAR(std::abs(c.twist), 2e-4, 4 * c.twist_sigma);
  EXPECT_LT(c.twist_sigma, 5e-5);
  EXPECT_LT(c.sigma, 0.11);
}

/// A zoom is named in walking order as well.
TEST(CameraChange, IsFoundInWalkingOrder) {
  const OwnOf zoom = [](int k, const Eigen::Vector2d&) { return Own{k < 12 ? 1 : 1.02}; };
  int named = 0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const auto views = photographs(24, seed, zoom, Order::walking, 1e-4);
    Calibration c = calibrate(views, 1600, 1200, bending());
    ASSERT_TRUE(c.truth.change) << seed;
    try_two_cameras(views, bending(), c);
    ASSERT_TRUE(c.truth.change) << seed;
    const std::string words = in_words(*c.truth.change, c.truth.evidence);
    RecordProperty("walking_" + std::to_string(seed), words);
    named += words.starts_with("from IMG_12.JPG on the principal distance is ") &&
             words.find(" % longer: focus or zoom") != std::string::npos;
  }
  EXPECT_GE(named, 5);
}

TEST(CameraChange, OfTooFewPhotographsIsNotJudgedAndSaysSo) {
  const OwnOf zoom = [](int k, const Eigen::Vector2d&) { return Own{k < 5 ? 1 : 1.05}; };
  const Calibration few = calibrate(photographs(10, 2, zoom), 1600, 1200, {});
  EXPECT_FALSE(few.truth.change);
  EXPECT_THAT(warnings_of(few.truth),
              testing::Contains(HasSubstr("10 photographs are too few to see whether the camera changed (12 are")));
  const OwnOf later = [](int k, const Eigen::Vector2d&) { return Own{k < 6 ? 1 : 1.05}; };
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const Calibration enough = calibrate(photographs(12, seed, later), 1600, 1200, {});
    EXPECT_TRUE(enough.truth.change) << seed;
    EXPECT_THAT(warnings_of(enough.truth), testing::Not(testing::Contains(HasSubstr("too few to see"))));
  }
}

/// What changes makes the photographs scatter: nothing else is said to.
TEST(CameraChange, IsTheOnlyCauseThatIsNamed) {
  const OwnOf zoom = [](int k, const Eigen::Vector2d&) { return Own{k < 12 ? 1 : 1.05}; };
  const Calibration c = calibrate(photographs(24, 7, zoom), 1600, 1200, {});
  const std::vector<std::string> words = warnings_of(c.truth);
  ASSERT_EQ(words.size(), 2u);
  EXPECT_THAT(words[0], HasSubstr("focus or zoom"));
  EXPECT_THAT(words[1], testing::AllOf(HasSubstr("the 24 photographs scatter"), HasSubstr("made of that scatter"),
                                       testing::Not(HasSubstr("not quite")), testing::Not(HasSubstr("most like"))));
}

/// The size of a change is that of two adjustments, with its standard deviation.
TEST(CameraChange, HasTheSizeThatTwoCamerasGive) {
  const OwnOf zoom = [](int k, const Eigen::Vector2d& d) { return Own{k < 10 ? 1 : 1.02, {0, 0}, 1.5 * d}; };
  int named = 0, off = 0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const auto views = photographs(24, seed, zoom, Order::walking);
    Calibration c = calibrate(views, 1600, 1200, bending());
    if (!c.truth.change || c.truth.change->what != CameraChange::What::focus) continue;
    ++named;
    EXPECT_THAT(in_words(*c.truth.change, c.truth.evidence), HasSubstr("is another"));
    EXPECT_THAT(try_two_cameras(views, bending(), c), HasSubstr("into a folder of their own"));
    ASSERT_TRUE(c.truth.change);
    off += std::abs(c.truth.change->by.x() - 0.02) > 4 * c.truth.change->by_sigma.x();
    EXPECT_NEAR(c.truth.change->by.x(), 0.02, 0.02) << seed;
    EXPECT_THAT(in_words(*c.truth.change, c.truth.evidence), testing::ContainsRegex("is [0-9.]+ \u00b1 [0-9.]+ %"));
  }
  EXPECT_GE(named, 3);
  EXPECT_LE(off, 1);
}

TEST(CameraChange, IsTakenBackWhereTwoCamerasFitNoBetter) {
  Calibration c = calibrate(photographs(24, 3), 1600, 1200, {});
  CameraChange change;
  for (int k = 12; k < 24; ++k) change.second.push_back(k);
  c.truth.change = change;
  EXPECT_THAT(try_two_cameras(photographs(24, 3), {}, c),
              testing::AllOf(HasSubstr("from IMG_12.JPG on something of the camera seemed to differ"),
                             HasSubstr("no better: they count as one"), testing::Not(HasSubstr("folder"))));
  EXPECT_FALSE(c.truth.change);
}

/// Halves of few photographs have too few to see how they scatter.
TEST(CalibrationParts, OfFewPhotographsThatScatterAgree) {
  int contradict = 0, compared = 0;
  for (const int count : {8, 9, 10, 11})
    for (unsigned seed = 1; seed <= 5; ++seed) {
      const auto views = photographs(count, seed, [](int, const Eigen::Vector2d& d) { return Own{1, {0, 0}, 1.5 * d}; });
      for (const CalibrationParts& parts : compare_parts(views, {}, calibrate(views, 1600, 1200, {})))
        ++compared, contradict += parts.statistic > 4 * parts.freedom;
    }
  EXPECT_GE(compared, 30);
  EXPECT_LE(contradict, compared / 10) << "of " << compared;
}

TEST(CameraChange, IsNamedWithItsPhotographs) {
  const auto change_of = [](const OwnOf& own, std::string& words, std::string& as_two) {
    const auto views = photographs(24, 7, own);
    Calibration c = calibrate(views, 1600, 1200, {});
    words.clear(), as_two.clear();
    if (!c.truth.change) return false;
    as_two = try_two_cameras(views, {}, c);
    if (!c.truth.change) return false;
    words = in_words(*c.truth.change, c.truth.evidence);
    return true;
  };
  std::string words, as_two;
  ASSERT_TRUE(change_of([](int k, const auto&) { return Own{k < 12 ? 1.0 : 1.02}; }, words, as_two));
  EXPECT_THAT(words, testing::AllOf(HasSubstr("from IMG_12.JPG on the principal distance is"), HasSubstr("% longer"),
                                    HasSubstr("focus or zoom")));
  EXPECT_THAT(as_two, testing::ContainsRegex("as two cameras, fx (1499|1500)\\.. .* and 15(29|30)\\.. "));
  ASSERT_TRUE(change_of([](int k, const auto&) { return Own{0.98 + 0.04 * k / 23}; }, words, as_two));
  EXPECT_THAT(words, testing::AllOf(HasSubstr("from IMG_0.JPG to IMG_23.JPG, bit by bit, the principal distance is another"),
                                    HasSubstr("focus or zoom")));
  EXPECT_EQ(as_two, "");
  ASSERT_TRUE(change_of([](int k, const auto&) { return Own{k % 4 ? 1.0 : 1.02}; }, words, as_two));
  EXPECT_THAT(words,
              testing::AllOf(HasSubstr("in every fourth photograph (IMG_0.JPG, IMG_4.JPG"), HasSubstr("% longer")));
  // In no order at all.
  ASSERT_TRUE(
      change_of([](int k, const auto&) { return Own{k == 1 || k == 2 || k == 7 || k == 11 || k == 19 ? 1.05 : 1.0}; },
                words, as_two));
  EXPECT_THAT(words, HasSubstr("(IMG_1.JPG, IMG_2.JPG, IMG_7.JPG, IMG_11.JPG, ...)"));
}

/// A third of the photographs, in no order.
bool of_another_body(int k) { return k == 1 || k == 5 || k == 6 || k == 8 || k == 13 || k == 14 || k == 19 || k == 22; }

TEST(Scatter, IsNamedByItsCause) {
  struct Case {
    OwnOf own;
    Scatter::Kind kind;
    double rms;
  };
  const Case cases[] = {
      {[](int, const Eigen::Vector2d& d) { return Own{1, {0, 0}, 3 * d}; }, Scatter::Kind::rolling_shutter, 3},
      {[](int, const Eigen::Vector2d& d) { return Own{1, 8 * d, {0, 0}}; }, Scatter::Kind::principal_point, 8},
      {[](int, const Eigen::Vector2d& d) { return Own{1 + 0.01 * d.x()}; }, Scatter::Kind::focus, 0.01}};
  for (const Case& each : cases) {
    int first = 0, alone = 0;
    for (unsigned seed = 1; seed <= 8; ++seed) {
      const auto causes = calibrate(photographs(24, seed, each.own), 1600, 1200, {}).truth.scatter;
      if (causes.empty() || causes.front().kind != each.kind) continue;
      ++first, alone += causes.size() == 1;
      EXPECT_NEAR(causes.front().rms, each.rms, 0.5 * each.rms);
    }
    EXPECT_GE(first, 7) << static_cast<int>(each.kind);
    EXPECT_GE(alone, 6) << static_cast<int>(each.kind);
  }
}

/// A zoom in some photographs and rows that move: neither hides the other.
TEST(Scatter, HasEveryCauseThatAddsSomething) {
  int zoom = 0;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const auto views = photographs(24, seed, [](int k, const Eigen::Vector2d& d) {
      return Own{of_another_body(k) ? 1.02 : 1, {0, 0}, 1.6 * d};
    });
    const CameraTruth truth = calibrate(views, 1600, 1200, {}).truth;
    EXPECT_GT(rms_of(truth.scatter, Scatter::Kind::rolling_shutter), 0) << seed;
    zoom += truth.change ? truth.change->what == CameraChange::What::focus
                         : rms_of(truth.scatter, Scatter::Kind::focus) > 0;
  }
  EXPECT_GE(zoom, 5) << "of eight; before, none";
}

/// Of two that explain as much both are told.
TEST(Scatter, NamesTheRunnerUp) {
  EmpiricalCovariance empirical;
  empirical.judged = true, empirical.photographs = 20, empirical.factor = 3;
  EXPECT_THAT(in_words(empirical, {{Scatter::Kind::rolling_shutter, 1.5, 9, Scatter::Kind::principal_point, 4.2}}),
              testing::AllOf(HasSubstr("by 1.5 px rms from the first to the last"), HasSubstr("or nearly as much like "),
                             HasSubstr("moves by 4.2 px rms"), HasSubstr("Hold the camera still")));
}

/// Another body took a third of the photographs: its principal distance and point are others.
TEST(CameraChange, OfTwoBodiesInNoOrderIsFound) {
  int named = 0;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const auto views = photographs(24, seed, [](int k, const Eigen::Vector2d&) {
      return of_another_body(k) ? Own{1.05, {8, 0}, {0, 0}} : Own{};
    });
    const CameraTruth truth = calibrate(views, 1600, 1200, {}).truth;
    if (!truth.change) continue;
    const std::string words = in_words(*truth.change, truth.evidence);
    RecordProperty("bodies_" + std::to_string(seed), words);
    named += words.find("in 8 photographs (IMG_1.JPG, IMG_5.JPG, IMG_6.JPG, IMG_8.JPG, ...)") != std::string::npos;
  }
  EXPECT_GE(named, 7);
}

/// Of a principal point alone that is 8 px off single photographs do not say which have it: it is told as scatter.
TEST(Scatter, OfTwoPrincipalPointsIsNoRollingShutter) {
  int told = 0;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const auto views = photographs(24, seed, [](int k, const Eigen::Vector2d&) {
      return Own{1, of_another_body(k) ? Eigen::Vector2d(8, 0) : Eigen::Vector2d(0, 0), {0, 0}};
    });
    const CameraTruth truth = calibrate(views, 1600, 1200, {}).truth;
    std::string words;
    for (const std::string& text : warnings_of(truth)) words += text + " | ";
    RecordProperty("points_" + std::to_string(seed), words);
    told += words.find("principal point") != std::string::npos;
  }
  EXPECT_GE(told, 7);
}

TEST(Names, AreSortedByTheirNumbers) {
  EXPECT_TRUE(before_by_name("2.jpg", "10.jpg"));
  EXPECT_FALSE(before_by_name("10.jpg", "2.jpg"));
  EXPECT_TRUE(before_by_name("a/IMG_009.JPG", "a/IMG_0010.JPG"));
  EXPECT_TRUE(before_by_name("a1", "a1b"));
  EXPECT_FALSE(before_by_name("x", "x"));
}

}  // namespace
}  // namespace plumbline::markers
