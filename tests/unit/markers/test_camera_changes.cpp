// Whether photographs are of one camera, and what their scatter makes of its covariance: simulated photographs of a
// board, so that the truth is known.
#include <gmock/gmock.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <random>

#include "base/text/name_order.hpp"
#include "geometry/statistics.hpp"
#include "photo/markers/calibration_parts.hpp"
#include "scene.hpp"

namespace plumbline::markers {
namespace test_camera_changes {

using testing::HasSubstr;

/// What a photograph has of its own.
struct Own {
  double zoom = 1;
  Eigen::Vector2d shift = {0, 0}, rows = {0, 0};  // [px], over the height
};
using OwnOf = std::function<Own(int photograph, const Eigen::Vector2d& drawn)>;

/// `count` photographs of a board of 10 × 7 points from all sides with 0.1 px of noise.
std::vector<CalibrationView> photographs(int count, unsigned seed, const OwnOf& own_of = {}) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0, 1);
  const BrownCamera camera = true_camera();
  std::vector<CalibrationView> views;
  for (int k = 0; k < count; ++k) {
    const double around = 2.4 * k + noise(random), out = 0.15 + 0.15 * std::abs(noise(random));
    const RigidTransform pose =
        look({0.1125 + out * std::cos(around), -0.075 + out * std::sin(around), 0.35 + 0.03 * noise(random)},
             {0.1125 + 0.03 * noise(random), -0.075 + 0.03 * noise(random), 0}, 0.7 * k);
    const Own own = own_of ? own_of(k, {noise(random), noise(random)}) : Own{};
    CalibrationView view;
    view.path = "IMG_" + std::to_string(k) + ".JPG";
    for (int i = 0; i < 70; ++i) {
      const Eigen::Vector3d board(0.025 * (i % 10), -0.025 * (i / 10), 0);
      const auto pixel = project(camera, pose * board);
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

/// A sound camera that goes round a twisted board from one side to the other.
std::vector<CalibrationView> walk_past_a_twisted_board(int count, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0, 1);
  std::vector<CalibrationView> views;
  for (int k = 0; k < count; ++k) {
    const double around = 1.6 * (k / (count - 1.0) - 0.5);
    const Eigen::Vector3d middle(0.1125, -0.075, 0);
    const RigidTransform pose =
        look(middle + Eigen::Vector3d(0.35 * std::sin(around), 0.1 * noise(random), 0.35 * std::cos(around)),
             middle + 0.02 * Eigen::Vector3d(noise(random), noise(random), 0), 0.3 * noise(random));
    CalibrationView view;
    view.path = "IMG_" + std::to_string(k) + ".JPG";
    for (int i = 0; i < 70; ++i) {
      const Eigen::Vector3d board(0.025 * (i % 10), -0.025 * (i / 10), 0);
      const double u = (board.x() - middle.x()) / 0.1125, v = (board.y() - middle.y()) / 0.075;
      const auto pixel = project(true_camera(), pose * (board + Eigen::Vector3d(0, 0, 3e-4 * u * v)));
      if (!pixel || pixel->minCoeff() < 20 || pixel->x() > 1580 || pixel->y() > 1180) continue;
      view.points.push_back({board, *pixel + 0.1 * Eigen::Vector2d(noise(random), noise(random)), 0.1});
    }
    if (view.points.size() > 20) views.push_back(view);
  }
  return views;
}

double normalised_square(const Calibration& c, const Eigen::MatrixXd& covariance) {
  const auto found = c.camera.parameters(), truth = true_camera().parameters();
  Eigen::VectorXd error(9);
  for (Eigen::Index k = 0; k < 9; ++k) error(k) = found[k] - truth[k];
  return error.dot(covariance.ldlt().solve(error)) / 9;
}

/// Of a single photograph and of a part of them: the parameters move as a calibration without them says.
const std::string kNoCause =
    ". None of the causes that are tried stands out; tags or a board that are bent, and photographs of which a program "
    "enlarged some, are not among them";

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
    const Eigen::VectorXd& predicted = all.truth.evidence.change_without[at];
    const auto before = all.camera.parameters(), after = without.camera.parameters();
    for (size_t k = 0; k < 9; ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      EXPECT_NEAR(predicted(i), after[k] - before[k], 0.08 * std::sqrt(all.formal_covariance(i, i)))
          << BrownCamera::names_of(LensModel::brown)[k];
    }
  }
}

