// Whether the standard deviations of a calibration are true: corners measured in thirteen public sets of photographs
// (corners/, with where they are from), each set in two halves that are calibrated apart. The difference of all
// parameters over both covariances is chi-squared of as many degrees of freedom if these are true: 1 per parameter.
#include <gmock/gmock.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <numeric>
#include <optional>
#include <random>

#include "base/text/name_order.hpp"
#include "photo/markers/calibration_parts.hpp"
#include "test_support.hpp"

namespace plumbline::markers {
namespace test_calibration_sigmas {

struct MeasuredBoard {
  int width = 0, height = 0;
  std::vector<CalibrationView> views;
};

MeasuredBoard read_corners(const std::string& name) {
  std::ifstream file(std::filesystem::path(test::source_dir()) / "tests/golden/markers/corners" / (name + ".txt"));
  MeasuredBoard board;
  std::string text, path;
  while (file.peek() == '#') std::getline(file, text);
  double square = 0;
  file >> board.width >> board.height >> square;
  for (int count = 0; file >> path >> count;) {
    CalibrationView& view = board.views.emplace_back();
    view.path = path;
    for (int k = 0; k < count; ++k) {
      double column = 0, row = 0, x = 0, y = 0, sigma = 0;
      file >> column >> row >> x >> y >> sigma;
      view.points.push_back(
          {1e-6 * square * Eigen::Vector3d(column, -row, 0), 0.01 * Eigen::Vector2d(x, y), 0.01 * sigma});
    }
  }
  return board;
}

const std::vector<std::string> kSets = {"opencv_left",       "opencv_right",       "lifecam_1280",  "lifecam_480",
                                        "lifecam_old_1280",  "lifecam_old_480",    "stereo_left",   "stereo_right",
                                        "stereo_small_left", "stereo_small_right", "action_camera", "car_camera",
                                        "depth_camera"};

CalibrationOptions bent() {
  CalibrationOptions options;
  options.bend_sigma = 1e-3;
  return options;
}

struct Ratio {
  double written = 0, formal = 0;
};

double chi_squared(const Calibration& a, const Calibration& b, const Eigen::MatrixXd& covariance) {
  std::vector<int> estimated;
  for (int k = 0; k < BrownCamera::parameter_count; ++k)
    if (a.covariance(k, k) > 0 && b.covariance(k, k) > 0) estimated.push_back(k);
  const auto first = a.camera.parameters(), second = b.camera.parameters();
  Eigen::VectorXd d(std::ssize(estimated));
  for (Eigen::Index i = 0; i < d.size(); ++i) {
    const auto k = static_cast<std::size_t>(estimated[i]);
    d(i) = first[k] - second[k];
  }
  return d.dot(covariance(estimated, estimated).ldlt().solve(d)) / static_cast<double>(d.size());
}

/// Of the two halves, nothing where one of them cannot be calibrated.
std::optional<Ratio> between_halves(const MeasuredBoard& board, const std::vector<bool>& second) {
  std::array<std::vector<CalibrationView>, 2> halves;
  for (std::size_t k = 0; k < board.views.size(); ++k) halves[second[k]].push_back(board.views[k]);
  try {
    const Calibration a = calibrate(halves[0], board.width, board.height, bent()),
                      b = calibrate(halves[1], board.width, board.height, bent());
    return Ratio{chi_squared(a, b, a.covariance + b.covariance),
                 chi_squared(a, b, a.formal_covariance + b.formal_covariance)};
  } catch (const std::runtime_error&) {
    return std::nullopt;
  }
}

std::vector<bool> at_random(std::size_t count, unsigned seed) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::mt19937_64 random(seed);
  for (std::size_t k = count; k > 1; --k) std::swap(order[k - 1], order[random() % k]);
  std::vector<bool> second(count);
  for (std::size_t k = 0; k < count / 2; ++k) second[order[k]] = true;
  return second;
}

/// Where most of a set's photographs were taken from, from one end to the other: whether each lies beyond the middle.
std::vector<bool> by_distance_along_x(const MeasuredBoard& board) {
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t k = 0; k < board.views.size(); ++k) {
    double x = 0;
    for (const CalibrationPoint& p : board.views[k].points)
      x += p.pixel.x() / static_cast<double>(board.views[k].points.size());
    order.emplace_back(x, k);
  }
  std::sort(order.begin(), order.end());
  std::vector<bool> second(order.size());
  for (std::size_t k = order.size() / 2; k < order.size(); ++k) second[order[k].second] = true;
  return second;
}

std::vector<bool> late(const MeasuredBoard& board) {
  std::vector<std::size_t> order(board.views.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return text::before_by_name(board.views[a].path, board.views[b].path);
  });
  std::vector<bool> second(order.size());
  for (std::size_t k = order.size() / 2; k < order.size(); ++k) second[order[k]] = true;
  return second;
}

/// Set by set in halves at random, and means over the sets by split: at random, by the order of the names, by where the
/// board lies in the image. Of what the other end of a walk or the other side of the image has of its own a half says
/// nothing, so halves by place differ by more (calibrate_camera has all of it, and compares parts).
TEST(CalibrationSigmas, AreTrueOnPublicPhotographs) {
  const unsigned splits = std::getenv("PLUMBLINE_LONG") ? 16 : 3;
  std::array<Ratio, 3> mean;
  std::array<double, 3> worst{}, sets{};
  int held = 0;
  for (const std::string& name : kSets) {
    const MeasuredBoard board = read_corners(name);
    ASSERT_GE(board.views.size(), 10u) << name;
    std::array<Ratio, 3> of_set;
    std::array<double, 3> count{};
    const auto add = [&](std::size_t kind, const std::vector<bool>& second) {
      if (const auto ratio = between_halves(board, second))
        of_set[kind].written += ratio->written, of_set[kind].formal += ratio->formal, count[kind] += 1;
    };
    for (unsigned k = 0; k < splits; ++k) add(0, at_random(board.views.size(), k + 1));
    add(1, late(board));
    add(2, by_distance_along_x(board));
    std::string words = name;
    for (std::size_t kind = 0; kind < 3; ++kind) {
      if (count[kind] == 0) continue;
      const double written = of_set[kind].written / count[kind], formal = of_set[kind].formal / count[kind];
      mean[kind].written += written, mean[kind].formal += formal, sets[kind] += 1;
      worst[kind] = std::max(worst[kind], written);
      if (kind == 0) held += written > 0.7 && written < 1.5;
      words += " " + std::to_string(written) + " (" + std::to_string(formal) + ")";
    }
    RecordProperty(name, words);
  }
  for (std::size_t kind = 0; kind < 3; ++kind) {
    EXPECT_GE(sets[kind], 10) << kind;
    EXPECT_GT(mean[kind].written / sets[kind], 0.7) << kind;
    EXPECT_LT(mean[kind].written / sets[kind], kind == 2 ? 1.8 : 1.5) << kind;
    EXPECT_GT(mean[kind].formal / sets[kind], 3) << "of the corners alone they would be as good";
    EXPECT_LT(worst[kind], kind == 0 ? 2.6 : 5) << kind;
  }
  EXPECT_GE(held, 9) << "of 13 sets in halves at random";
}

}  // namespace test_calibration_sigmas
}  // namespace plumbline::markers