/// Poses, kept unknowns and effects in one dense normal matrix, poses eliminated.
TEST(PhotographShares, AddUpToTheReducedNormalEquations) {
  constexpr int photographs = 3, kept = 5, effects = 2, own = 2;
  std::mt19937_64 random(2);
  std::normal_distribution<double> unit(0, 1);
  const auto drawn = [&](int rows, int columns) {
    Eigen::MatrixXd m(rows, columns);
    for (Eigen::Index i = 0; i < m.size(); ++i) m(i) = unit(random);
    return m;
  };
  std::vector<PhotographRows> all;
  Eigen::MatrixXd design = Eigen::MatrixXd::Zero(36, photographs * own + kept + effects);
  Eigen::VectorXd misclosure(36);
  for (int k = 0; k < 18; ++k) {
    all.push_back({k % photographs, {4, k % 4}, drawn(2, 2), drawn(2, own), drawn(2, 1), drawn(2, effects)});
    auto rows = design.middleRows<2>(2 * k);
    rows.middleCols(own * (k % photographs), own) = all.back().own;
    rows.col(photographs * own + 4) = all.back().kept.col(0),
                                 rows.col(photographs * own + k % 4) = all.back().kept.col(1);
    rows.rightCols<effects>() = all.back().effects;
    misclosure.segment<2>(2 * k) = all.back().misclosure;
  }
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(kept + effects, kept + effects);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(kept + effects);
  for (const PhotographShare& share : shares_of(photographs, kept, all)) {
    normal(share.columns, share.columns) += share.information;
    right(share.columns) += share.score;
  }
  const Eigen::MatrixXd poses = design.leftCols(photographs * own), rest = design.rightCols(kept + effects);
  const Eigen::MatrixXd without = rest - poses * poses.colPivHouseholderQr().solve(rest);
  EXPECT_LT((normal - without.transpose() * without).norm(), 1e-11);
  EXPECT_LT((right - without.transpose() * misclosure).norm(), 1e-11);
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
      told += !in_words(c.truth.empirical, c.truth.scatter).empty();
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
    EXPECT_GT(written, 0.7);
    EXPECT_LT(written, 1.5);
    EXPECT_GT(bootstrap, 0.6) << "two ways to the same";
    EXPECT_LT(bootstrap, 1.4);
  }
}

/// Nor is that of the corners alone believed: one factor for all, between what so few show and what is usual.
TEST(EmpiricalCovariance, OfFewPhotographsIsWhatIsUsual) {
  const auto factor = [](double rows) {
    const Calibration c = calibrate(photographs(5, 4,
                                                [&](int, const Eigen::Vector2d& drawn) {
                                                  return Own{1, {0, 0}, rows * drawn};
                                                }),
                                    1600, 1200, {});
    const EmpiricalCovariance& empirical = c.truth.empirical;
    EXPECT_FALSE(empirical.judged);
    EXPECT_LT((c.covariance - std::pow(empirical.factor, 2) * c.formal_covariance).norm(), 1e-12 * c.covariance.norm());
    return empirical.factor;
  };
  EXPECT_GT(factor(0), 1) << "sound ones";
  EXPECT_LT(factor(0), 2.4);
  EXPECT_GT(factor(5), 2.4) << "five times what these scatter by is seen in so few, too";
}

/// Photographs that follow one another have the same error, so they are worth fewer than they are.
TEST(EmpiricalCovariance, KnowsThatNeighboursErrAlike) {
  constexpr int trials = 16;
  for (const int alike : {1, 6}) {
    double written = 0, by_order = 0;
    for (int trial = 0; trial < trials; ++trial) {
      std::mt19937_64 random(static_cast<unsigned>(trial));
      std::normal_distribution<double> unit(0, 1);
      std::vector<Eigen::Vector2d> shifts(36);
      for (size_t k = 0; k < shifts.size(); ++k)
        shifts[k] = k % static_cast<size_t>(alike) ? shifts[k - 1] : Eigen::Vector2d(unit(random), unit(random));
      const auto views = photographs(36, 300 + static_cast<unsigned>(trial), [&](int k, const Eigen::Vector2d&) {
        return Own{1, {0, 0}, 1.5 * shifts[k]};
      });
      const Calibration c = calibrate(views, 1600, 1200, {});
      written += normalised_square(c, c.covariance) / trials;
      by_order += c.truth.empirical.by_order / trials;
    }
    RecordProperty("alike_" + std::to_string(alike), std::to_string(written) + " " + std::to_string(by_order));
    EXPECT_GT(written, 0.7) << alike;
    EXPECT_LT(written, alike > 1 ? 1.8 : 1.5) << alike;
    if (alike > 1)
      EXPECT_GT(by_order, 1.1) << "of six that err alike, which 36 photographs hardly show";
    else
      EXPECT_LT(by_order, 1.07);
  }
}

/// Parts that contradict each other say by how much the whole is too sure; what chance makes of nine is nothing.
TEST(CalibrationParts, ShowByHowMuchStandardDeviationsAreTooSmall) {
  const std::vector<CalibrationParts> sound = {{"a", 0, 0, 9, 9}, {"b", 0, 0, 30, 9}};
  EXPECT_EQ(contradiction_of(sound), nullptr);
  EXPECT_EQ(shown_too_small_by(sound), 1);
  // That of few parameters is worse, though its sum is smaller.
  const std::vector<CalibrationParts> apart = {{"a", 0, 0, 72, 9}, {"b", 0, 0, 50, 2}, {"c", 0, 0, 9, 9}};
  ASSERT_NE(contradiction_of(apart), nullptr);
  EXPECT_EQ(contradiction_of(apart)->split, "b");
  EXPECT_DOUBLE_EQ(shown_too_small_by(apart), 5);
  EXPECT_EQ(shown_too_small_by({}), 1);
}

TEST(CameraChange, OfSoundPhotographsIsNotFound) {
  int named = 0;
  for (unsigned seed = 1; seed <= 40; ++seed)
    named += calibrate(photographs(16, seed), 1600, 1200, {}).truth.change.has_value();
  EXPECT_LE(named, 1);
}

/// What all photographs have of a rolling shutter is no change of the camera.
TEST(CameraChange, OfPhotographsThatScatterIsNotFound) {
  int named = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const auto views = photographs(20, seed, [](int, const Eigen::Vector2d& drawn) {
      return Own{1, {0, 0}, 2 * drawn};
    });
    named += calibrate(views, 1600, 1200, {}).truth.change.has_value();
  }
  EXPECT_LE(named, 1);
}

TEST(CameraChange, IsNamedWithItsPhotographs) {
  const auto change_of = [](const OwnOf& own, std::string& words, std::string& as_two) {
    const auto views = photographs(24, 7, own);
    CalibrationOptions options;
    const Calibration c = calibrate(views, 1600, 1200, options);
    words.clear(), as_two.clear();
    if (!c.truth.change) return false;
    words = in_words(*c.truth.change, c.truth.evidence);
    as_two = as_two_cameras(views, options, c);
    return true;
  };
  std::string words, as_two;
  ASSERT_TRUE(change_of([](int k, const auto&) { return Own{k < 12 ? 1.0 : 1.02}; }, words, as_two));
  EXPECT_THAT(words, testing::AllOf(HasSubstr("from IMG_12.JPG on the principal distance is"),
                                    testing::ContainsRegex("(1.9|2.0). ± 0...? % longer"), HasSubstr("focus or zoom")));
  EXPECT_THAT(as_two, testing::ContainsRegex("as two cameras, fx (1499|1500)\\.. .* and 15(29|30)\\.. "));
  ASSERT_TRUE(change_of([](int k, const auto&) { return Own{0.98 + 0.04 * k / 23}; }, words, as_two));
  EXPECT_THAT(words, testing::AllOf(HasSubstr("from IMG_0.JPG to IMG_23.JPG, bit by bit, the principal distance is"),
                                    HasSubstr("% longer")));
  EXPECT_EQ(as_two, "");
  ASSERT_TRUE(change_of([](int k, const auto&) { return Own{k % 4 ? 1.0 : 1.02}; }, words, as_two));
  EXPECT_THAT(words,
              testing::AllOf(HasSubstr("in every fourth photograph (IMG_0.JPG, IMG_4.JPG"), HasSubstr("% longer")));
  // In no order at all.
  ASSERT_TRUE(
      change_of([](int k, const auto&) { return Own{k == 1 || k == 2 || k == 7 || k == 11 || k == 19 ? 1.02 : 1.0}; },
                words, as_two));
  EXPECT_THAT(words, HasSubstr("(IMG_1.JPG, IMG_2.JPG, IMG_7.JPG, IMG_11.JPG and 1 more)"));
}

/// Of a board whose points carry no numbers a mirrored picture is one of a board, too.
/// A board that was printed 0.6 % too wide was a rolling shutter, or pictures that a program stretched.
TEST(BoardAspect, IsToldFromACameraThatChanges) {
  const auto of_board = [](double by, const OwnOf& own_of = {}) {
    auto views = photographs(24, 5, own_of);
    for (CalibrationView& view : views)
      for (CalibrationPoint& point : view.points) point.board.x() /= 1 + by;
    const Calibration all = calibrate(views, 1600, 1200, {});
    return board_aspect(views, {}, all);
  };
  for (const double by : {0.006, -0.004}) {
    const auto aspect = of_board(by);
    ASSERT_TRUE(aspect) << by;
    EXPECT_NEAR(aspect->by, by, 4 * aspect->sigma + 1e-4);
    EXPECT_LT(aspect->sigma, 1e-3);
    EXPECT_THAT(in_words(*aspect), HasSubstr(by > 0 ? "% wider than its file" : "% narrower than its file"));
  }
  EXPECT_FALSE(of_board(0));
  EXPECT_FALSE(of_board(0, [](int k, const Eigen::Vector2d&) { return Own{k % 2 ? 1.02 : 1.0}; })) << "a zoom";
  EXPECT_FALSE(of_board(0, [](int, const Eigen::Vector2d& drawn) { return Own{1, {0, 0}, 5 * drawn}; })) << "rows";
}

/// A program had turned the pictures of a camera that was held upside down, in no order: the board lies in them as in
/// the others, and only the lens is the other way round. It was a stabiliser, or a lens that is loose.
TEST(CameraChange, PhotographsTurnedInNoOrderAreNamed) {
  for (const unsigned seed : {3u, 8u}) {
    auto views = photographs(24, seed);
    const std::vector<int> turned = seed == 3 ? std::vector<int>{1, 2, 5, 6, 11, 12, 16, 21, 22}
                                              : std::vector<int>{0, 3, 4, 7, 9, 13, 14, 15, 17, 19, 20, 23};
    for (const int k : turned)
      for (CalibrationPoint& point : views[k].points) point.pixel = Eigen::Vector2d(1599, 1199) - point.pixel;
    const Calibration all = calibrate(views, 1600, 1200, {});
    ASSERT_TRUE(all.truth.change) << seed << warnings_of(all.truth).size();
    const std::string words = in_words(*all.truth.change, all.truth.evidence);
    EXPECT_THAT(words, HasSubstr("pictures that a program turned by 180 degrees")) << seed;
    EXPECT_THAT(words, HasSubstr(" photographs (IMG_")) << seed;
  }
}

TEST(CameraChange, OfMirroredPhotographsOfAChessboardNamesTheMirror) {
  auto views = photographs(24, 7);
  for (std::size_t k = 1; k < views.size(); k += 2)
    for (auto& point : views[k].points)
      point.board.x() = 0.225 - point.board.x(), point.pixel.x() = 1599 - point.pixel.x();
  const Calibration c = calibrate(views, 1600, 1200, {});
  ASSERT_TRUE(c.truth.change);
  EXPECT_THAT(in_words(*c.truth.change, c.truth.evidence),
              testing::AllOf(HasSubstr("in every second photograph"), HasSubstr("pictures that a program mirrored")));
  // Moved by as much along the columns is not mirrored.
  const Calibration moved = calibrate(photographs(24, 7,
                                                  [](int k, const auto&) {
                                                    return Own{1, {0, k % 2 ? 20.0 : 0.0}};
                                                  }),
                                      1600, 1200, {});
  ASSERT_TRUE(moved.truth.change);
  EXPECT_THAT(in_words(*moved.truth.change, moved.truth.evidence),
              HasSubstr("pictures that a program cropped or moved"));
}

TEST(Scatter, IsNamedByItsCause) {
  const auto scatter_of = [](const OwnOf& own) {
    return calibrate(photographs(24, 9, own), 1600, 1200, {}).truth.scatter;
  };
  const auto rows = scatter_of([](int, const Eigen::Vector2d& d) { return Own{1, {0, 0}, 3 * d}; });
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].kind, Strengths::rows);
  EXPECT_NEAR(rows[0].rms, 3, 1.2);
  const auto point = scatter_of([](int, const Eigen::Vector2d& d) { return Own{1, 8 * d, {0, 0}}; });
  ASSERT_EQ(point.size(), 1U);
  EXPECT_EQ(point[0].kind, Strengths::principal_point);
  EXPECT_NEAR(point[0].rms, 8, 3);
  const auto focus = scatter_of([](int, const Eigen::Vector2d& d) { return Own{1 + 0.01 * d.x()}; });
  ASSERT_EQ(focus.size(), 1U);
  EXPECT_EQ(focus[0].kind, Strengths::focus);
  EXPECT_NEAR(focus[0].rms, 0.01, 0.004);
  // Two at once: nothing but these is named.
  const auto both = scatter_of([](int k, const Eigen::Vector2d& d) {
    return Own{1 + 0.02 * std::sin(7.0 * k), {0, 0}, 2 * d};
  });
  ASSERT_FALSE(both.empty());
  for (const Scatter& cause : both) EXPECT_TRUE(cause.kind == Strengths::focus || cause.kind == Strengths::rows);
}

/// What goes with one half of the photographs is scatter in a model without it; the model with it says both.
TEST(CameraChange, IsNamedBesideAScatterOfAnotherKind) {
  int named = 0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const auto views = photographs(20, seed, [](int k, const Eigen::Vector2d& d) {
      return Own{k < 10 ? 1.0 : 1.02, {0, 0}, 2 * d};
    });
    const Calibration c = calibrate(views, 1600, 1200, {});
    if (!c.truth.change) continue;
    EXPECT_TRUE(c.truth.change->what_is_clear);
    EXPECT_EQ(c.truth.change->what, CameraChange::What::focus);
    EXPECT_NEAR(c.truth.change->by(0), 0.02, 3.5 * c.truth.change->sigma(0));
    EXPECT_EQ(warnings_of(c.truth).size(), 1U) << "and nothing else is blamed for it";
    ++named;
  }
  EXPECT_GE(named, 5);
}

/// Eight photographs have but 56 splits into three and five: a permutation test cannot reach one in a thousand.
TEST(CameraChange, OfEightPhotographsIsNamed) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const Calibration c =
        calibrate(photographs(8, seed, [](int k, const auto&) { return Own{k < 4 ? 1.0 : 1.03}; }), 1600, 1200, {});
    ASSERT_TRUE(c.truth.change) << seed;
    EXPECT_EQ(c.truth.change->what, CameraChange::What::focus);
    EXPECT_EQ(c.truth.change->split, CameraChange::Split::from_on);
    EXPECT_NEAR(c.truth.change->by(0), 0.03, 3.5 * c.truth.change->sigma(0) + 1e-3);
  }
}

/// A camera that is the same in all photographs, past a board that is twisted by 0.3 mm.
TEST(CameraChange, IsNotBlamedWherePlacesExplainIt) {
  int blamed = 0;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const Calibration c = calibrate(walk_past_a_twisted_board(20, seed), 1600, 1200, {});
    blamed += c.truth.change && !c.truth.change->or_place;
  }
  EXPECT_EQ(blamed, 0);
}

TEST(Names, AreSortedByTheirNumbers) {
  EXPECT_TRUE(text::before_by_name("2.jpg", "10.jpg"));
  EXPECT_FALSE(text::before_by_name("10.jpg", "2.jpg"));
  EXPECT_TRUE(text::before_by_name("a/IMG_009.JPG", "a/IMG_0010.JPG"));
  EXPECT_TRUE(text::before_by_name("a1", "a1b"));
  EXPECT_FALSE(text::before_by_name("x", "x"));
  EXPECT_TRUE(text::before_by_name("IMG_1a.jpg", "IMG_02.jpg")) << "a number ends where its digits do";
  EXPECT_FALSE(text::before_by_name("a10_2b.jpg", "a010_1.jpg"));
}

/// What hides in the scatter is said: silence would claim that nothing changed.
TEST(CameraChanges, WhatCannotBeToldIsSaid) {
  CameraTruth truth;
  truth.focal_length = 1000;
  truth.evidence.parameters = {0, 1};
  truth.empirical.judged = true, truth.empirical.photographs = 14, truth.empirical.factor = 1;
  truth.empirical.written = Eigen::Vector2d(2 * 2, 5 * 5).asDiagonal();
  EXPECT_NEAR(hidden_focus_change(truth), 8 * 0.002, 1e-12);
  EXPECT_THAT(warnings_of(truth), testing::IsEmpty()) << "1.6 % is not worth a warning of its own";
  truth.empirical.written(0, 0) = 5 * 5;
  EXPECT_THAT(warnings_of(truth),
              testing::ElementsAre("the photographs do not tell whether focus or zoom changed among them by less than "
                                   "about 4 %"));
  truth.empirical.factor = 4;
  ASSERT_EQ(warnings_of(truth).size(), 1u);
  EXPECT_THAT(warnings_of(truth)[0], testing::AllOf(testing::HasSubstr("scatter 4.0 times"),
                                                    testing::HasSubstr("less than about 4 % is hidden by it")));
  truth.empirical.judged = false;
  EXPECT_EQ(hidden_focus_change(truth), 0);
  EXPECT_THAT(warnings_of(truth), testing::IsEmpty()) << "calibrations say that 14 are too few";
  truth.empirical.photographs = 2, truth.empirical.factor = 1;
  EXPECT_THAT(warnings_of(truth),
              testing::ElementsAre(testing::HasSubstr("how two photographs scatter cannot be told")));
  truth.evidence.parameters.clear();
  EXPECT_THAT(warnings_of(truth), testing::IsEmpty()) << "a camera that is given";
}

/// Every cause and every split in words, each by itself.
TEST(CameraChanges, EveryChangeHasItsWords) {
  using Split = CameraChange::Split;
  using What = CameraChange::What;
  CameraEvidence evidence;
  for (const char* name : {"a1", "a2", "a3", "a4", "a5", "a6", "a7", "a8", "a9", "b"}) evidence.paths.push_back(name);
  CameraChange change;
  change.second = {3, 4, 5, 6};
  change.split_is_clear = change.what_is_clear = true;
  const auto vector = [](std::vector<double> v) -> Eigen::VectorXd {
    return Eigen::Map<Eigen::VectorXd>(v.data(), static_cast<Eigen::Index>(v.size()));
  };
  const auto said = [&](What what, std::vector<double> by, std::vector<double> sigma, bool sized) {
    change.what = what, change.by = vector(by), change.sigma = vector(sigma), evidence.object_is_known = sized;
    return in_words(change, evidence);
  };
  const std::string from = "from a4 on ", lies = from + "the principal point lies elsewhere";
  EXPECT_EQ(said(What::focus, {0.0201}, {0.0005}, true),
            from + "the principal distance is 2.01 ± 0.05 % longer: focus or zoom");
  EXPECT_EQ(said(What::focus, {-0.0201}, {0.0005}, true),
            from + "the principal distance is 2.01 ± 0.05 % shorter: focus or zoom");
  EXPECT_EQ(said(What::focus, {0.0201}, {0.0005}, false), from + "the principal distance is longer: focus or zoom");
  EXPECT_EQ(said(What::aspect, {-0.03}, {0.001}, true),
            from + "fx is 3.00 ± 0.10 % shorter against fy: pictures that a program stretched");
  EXPECT_EQ(said(What::principal_point, {12.34, -5.68}, {1.24, 0.96}, true),
            lies +
                " by 12.3 ± 1.2, -5.7 ± 1.0 px: pictures that a program cropped or moved, a stabiliser, or a board "
                "that was bent otherwise");
  EXPECT_EQ(said(What::principal_point, {12.34, -5.68}, {1.24, 0.96}, false),
            lies + ": pictures that a program cropped or moved, a stabiliser, or a board that was bent otherwise");
  change.or_mirrored = true;
  EXPECT_EQ(said(What::principal_point, {12.34, -0.68}, {1.24, 0.96}, true),
            lies +
                " by 12.3 ± 1.2, -0.7 ± 1.0 px: pictures that a program mirrored, cropped or moved, a stabiliser, or a "
                "board that was bent otherwise");
  change.or_mirrored = false;
  EXPECT_EQ(said(What::distortion, {-0.0214, 0.5}, {0.0032, 0.1}, true),
            from +
                "the distortion is another (k1 by -0.021 ± 0.003): another lens or setting of it, pictures that a "
                "program changed, or a board that was bent otherwise");
  EXPECT_EQ(said(What::undistorted, {0.1}, {0.01}, true),
            from + "the distortion is gone: pictures that a program freed of it");
  EXPECT_EQ(said(What::turned, {1, 2}, {0.5, 0.25}, true),
            lies + " by 1.0 ± 0.5, 2.0 ± 0.2 px: pictures that a program turned by 180 degrees");
  const std::string other = ": another body or lens, a zoom, or pictures that a program changed";
  // Three standard deviations, of each; the second of a pair counts as the first does.
  const std::vector<double> ones{0.01, 1, 1, 0.01, 0.01};
  EXPECT_EQ(said(What::several, {0.029, 2.9, 2.9, 0.029, 0.029}, ones, true), from + "the camera is another" + other);
  EXPECT_EQ(said(What::several, {0.031, 0, 3.1, 0, 0.031}, ones, true),
            from +
                "the camera is another (principal distance 3.10 ± 1.00 % longer, principal point elsewhere by 0.0 ± "
                "1.0, 3.1 ± 1.0 px, another distortion (k1 by +0.000 ± 0.010))" +
                other);
  EXPECT_EQ(said(What::several, {0, -3.1, 0, -0.031, 0}, ones, false),
            from + "the camera is another (principal point elsewhere, another distortion)" + other);

  const auto split = [&](Split which, int period) {
    change.split = which, change.period = period;
    const std::string all = said(What::undistorted, {0.1}, {0.01}, true);
    return all.substr(0, all.find(" the distortion"));
  };
  const std::string list = " (a4, a5, a6, a7)";
  EXPECT_EQ(split(Split::drift, 0), "from a1 to b, bit by bit,");
  EXPECT_EQ(split(Split::every, 2), "in every second photograph" + list);
  EXPECT_EQ(split(Split::every, 3), "in every third photograph" + list);
  EXPECT_EQ(split(Split::every, 4), "in every fourth photograph" + list);
  EXPECT_EQ(split(Split::some, 0), "in 4 photographs" + list);
  change.second.push_back(8);
  EXPECT_EQ(split(Split::some, 0), "in 5 photographs (a4, a5, a6, a7 and 1 more)");
  change.split = Split::upside_down;
  EXPECT_EQ(
      said(What::turned, {1, 2}, {0.5, 0.25}, true),
      "in the 5 photographs that are held upside down against the others (a4, a5, a6, a7 and 1 more) the principal "
      "point lies elsewhere by 1.0 ± 0.5, 2.0 ± 0.2 px: pictures that a program turned by 180 degrees, or a "
      "board or tags that are not as the model has them");
  for (const auto which : {Split::from_on, Split::drift, Split::every, Split::some, Split::upside_down}) {
    change.split = which;
    EXPECT_EQ(divides(change), which != Split::drift);
  }

  // What is not told apart is not named.
  change.split = Split::from_on, change.split_is_clear = false;
  EXPECT_EQ(
      said(What::focus, {0.02}, {0.001}, false),
      "in part of the photographs, which they do not tell clearly (most likely from a4 on) the principal distance "
      "is longer: focus or zoom");
  change.split_is_clear = true, change.what_is_clear = false;
  change.causes = {{What::several, 0.4}, {What::focus, 0.3}, {What::aspect, 0.051}, {What::turned, 0.049}};
  EXPECT_EQ(said(What::focus, {0.02}, {0.001}, true),
            from +
                "the camera is another; what of it changed these photographs do not tell (the principal distance or "
                "fx against fy)");
  change.causes = {
      {What::principal_point, 0.5}, {What::distortion, 0.2}, {What::undistorted, 0.1}, {What::turned, 0.1}};
  EXPECT_EQ(said(What::focus, {0.02}, {0.001}, true),
            from +
                "the camera is another; what of it changed these photographs do not tell (the principal point or the "
                "distortion or a program that took the distortion away or a program that turned the pictures)");
  change.causes.clear();
  EXPECT_EQ(said(What::focus, {0.02}, {0.001}, true),
            from + "the camera is another; what of it changed these photographs do not tell");
  change.or_place = true;
  EXPECT_EQ(said(What::focus, {0.02}, {0.001}, true),
            from +
                "the photographs tell another camera, and they were taken place after place in that order: either "
                "the camera changed, or the board or the tags are not as the model has them");
}

/// Every cause of scatter in words; from where on it is told.
TEST(CameraChanges, EveryScatterHasItsWords) {
  EmpiricalCovariance empirical;
  empirical.judged = true, empirical.photographs = 20, empirical.factor = 2.96;
  EXPECT_EQ(in_words(empirical, {}), "") << "up to 3 without a cause";
  empirical.factor = 3.04;
  const std::string first =
      "the 20 photographs scatter 3.0 times as far as their corners allow: the standard "
      "deviations of the camera are made of that scatter";
  EXPECT_EQ(in_words(empirical, {}), first + kNoCause);
  empirical.by_order = 1.29, empirical.by_place = 1.2;
  EXPECT_EQ(in_words(empirical, {}), first + kNoCause) << "up to 1.3";
  empirical.by_order = 1.44;
  EXPECT_EQ(in_words(empirical, {}), first +
                                         " (of that 1.4 times because photographs that follow one another err "
                                         "alike)" +
                                         kNoCause);
  empirical.by_place = 1.56;
  EXPECT_EQ(in_words(empirical, {}), first +
                                         " (of that 1.6 times because photographs from places near to each other "
                                         "err alike)" +
                                         kNoCause);
  empirical.by_order = empirical.by_place = 1;
  const auto of = [&](Scatter scatter) {
    const std::string all = in_words(empirical, {scatter});
    return all.substr(std::min(all.size(), first.size()));
  };
  EXPECT_EQ(of({Strengths::focus, 0.0123}),
            ". It is that of a principal distance that differs by 1.23 % rms from photograph to photograph (an "
            "autofocus, a zoom, or photographs of another camera among them)");
  EXPECT_EQ(
      of({Strengths::principal_point, 2.34}),
      ". It is that of a principal point that moves by 2.3 px rms from photograph to photograph (a stabiliser, or "
      "a lens that is loose: switch it off)");
  EXPECT_EQ(of({Strengths::rows, 2.34}),
            ". It is that of rows read one after another while the camera moves, by 2.3 px rms from the first to the "
            "last (a rolling shutter: hold the camera still)");
  EXPECT_EQ(of({Strengths::rows, 2.34, true}),
            ". It is that of rows that are read one after another while the camera moves, or of a principal point that "
            "moves (a rolling shutter, or a stabiliser)");
  const std::string places =
      "places: photographs from one side tell another camera than those from the other (a board "
      "or tags that are not as the model has them, or a lens that is not)";
  EXPECT_EQ(of({Strengths::place, 1}), ". It is that of " + places);
  EXPECT_THAT(in_words(empirical, {{Strengths::rows, 2, true}, {Strengths::place, 1}}),
              testing::EndsWith("stabiliser); and of " + places));
  empirical.factor = 1.49;
  EXPECT_EQ(in_words(empirical, {{Strengths::place, 1}}), "") << "up to 1.5 with a cause";
  empirical.factor = 1.51;
  EXPECT_NE(in_words(empirical, {{Strengths::place, 1}}), "");
}

}  // namespace test_camera_changes
}  // namespace plumbline::markers
